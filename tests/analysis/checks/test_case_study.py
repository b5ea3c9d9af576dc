"""What the case study must answer: the table of state spaces and the paper's four scenarios."""

from __future__ import annotations

import pytest

from case_study.build import build, build_one_topic
from dineros.analysis.answers.budget import Budget
from dineros.analysis.checks.check import check
from dineros.analysis.explicit import explore
from dineros.analysis.logic.ltl.verification import verify_ltl
from dineros.analysis.model.subject import Subject, base_subject, subject_of
from dineros.analysis.portfolio import plans
from dineros.analysis.portfolio.asking import find_enabled, find_marking
from dineros.analysis.portfolio.branching_time import check_ctl
from dineros.analysis.portfolio.methods.diagrams import LedByDiagram
from dineros.analysis.portfolio.scheduler import Turn
from dineros.analysis.reductions import reduce
from dineros.analysis.suggestions.capacities import suggest_capacities
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.analysis.witnesses.findings import Report
from dineros.analysis.witnesses.witness import Witness
from dineros.metamodel import sym
from dineros.metamodel.elements import find
from dineros.metamodel.settings import apply
from dineros.transformations.rules.phases import SignalVariant

MEMORY = Budget(1 << 30)
TABLE: dict[tuple[int, int, int], dict[SignalVariant, int]] = {
    (1, 0, 0): {"none": 432, "input-enabled": 4_942, "io-enabled": 30_016, "fully-enabled": 221_184},
    (1, 1, 0): {
        "none": 9_640,
        "input-enabled": 156_920,
        "io-enabled": 1_848_960,
        "fully-enabled": 4_935_680,
    },
    (1, 1, 1): {
        "none": 330_112,
        "input-enabled": 6_484_580,
        "io-enabled": 147_263_744,
        "fully-enabled": 169_017_344,
    },
}
VARIANTS: list[SignalVariant] = ["none", "input-enabled", "io-enabled", "fully-enabled"]


def case_study(*settings: str, objects: tuple[int, int, int] = (1, 1, 1)) -> sym.SystemModel:
    model = build()
    for color, tokens in zip(("Red", "Blue", "Green"), objects, strict=True):
        apply(model, f"{color}Objects.tokens={tokens}")
    for setting in settings:
        apply(model, setting)
    return model


@pytest.mark.long
@pytest.mark.parametrize("objects", TABLE)
@pytest.mark.parametrize("signals", VARIANTS)
def test_the_table(objects: tuple[int, int, int], signals: SignalVariant) -> None:
    expected = TABLE[objects][signals]
    net = subject_of(case_study(objects=objects), signals).net
    assert symbolic_state_space(net, MEMORY).markings == expected
    if expected < 200_000:
        assert explore(net, MEMORY).markings == expected


@pytest.mark.long
@pytest.mark.parametrize("signals", VARIANTS)
def test_inhibitor_arcs_count_the_same(signals: SignalVariant) -> None:
    net = subject_of(case_study(objects=(1, 1, 0)), signals, "inhibitor").net
    assert symbolic_state_space(net, MEMORY).markings == TABLE[(1, 1, 0)][signals]


@pytest.mark.long
@pytest.mark.parametrize("objects", TABLE)
def test_reduced_none_and_fully_enabled_count_the_same(objects: tuple[int, int, int]) -> None:
    sizes = {}
    for signals in ("none", "fully-enabled"):
        reduction = reduce(subject_of(case_study(objects=objects), signals).net, {"state_space_size"})
        sizes[signals] = symbolic_state_space(reduction.net, MEMORY).markings
        assert sizes[signals] * reduction.count_factor == TABLE[objects][signals]
    assert sizes["none"] == sizes["fully-enabled"]


def rules(report: Report) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for finding in report.findings:
        found.setdefault(finding.rule, []).append(finding.elements[0])
    return found


def test_the_untouched_model_is_fine() -> None:
    report = check(build(), MEMORY)
    assert report.unknown == []
    assert {finding.rule for finding in report.findings} == {"not-live", "not-reversible"}
    assert all(finding.severity == "note" for finding in report.findings)
    assert "8 home markings can always be reached" in report.proved
    assert sum("never overflows" in proved for proved in report.proved) == 11


# Scenario 1: more types of objects.


def test_one_colour_on_one_topic_never_overflows() -> None:
    report = check(case_study(objects=(10, 0, 0)), MEMORY)
    assert "queue-overflow" not in rules(report)
    assert report.unknown == []


def three_colours_on_one_topic() -> sym.SystemModel:
    model = build_one_topic()
    for colour in ("Red", "Blue", "Green"):
        find(model, f"{colour}Objects", sym.Place).tokens = 5
    for publisher in find(model, "LeftCellObjects", sym.TopicChannel).publishers:
        publisher.limit = 5
    return model


@pytest.mark.long
def test_three_colours_on_one_topic_overflow_at_the_subscriber() -> None:
    model = three_colours_on_one_topic()
    report = check(model, MEMORY)
    found = [finding for finding in report.findings if finding.rule == "queue-overflow"]
    (overflow,) = [finding for finding in found if finding.elements == ("LeftCellObjects", "ReqControlL")]
    assert overflow.message == (
        "subscriber queue of ReqControlL (topic LeftCellObjects) can overflow: a message is lost"
    )
    assert overflow.witness is not None
    replay(base_subject(model), overflow.witness)
    assert overflow.witness.steps[-1].text == (
        "subscriber queue of ReqControlL (topic LeftCellObjects) loses a message"
    )
    assert not any("SortRed" in element for finding in found for element in finding.elements)


@pytest.mark.long
def test_the_state_space_leads_to_what_no_search_comes_near(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plans, "WITNESS", [Turn(LedByDiagram())])
    model = build()
    find(model, "LeftCellObjects", sym.TopicChannel).subscribers[0].limit = 1
    report = check(model, MEMORY)
    assert report.unknown == []
    (overflow,) = [finding for finding in report.findings if finding.rule == "queue-overflow"]
    assert overflow.witness is not None
    replay(base_subject(model), overflow.witness)


def replay(subject: Subject, witness: Witness) -> list[int]:
    """Fire a witness by the plain firing rule; return its last marking."""
    marking = [int(tokens) for tokens in subject.net.initial]
    for step in witness.steps:
        marking = subject.net.fire(subject.transition_index[step.transition], marking)
    return marking


# Scenario 2: an unsatisfiable clause.


def test_an_unsatisfiable_clause() -> None:
    report = check(case_study("TSense.clause=Sensor & !Sensor"), MEMORY)
    found = rules(report)
    assert found["unsatisfiable-clause"] == ["TSense"]
    assert "'Sensor & !Sensor' of TSense of sensorics can never be true: Sensor and !Sensor" in (
        report.findings[0].message
    )
    assert found["service-never-returns"] == ["Pick", "SensorService"]
    assert found["service-never-called"] == ["EndControl", "Place"]
    assert found["unused-topic"] == ["UITopic"]
    assert found["dead-node-net"] == ["feedback"]


# Scenario 3: Danger and not Danger.


@pytest.mark.long
def test_danger_and_not_danger() -> None:
    model = case_study("TStop.clause=Danger & !Danger", objects=(1, 0, 0))
    assert "TStop" in rules(check(model, MEMORY))["dead-transition"]
    subject = subject_of(model)
    once_safe = 'G (Safe >= 1 -> G !fired("SensorService.client.safety.req"))'
    assert verify_ltl(subject.net, once_safe, subject.names).status == "holds"
    untouched = subject_of(case_study(objects=(1, 0, 0)))
    assert verify_ltl(untouched.net, once_safe, untouched.names).status == "violated"


# Scenario 4: temporal properties.


@pytest.mark.long
@pytest.mark.parametrize("objects", TABLE)
def test_every_state_can_still_finish_all_objects(objects: tuple[int, int, int]) -> None:
    subject = subject_of(case_study(objects=objects), "none")
    assert check_ctl(subject.net, f"AG EF (Shown >= {sum(objects)})", subject.names).status == "holds"
    verdict = check_ctl(subject.net, f"AG EF (Shown >= {sum(objects) + 1})", subject.names)
    assert verdict.status == "violated"


def test_picking_may_wait_for_ever_while_the_sensor_loop_runs() -> None:
    subject = subject_of(case_study(), "none")
    verdict = verify_ltl(subject.net, "G (PickReqL >= 1 -> F PickResL >= 1)", subject.names)
    assert verdict.status == "violated"
    loop = [subject.transition_text(transition) for transition in verdict.loop]
    assert {"TRetry", "TSense of server instance 1", "TUnsafe"} <= set(loop)
    assert not any("Pick" in step for step in loop)


# Beyond the paper.


@pytest.mark.long
def test_suggested_capacities_are_the_smallest() -> None:
    model = case_study(objects=(2, 1, 1))
    for capacity in suggest_capacities(model, MEMORY):
        assert capacity.needed is not None
        if capacity.needed > 1:
            assert capacity.witness is not None
            assert "loses a message" in capacity.witness.steps[-1].text
    needed = {str(c.queue): c.needed for c in suggest_capacities(model, MEMORY)}
    subscriber = "subscriber queue of ReqControlL (topic LeftCellObjects)"
    enough = needed[subscriber]
    assert enough is not None
    for limit, overflows in ((enough, False), (enough - 1, True)):
        changed = case_study(f"LeftCellObjects.subscriber.ReqControlL.limit={limit}", objects=(2, 1, 1))
        lost = rules(check(changed, MEMORY)).get("queue-overflow", [])
        assert ("LeftCellObjects" in lost) == overflows


def test_find_speaks_of_the_system_model() -> None:
    subject = subject_of(case_study(objects=(1, 0, 0)))
    answer = find_enabled(subject.net, "TShowResult", subject.names, MEMORY)
    assert answer.status == "reachable"
    assert answer.trace is not None
    assert subject.transition_text(answer.trace[-1]) == "TShowResult"
    assert find_marking(subject.net, "PickRun >= 2", subject.names, MEMORY).status == "unreachable"
    either = find_marking(subject.net, "Shown >= 1 | PickRun >= 2", subject.names, MEMORY)
    assert either.status == "reachable"
