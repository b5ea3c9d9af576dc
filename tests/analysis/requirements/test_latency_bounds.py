"""Properties that bound how long data takes."""

from __future__ import annotations

from fractions import Fraction

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.requirements.asking import question_of
from dineros.analysis.requirements.latencies import AskedLatency
from dineros.analysis.requirements.latency_bounds import LatencyBound, latency_bound
from dineros.analysis.timed.schedules import check_times
from dineros.analysis.timed.timed_subject import TimedSubject
from dineros.analysis.timed_checks.timed_check import check_timed
from dineros.metamodel import sym
from dineros.metamodel.elements import find
from tests.support.timed_systems.counted import CHAINS, COUNTED, RESPONSES
from tests.support.timed_systems.models import model_of

LIMITS = Budget(seconds=100)


def asked(number: int, text: str) -> AskedLatency:
    """Return a property of a system of the design, in hundredths of a second."""
    model = model_of(COUNTED[number].system, 0.01)
    property = sym.Property(id="Bound", text=text)
    model.properties.append(property)
    question = question_of(property, is_timed=True)
    assert isinstance(question, AskedLatency)
    return question


@pytest.mark.parametrize(
    ("text", "bound"),
    [
        ("/scan to /cmd_vel within 0.05", LatencyBound("/scan", "/cmd_vel", Fraction(1, 20))),
        ("OnScan responds within 1/3", LatencyBound("OnScan", "", Fraction(1, 3))),
        ('"On Scan" to "a to b"  within 2 ', LatencyBound("On Scan", "a to b", Fraction(2))),
        ("fired(A) leads to B >= 1 within 5", None),
        ("never A >= 1 within 5", None),
        ("A to B", None),
        ("A to within 5", None),
    ],
)
def test_reading(text: str, bound: LatencyBound | None) -> None:
    assert latency_bound(sym.Property(id="P", text=text)) == bound


def test_formulas_are_none() -> None:
    assert latency_bound(sym.Property(id="P", text="A to B within 5", language="ltl")) is None


@pytest.mark.parametrize("number", sorted(RESPONSES))
def test_responses_hold_from_the_greatest_time_on(number: int) -> None:
    """A little less is violated, by a run whose times are those of the net."""
    for name, (_, greatest) in RESPONSES[number].items():
        assert_greatest(number, f"{name} responds", greatest)


@pytest.mark.parametrize("number", sorted(CHAINS))
def test_chains_hold_from_the_greatest_time_on(number: int) -> None:
    first, last, _, greatest, is_lost = CHAINS[number]
    outcome = assert_greatest(number, f"{first} to {last}", greatest)
    assert ("an instance can be lost" in outcome.reason) == is_lost


def assert_greatest(number: int, text: str, greatest: int) -> Outcome:
    """Assert the bound from which a property holds; return that answer."""
    unit = 0.01
    holds = asked(number, f"{text} within {greatest * unit:g}").answer(LIMITS)
    assert holds.status == "holds"
    question = asked(number, f"{text} within {(greatest - 0.5) * unit:g}")
    outcome = question.answer(LIMITS)
    assert (outcome.status, outcome.ends_at_fault) == ("violated", True)
    assert isinstance(question.subject, TimedSubject)
    times = [Fraction(str(at)).limit_denominator(1000) for at, *_ in outcome.times]
    check_times(question.subject.timed, outcome.stem, times)
    began = Fraction(outcome.reason.rsplit("counted from ")[1].removesuffix(" s"))
    assert times[-1] - began == Fraction(greatest, 100)
    return holds


def test_a_chain_that_may_lose_data() -> None:
    outcome = asked(2, "tick to log within 0.15").answer(LIMITS)
    assert (outcome.status, outcome.reason) == ("holds", "at most 0.15 s; an instance can be lost")
    outcome = asked(2, "tick to /t within 0.005").answer(LIMITS)
    assert outcome.status == "violated"


def test_a_time_that_is_missing_is_named() -> None:
    question = asked(1, "tick to log within 100")
    page = find(question.subject.model, "log")
    assert isinstance(page, sym.CallbackPage)
    page.duration = None
    outcome = question_of(question.property, is_timed=True).answer(LIMITS)
    assert outcome.status == "unknown"
    assert outcome.reason == "the duration of callback log is not given"


def test_without_times_it_is_not_known() -> None:
    question = question_of(asked(1, "tick to log within 100").property)
    assert question.answer(LIMITS).status == "unknown"


@pytest.mark.parametrize("text", ["tock to log within 1", "log to tick within 1", "/t responds within 1"])
def test_wrong_ends(text: str) -> None:
    with pytest.raises(FormulaError):
        asked(1, text).answer(LIMITS)


@pytest.mark.parametrize("number", sorted(CHAINS))
def test_bounds_prove_only_what_holds(number: int) -> None:
    """No safe bound proves less than the greatest time that was counted."""
    first, last, _, greatest, _ = CHAINS[number]
    less = Fraction(greatest, 100) - Fraction(1, 1000)
    assert asked(number, f"{first} to {last} within {less}").by_bounds() is None
    proved = asked(number, f"{first} to {last} within 1000").by_bounds()
    assert proved is None or proved.status == "holds"


def test_a_check_without_time_proves_what_bounds_prove() -> None:
    model = model_of(COUNTED[1].system, 0.01)
    first, last, *_ = CHAINS[1]
    model.properties.append(sym.Property(id="Wide", text=f"{first} to {last} within 1000"))
    model.properties.append(sym.Property(id="Narrow", text=f"{first} to {last} within 0.000001"))
    report = check_timed(model, Budget(seconds=0.0))
    assert [each for each in report.proved if each.startswith("property Wide holds")]
    assert "whether property Narrow holds" in [each.question for each in report.unknown]
    assert "whether property Wide holds" not in [each.question for each in report.unknown]


def test_an_exact_answer_takes_the_place_of_a_bound() -> None:
    model = model_of(COUNTED[1].system, 0.01)
    first, last, *_ = CHAINS[1]
    model.properties.append(sym.Property(id="Wide", text=f"{first} to {last} within 1000"))
    report = check_timed(model, LIMITS)
    assert len([each for each in report.proved if "property Wide" in each]) == 1
