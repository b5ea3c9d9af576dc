"""Ticks that timers lose are findings of a check with times, with the run that loses one."""

from __future__ import annotations

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.stages import Share
from dineros.analysis.consequences.durations import left_to_durations
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.analysis.timed_checks import boundedness
from dineros.analysis.timed_checks.lost_ticks import misses
from dineros.analysis.timed_checks.timed_check import check_timed
from dineros.analysis.witnesses.findings import Finding, Report
from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, flow, node_net, place, seconds, step
from dineros.metamodel.elements import find
from tests.support.timed_systems.counted import COUNTED
from tests.support.timed_systems.models import model_of

RULE = "timer-loses-ticks"


def lost(report: Report) -> list[Finding]:
    return [each for each in report.findings if each.rule == RULE]


@pytest.mark.parametrize("number", [7, 8, 9, 10, 16])
def test_ticks_that_are_lost_are_those_that_a_plain_program_counts(number: int) -> None:
    report = check_timed(model_of(COUNTED[number].system))
    assert {each.elements[0] for each in lost(report)} == set(COUNTED[number].missed)
    timers = {each["name"] for each in COUNTED[number].system["callbacks"] if "period" in each}
    proved = {each for each in report.proved if each.endswith("loses no tick")}
    kept = timers - set(COUNTED[number].missed)
    assert proved == {f"the timer of {name} loses no tick" for name in kept}
    assert not [each for each in report.unknown if each.rule == RULE]


def test_the_run_ends_with_the_lost_tick() -> None:
    model = model_of(COUNTED[8].system)
    transitions = {page.id: name for page, name in misses(timed_base_subject(model))}
    for each in lost(check_timed(model)):
        assert each.severity == "warning" and each.witness is not None
        assert each.witness.steps[-1].transition == transitions[each.elements[0]]
        assert all(step.time is not None for step in each.witness.steps)


def test_a_time_that_is_missing_makes_it_a_note() -> None:
    """Unless the callback takes longer than its period whatever the others do."""
    model = model_of(COUNTED[7].system)
    find(model, "fast", sym.CallbackPage).duration = None
    found = lost(left_to_durations(model, check_timed(model)))
    assert {each.elements[0]: each.severity for each in found} == {"fast": "note", "slow": "note"}
    assert all(each.message.endswith("; the duration of callback fast is not given") for each in found)
    find(model, "slow", sym.CallbackPage).duration = seconds(11, 12)
    found = lost(left_to_durations(model, check_timed(model)))
    assert {each.elements[0]: each.severity for each in found} == {"fast": "note", "slow": "warning"}


def test_bounds_prove_it_if_there_are_too_many_classes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(boundedness, "FIRST", Share(most_seconds=0.0))
    report = check_timed(model_of(COUNTED[7].system), Budget(states=3))
    assert {each for each in report.proved if each.endswith("loses no tick")} == {
        "the timer of fast loses no tick",
        "the timer of slow loses no tick",
    }


def test_a_callback_that_begins_only_in_some_states_may_let_ticks_pass() -> None:
    model = model_of(COUNTED[7].system)
    page = find(model, "fast", sym.CallbackPage)
    flow(place(page, "words", tokens=2), find(model, "fast.do", pn.Transition))
    found = lost(left_to_durations(model, check_timed(model)))
    assert {each.elements[0]: each.severity for each in found} == {"fast": "note"}


def test_a_handler_of_a_timer_whose_duration_is_not_used_makes_it_a_note() -> None:
    model = sym.SystemModel(id="scanning", middleware="ros2")
    model.times = sym.DefaultTimes(
        reaction=seconds(0, 0.02), latency=seconds(0, 0.01), duration=seconds(0, 0.01)
    )
    page = callback(node_net(model, "lidar"), "OnScanner", "timer", 0.1)
    step(page, "Scan", [], [])
    (found,) = lost(left_to_durations(model, check_timed(model)))
    assert found.severity == "note"
    assert found.message.endswith("; the duration of the handler of transition Scan is not used")
    model.times.duration = None
    assert not lost(check_timed(model)), "the engine reacts in time"
