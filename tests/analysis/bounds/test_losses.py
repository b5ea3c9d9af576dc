"""What bounds say is never lost, against all state classes of the net; and a check that rests on them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import Share
from dineros.analysis.bounds.losses import never_lost
from dineros.analysis.checks.overflow import Overflow
from dineros.analysis.model.queues import queues
from dineros.analysis.requirements.latencies import AskedLatency
from dineros.analysis.requirements.latency_bounds import latency_bound
from dineros.analysis.timed.exploring import explore_timed
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.analysis.timed_checks import boundedness
from dineros.analysis.timed_checks.boundedness import TimedBoundedness
from dineros.analysis.timed_checks.timed_check import check_timed
from dineros.metamodel import sym
from dineros.metamodel.errors import DinerosError
from tests.analysis.bounds.test_answers import chain
from tests.analysis.bounds.test_no_bound_is_too_low import drawn
from tests.support.timed_systems.counted import COUNTED
from tests.support.timed_systems.models import System, model_of


@pytest.mark.long
@pytest.mark.parametrize("seed", range(30))
def test_nothing_is_lost_that_is_proved_not_to_be(seed: int) -> None:
    try:
        subject = timed_base_subject(model_of(drawn(seed, most_threads=2), 0.01))
    except DinerosError as error:
        assert "on their way at once" in str(error)
        return
    found = explore_timed(subject.timed, Budget(states=20_000))
    names = subject.timed.untimed.transitions
    assert not never_lost(subject) & {names[transition] for transition in found.ways}


@pytest.mark.parametrize("number", COUNTED)
def test_counted_systems(number: int) -> None:
    subject = timed_base_subject(model_of(COUNTED[number].system, 0.01))
    excluded = never_lost(subject)
    for queue in queues(subject):
        if queue.kind == "subscriber" and excluded.issuperset(queue.drops):
            assert queue.load.split(".")[-3] not in COUNTED[number].lost


def large() -> System:
    """Return a chain of 12 callbacks beside 20 timers, which have more classes than can be built."""
    system = chain(12, 4, 100)
    for number in range(20):
        each = {
            **system["callbacks"][0],
            "name": f"tick{number}",
            "node": f"m{number}",
            "period": 50 + number,
        }
        system["callbacks"].append({**each, "script": [["work", 1, 2]]})
        system["nodes"][each["node"]] = {"threads": 1}
    return system


def test_a_check_that_cannot_build_all_classes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(boundedness, "PLAN", [replace(stage, time=0.01) for stage in boundedness.PLAN])
    monkeypatch.setattr(boundedness, "FAR", Share(time=0.01))
    questions = (TimedBoundedness(), Overflow())
    report = check_timed(model_of(large(), 0.001), Budget(seconds=100), questions=questions)
    proved = [each for each in report.proved if each.endswith("never overflows")]
    assert len(proved) == 2 * 11
    assert "bounds of response times" in report.by


def test_a_history_that_overflows_is_not_proved() -> None:
    subject = timed_base_subject(model_of(COUNTED[2].system, 0.01))
    excluded = never_lost(subject)
    found = {queue.kind: excluded.issuperset(queue.drops) for queue in queues(subject)}
    assert found == {"publisher": True, "subscriber": False}


def test_a_bound_of_a_property_that_no_search_decides() -> None:
    model = model_of(large(), 0.001)
    subject = timed_base_subject(model)

    def asked(text: str) -> Outcome:
        property = sym.Property(id="P", text=text)
        model.properties.append(property)
        bound = latency_bound(property)
        assert bound is not None
        return AskedLatency(property, bound, subject).answer(Budget(seconds=2))

    found = asked("c0 to c11 within 0.1")
    assert (found.status, found.by) == ("holds", "bounds of response times")
    assert found.reason.startswith("at most 0.0")
    assert asked("c11 responds within 0.05").status == "holds"
    assert asked("c0 to c11 within 0.02").status == "unknown"
