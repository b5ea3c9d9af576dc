"""Checks with times, decided again: what is true is confirmed, and an engine that is wrong is noticed."""

from __future__ import annotations

from dataclasses import replace
from random import Random

import numpy as np
import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.evidence.timed_check_confirmation import (
    CALLBACKS,
    ENDS,
    FIRINGS,
    MARKINGS,
    add_confirmations,
    behaviour,
    confirm_timed_check,
)
from dineros.analysis.evidence.timed_confirmation import COUNTED, ONLY_ATOMIC, STRONG
from dineros.analysis.nets.compiled import Int64Array
from dineros.analysis.timed.nets import Interval, TimedNet
from dineros.analysis.timed_checks.timed_check import ask_timed
from dineros.analysis.timed_checks.timed_checked import TimedChecked
from dineros.analysis.witnesses.findings import Report
from dineros.metamodel import pn, sym
from dineros.metamodel.elements import find
from tests.analysis.timed.time_nets import RandomNet, lively_net
from tests.analysis.timed_checks.test_timed_check import model_of, plain_net
from tests.support.systems.talker import talker


def checked(model: pn.Net) -> TimedChecked:
    """Return a check with times that has ended."""
    found = ask_timed(model, Report())
    assert found is not None and not found.report.unknown
    return found


def firings(net: RandomNet) -> set[int]:
    return {t for fired in net.regions().fires.values() for t, _ in fired}


def rows(markings: Int64Array) -> set[tuple[int, ...]]:
    return {tuple(map(int, row)) for row in markings}


@pytest.mark.parametrize("seed", range(12))
def test_the_other_engine_finds_what_the_regions_have(seed: int) -> None:
    net = lively_net(Random(500 + seed), is_closed=seed % 2 == 0, most=800)
    found = behaviour(net.net, Budget())
    assert found.by == (COUNTED if seed % 2 == 0 else found.by)
    assert rows(found.markings) == set(net.regions().markings)
    assert set(found.firings) == firings(net)
    ends = {marking for marking, clocks in net.regions().fires if not clocks}
    assert rows(found.ends(net.net)) == ends


def test_strong_classes_answer_where_time_cannot_be_counted() -> None:
    nets = [lively_net(Random(seed), most=800) for seed in range(10)]
    assert {behaviour(net.net, Budget()).by for net in nets} == {COUNTED, STRONG}


def slowed(net: TimedNet, transition: int) -> TimedNet:
    """Return a net in which a transition fires later: the check is then one of another net."""
    intervals = list(net.intervals)
    given = intervals[transition]
    later = None if given.latest is None else given.latest + 2 * net.unit
    intervals[transition] = Interval(given.earliest + 2 * net.unit, later)
    return replace(net, intervals=tuple(intervals))


@pytest.mark.long
def test_what_is_true_is_confirmed_and_a_wrong_search_is_noticed() -> None:
    """The search is made wrong by giving it the results of a net whose intervals differ."""
    noticed = 0
    for seed in range(40):
        net = lively_net(Random(6_000 + seed), is_closed=seed % 3 > 0, most=600)
        ours = checked(model_of(net))
        told = confirm_timed_check(ours)
        assert {what: one.agrees for what, one in told.items()} == dict.fromkeys(
            (MARKINGS, FIRINGS, ENDS), True
        ), (seed, told)
        true = behaviour(ours.timed.timed, Budget())
        for transition in range(len(net.transitions)):
            other = slowed(ours.timed.timed, transition)
            theirs = behaviour(other, Budget())
            same = {
                MARKINGS: np.array_equal(true.markings, theirs.markings),
                FIRINGS: true.firings == theirs.firings,
                ENDS: np.array_equal(true.ends(other), theirs.ends(other)),
            }
            ours.subject = replace(ours.timed, timed=other)
            said = {what: bool(one.agrees) for what, one in confirm_timed_check(ours).items()}
            assert said == same, (seed, transition)
            noticed += not all(same.values())
    assert noticed > 20


def test_after_a_disagreement_nothing_counts_as_proved() -> None:
    ours = checked(model_of(lively_net(Random(1), is_closed=True, most=600)))
    assert ours.report.proved
    proved = len(ours.report.proved)
    ours.explored.ways.popitem()
    told = confirm_timed_check(ours)
    assert {what: one.agrees for what, one in told.items()} == {MARKINGS: True, FIRINGS: False, ENDS: True}
    add_confirmations(ours.report, told)
    assert not [text for text in ours.report.proved if "confirmed" not in text]
    faults = [each for each in ours.report.unknown if each.may_be_fault]
    assert len(faults) == proved + 1
    assert any("engines disagree" in each.reason for each in faults)


def test_priorities_have_one_engine() -> None:
    found = (lively_net(Random(seed), has_priorities=True, most=800) for seed in range(100))
    net = next(one for one in found if any(one.transitions[high].earliest for high, _ in one.pairs))
    told = confirm_timed_check(checked(model_of(net)))
    assert [one.agrees for one in told.values()] == [None, None, None]
    assert "one engine" in told[MARKINGS].reason


def test_ends_are_not_compared_where_priorities_go_round() -> None:
    net = plain_net(("a", "p", "q", 0, 2), ("b", "p", "r", 0, 2), tokens="p")
    a, b = (one for one in net.pages[0].objects if one.id in ("a", "b"))
    a.overrides.append(b)  # type: ignore[attr-defined]
    b.overrides.append(a)  # type: ignore[attr-defined]
    told = confirm_timed_check(checked(net))
    assert told[ENDS].agrees is None and told[MARKINGS].agrees is not False


def timed_talker(*properties: tuple[str, str, bool]) -> sym.SystemModel:
    """Return a model that says something at 1 s: with properties, each a language, a text, and its answer."""
    model = talker()
    find(model, "Say", sym.Transition).interval = pn.TimeInterval(earliest=1, latest=1)
    for number, (language, text, expected) in enumerate(properties):
        model.properties.append(
            sym.Property(id=f"p{number}", text=text, language=language, expected=expected)
        )
    return model


def test_properties_are_asked_again_each_with_its_engine() -> None:
    model = timed_talker(
        ("words", "never Noted >= 9", True),
        ("ltl", "G (fired(Say) -> X Noted <= 9)", True),
        ("ctl", "AG EF (Noted >= 9)", False),
        ("ctl", "AG (AX Noted <= 8)", True),
        ("words", "never Noted >= 1 within 1", False),
    )
    ours = checked(model)
    told = confirm_timed_check(ours)
    by = {
        what: (one.agrees, one.by[0].partition(" (")[0] if one.by else one.reason)
        for what, one in told.items()
    }
    assert by["property p0"] == (True, COUNTED)
    assert by["property p1"] == (True, STRONG)
    assert by["property p2"] == (None, ONLY_ATOMIC)
    assert by["property p3"] == (None, ONLY_ATOMIC)
    number = next(at for at, (one, _, _) in enumerate(ours.answered) if one.id == "p1")
    property, question, _ = ours.answered[number]
    ours.answered[number] = property, question, Outcome("violated")
    assert confirm_timed_check(ours)["property p1"].agrees is False


def test_callbacks_are_asked_again() -> None:
    ours = checked(timed_talker())
    ours.waits = [(False, True)]
    told = confirm_timed_check(ours)
    assert told[CALLBACKS].agrees is False  # it has no callbacks
    ours.waits = []
    assert CALLBACKS not in confirm_timed_check(ours)
