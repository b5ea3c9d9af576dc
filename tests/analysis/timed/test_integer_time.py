"""Time as a counter of a plain net: the markings are those of the state classes."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from random import Random

import pytest

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.nets.compiled import Transition
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.analysis.timed.graph import class_graph
from dineros.analysis.timed.integers.counting import count_markings
from dineros.analysis.timed.integers.net import integer_net
from dineros.analysis.timed.nets import Interval, TimedNet
from dineros.analysis.timed.search import ClassSearch
from dineros.analysis.timed.state_space import timed_state_space
from dineros.metamodel.errors import DinerosError
from tests.analysis.timed.time_nets import lively_net, prior_net


@pytest.mark.parametrize("seed", range(20))
def test_markings_by_search_and_by_diagrams(seed: int) -> None:
    net = lively_net(Random(seed), is_closed=True)
    expected = len(net.regions().markings)
    made = integer_net(net.net)
    assert count_markings(made, UNLIMITED) == expected
    assert symbolic_state_space(made.net).satisfying({made.end: (1, None)}) == expected
    assert class_graph(net.net, "W").markings == expected


@pytest.mark.parametrize("seed", range(30))
def test_markings_with_priorities(seed: int) -> None:
    """What stands above others has no earliest bound: then whole units are enough."""
    net = prior_net(Random(seed))
    expected = len(net.regions().markings)
    made = integer_net(net.net)
    assert count_markings(made, UNLIMITED) == expected
    assert symbolic_state_space(made.net).satisfying({made.end: (1, None)}) == expected
    for kind in "SE":
        assert class_graph(net.net, kind).markings == expected  # type: ignore[arg-type]


def test_priorities_change_what_is_counted() -> None:
    assert sum(
        count_markings(integer_net(net.net), UNLIMITED)
        < count_markings(integer_net(replace(net, pairs=()).net), UNLIMITED)
        for net in (prior_net(Random(seed)) for seed in range(30))
    ) >= 5  # fmt: skip


def test_priorities_that_begin_later_need_parts_of_a_unit() -> None:
    """`ready` must come before 1, where `guard` could fire, and after 0: else `first` holds `late` back."""
    steps = [
        Transition("ready", {"p": 1}, {"q": 1, "r": 1}, {}, {"g": 1}),
        Transition("guard", {"g": 1}, {}),
        Transition("first", {"r": 1}, {"s": 1}),
        Transition("late", {"l": 1}, {"m": 1}),
    ]
    one = Interval(Fraction(1), Fraction(1))
    times = {"ready": Interval(Fraction(0), Fraction(1)), "guard": one, "first": one, "late": one}
    places = {"p": 1, "q": 0, "r": 0, "g": 1, "s": 0, "l": 1, "m": 0}
    net = TimedNet.build(places, steps, times, [("guard", "ready"), ("first", "late")])
    search = ClassSearch(net, "S")
    search.run()
    between = [dict(zip(places, row, strict=True)) for row in search.markings().tolist()]
    assert any(marking["r"] and marking["m"] for marking in between)
    with pytest.raises(DinerosError, match="has priority over others only from 1 on"):
        integer_net(net)


def timed(interval: Interval) -> TimedNet:
    return TimedNet.build({"p": 1, "q": 0}, [Transition("t", {"p": 1}, {"q": 1})], {"t": interval})


def test_open_intervals_are_refused() -> None:
    with pytest.raises(DinerosError, match="is open"):
        integer_net(timed(Interval(Fraction(0), Fraction(2), is_open_below=True)))


def test_bounds_that_are_far_apart_are_refused() -> None:
    with pytest.raises(DinerosError, match="too many units"):
        integer_net(timed(Interval(Fraction(1, 1000), Fraction(1_000_000))))


def test_names_of_the_net_may_be_those_of_steps() -> None:
    names = ("end", "time", "now")
    steps = [Transition(name, {f"clock of {name}": 1}, {"end": 1}) for name in names]
    places = {f"clock of {name}": 1 for name in names} | {"end": 0, "now": 0}
    net = TimedNet.build(places, steps, dict.fromkeys(names, Interval(Fraction(1), Fraction(2))))
    assert count_markings(integer_net(net), UNLIMITED) == class_graph(net, "W").markings == 8


def test_a_limit_is_said() -> None:
    space = timed_state_space(
        timed(Interval(Fraction(1), Fraction(2_000))), engine="integer", budget=Budget(seconds=0.0)
    )
    assert (space.markings, space.complete, space.reason) == (None, False, "time ran out")
