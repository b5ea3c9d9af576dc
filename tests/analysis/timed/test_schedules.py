"""Schedules of firing sequences: random runs in time have one that fits, other sequences have none."""

from __future__ import annotations

from fractions import Fraction
from random import Random

import pytest

from dineros.analysis.nets.compiled import Transition
from dineros.analysis.nets.witness import WitnessError
from dineros.analysis.timed.nets import Interval, TimedNet
from dineros.analysis.timed.schedules import schedule
from tests.analysis.timed.time_nets import RandomNet, lively_net
from tests.support.references.regions import State


def run(net: RandomNet, random: Random, length: int) -> list[int]:
    """Return a firing sequence that some run of the regions has."""
    graph = net.regions()
    state: State = graph.start
    trace: list[int] = []
    for _ in range(60):
        choices: list[tuple[int | None, State]] = list(graph.fires[state])
        if state in graph.waits:
            choices.append((None, graph.waits[state]))
        if not choices or len(trace) == length:
            break
        fired, state = random.choice(choices)
        if fired is not None:
            trace.append(fired)
    return trace


@pytest.mark.parametrize("seed", range(60))
def test_runs_have_schedules_that_keep_all_intervals(seed: int) -> None:
    random = Random(seed)
    net = lively_net(random, has_priorities=seed % 3 == 0)
    trace = run(net, random, 8)
    found = schedule(net.net, trace)
    assert [firing.transition for firing in found] == trace
    replay(net.net, [(firing.transition, firing.at) for firing in found])
    for firing in found:
        assert firing.earliest <= firing.at
        assert firing.latest is None or firing.at <= firing.latest


def replay(net: TimedNet, timed: list[tuple[int, Fraction]]) -> None:
    """Let time pass and fire, by the definition of the semantics."""
    marking = net.untimed.initial.tolist()

    def enabled(tokens: list[int]) -> set[int]:
        return {
            t
            for t in range(len(net.intervals))
            if all(tokens[p] >= w for p, w in net.untimed.pre.row(t))
            and all(tokens[p] < w for p, w in net.untimed.inhibitor.row(t))
        }

    clocks = dict.fromkeys(enabled(marking), Fraction(0))
    now = Fraction(0)
    for fired, at in timed:
        assert at >= now
        clocks = {t: clock + at - now for t, clock in clocks.items()}
        now = at
        for t, clock in clocks.items():
            interval = net.intervals[t]
            assert (
                interval.latest is None
                or clock < interval.latest
                or (clock == interval.latest and not interval.is_open_above)
            )
        ready = {
            t
            for t, clock in clocks.items()
            if clock > net.intervals[t].earliest
            or (clock == net.intervals[t].earliest and not net.intervals[t].is_open_below)
        }
        assert fired in ready
        assert not ready & set(net.above[fired])
        for place, weight in net.take.row(fired):
            marking[place] -= weight
        between = enabled(marking)
        for place, weight in net.put.row(fired):
            marking[place] += weight
        clocks = {
            t: clocks[t] if t in clocks and t in between and t != fired else Fraction(0)
            for t in enabled(marking)
        }


def test_a_sequence_that_comes_too_late_has_no_schedule() -> None:
    steps = [Transition("soon", {"p": 1}, {"q": 1}), Transition("late", {"r": 1}, {"s": 1})]
    times = {
        "soon": Interval(Fraction(0), Fraction(2)),
        "late": Interval(Fraction(2), None, is_open_below=True),
    }
    net = TimedNet.build({"p": 1, "q": 0, "r": 1, "s": 0}, steps, times)
    assert schedule(net, [0, 1])[1].earliest == 2
    with pytest.raises(WitnessError, match="no schedule"):
        schedule(net, [1, 0])
    with pytest.raises(WitnessError, match="not enabled"):
        schedule(net, [0, 0])


def test_windows_are_those_of_all_schedules() -> None:
    steps = [Transition("a", {"p": 1}, {"q": 1}), Transition("b", {"q": 1}, {"r": 1})]
    times = {"a": Interval(Fraction(1), Fraction(4)), "b": Interval(Fraction(1, 2))}
    net = TimedNet.build({"p": 1, "q": 0, "r": 0}, steps, times)
    first, second = schedule(net, [0, 1])
    assert (first.earliest, first.latest) == (Fraction(1), Fraction(4))
    assert (second.earliest, second.latest) == (Fraction(3, 2), None)
