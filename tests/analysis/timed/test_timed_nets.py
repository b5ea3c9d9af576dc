"""Bounds of intervals are exact, and mean what they say."""

from __future__ import annotations

from fractions import Fraction

import pytest

from dineros.analysis.explicit import explore
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.timed.graph import class_graph
from dineros.analysis.timed.nets import Interval, TimedNet, compile_timed_net, exact
from dineros.metamodel import pn
from dineros.metamodel.errors import DinerosError


def race(first: Interval, second: Interval) -> TimedNet:
    """Two transitions compete for one token; each has a place of its own to put it."""
    return TimedNet.build(
        {"p": 1, "a": 0, "b": 0},
        [Transition("one", {"p": 1}, {"a": 1}), Transition("other", {"p": 1}, {"b": 1})],
        {"one": first, "other": second},
    )


def test_bounds_are_read_by_their_decimal_text() -> None:
    assert exact(0.1) + exact(0.2) == Fraction(3, 10)
    for number in (float("inf"), float("nan")):
        with pytest.raises(DinerosError, match="finite"):
            exact(number)


def test_a_sum_that_floating_point_gets_wrong() -> None:
    # The second one comes first by a hair if 0.1 + 0.2 > 0.3, as in floating point; exactly, both may.
    steps = [
        Transition("first", {"p": 1}, {"q": 1}),
        Transition("second", {"q": 1}, {"r": 1}),
        Transition("rival", {"s": 1}, {"t": 1}, {"r": 1}),
    ]
    intervals = {
        "first": Interval(exact(0.1), exact(0.1)),
        "second": Interval(exact(0.2), exact(0.2)),
        "rival": Interval(exact(0.3), exact(0.3)),
    }
    net = TimedNet.build({"p": 1, "q": 0, "r": 0, "s": 1, "t": 0}, steps, intervals)
    assert net.unit == Fraction(1, 10)
    # Markings: before, after the first, then both orders and what they lead to.
    assert class_graph(net).markings == 5


@pytest.mark.parametrize(
    ("first", "second", "markings"),
    [
        (Interval(Fraction(1), Fraction(2)), Interval(Fraction(3), Fraction(4)), 2),
        (Interval(Fraction(1), Fraction(2)), Interval(Fraction(2), Fraction(4)), 3),
        (Interval(Fraction(1), Fraction(2), is_open_above=True), Interval(Fraction(2), Fraction(4)), 2),
        (Interval(Fraction(1), Fraction(2)), Interval(Fraction(2), Fraction(4), is_open_below=True), 2),
        (Interval(), Interval(Fraction(5), Fraction(5)), 3),
    ],
)
def test_who_can_win(first: Interval, second: Interval, markings: int) -> None:
    for kind in ("W", "M", "S", "E", "A"):
        assert class_graph(race(first, second), kind).markings == markings


def test_a_read_arc_does_not_disturb_a_clock_and_a_loop_does() -> None:
    def net(reads: bool) -> TimedNet:
        looks = Transition(
            "look", {} if reads else {"p": 1}, {} if reads else {"p": 1}, {}, {"p": 1} if reads else {}
        )
        return TimedNet.build(
            {"p": 1, "q": 0},
            [looks, Transition("leave", {"p": 1}, {"q": 1})],
            {"look": Interval(Fraction(1), Fraction(1)), "leave": Interval(Fraction(2), Fraction(2))},
        )

    assert class_graph(net(reads=True)).markings == 2
    assert class_graph(net(reads=False)).markings == 1


def test_linear_classes_refuse_priorities() -> None:
    net = TimedNet.build({"p": 1}, [Transition("a", {"p": 1}), Transition("b", {"p": 1})], {}, [("a", "b")])
    with pytest.raises(DinerosError, match="do not support priorities"):
        class_graph(net, "W")
    assert class_graph(net, "S").edges == 1


def test_priorities_hold_through_others() -> None:
    steps = [Transition(name, {"p": 1}, {name: 1}) for name in "abc"]
    net = TimedNet.build({"p": 1, "a": 0, "b": 0, "c": 0}, steps, {}, [("a", "b"), ("b", "c")])
    assert net.above == ((), (0,), (0, 1))


@pytest.mark.parametrize("interval", [(-1.0, 2.0), (3.0, 2.0), (float("nan"), 2.0), (0.0, float("inf"))])
def test_intervals_that_are_none(interval: tuple[float, float]) -> None:
    transition = pn.Transition(id="t", interval=pn.TimeInterval(earliest=interval[0], latest=interval[1]))
    net = pn.Net(id="n", pages=[pn.Page(id="page", objects=[transition])])
    with pytest.raises(DinerosError, match="transition t"):
        compile_timed_net(net)


def test_without_intervals_there_is_one_class_for_each_marking() -> None:
    steps = [
        Transition("go", {"p": 1}, {"q": 1}),
        Transition("back", {"q": 2}, {"p": 2}),
        Transition("x", {"q": 1}),
    ]
    net = TimedNet.build({"p": 3, "q": 0}, steps, {})
    space = explore(CompiledNet.build({"p": 3, "q": 0}, steps))
    for kind in ("W", "M", "S", "E", "A"):
        graph = class_graph(net, kind)
        assert (graph.classes, graph.edges, graph.deadlocks) == (space.markings, space.arcs, space.deadlocks)
