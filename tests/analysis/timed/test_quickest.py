"""The quickest way against a shortest path through time in small steps."""

from __future__ import annotations

import heapq
from fractions import Fraction
from random import Random

import pytest

from dineros.analysis.nets.compiled import Transition
from dineros.analysis.timed.durations.quickest import quickest_firing, quickest_marking
from dineros.analysis.timed.nets import Interval, TimedNet
from dineros.analysis.timed.schedules import schedule
from tests.analysis.timed.time_nets import RandomNet, lively_net

STEPS = 16
"""Steps of the reference in a unit of time, where bounds may be open."""


def least_steps(net: RandomNet, steps: int) -> dict[object, int]:
    """Return by marking, and by transition, after how many steps of time it is reached, or fired, first.

    A clock is counted up to a step beyond the bounds of its transition.
    """
    transitions = net.transitions

    def enabled(marking: tuple[int, ...]) -> list[int]:
        return [t for t, one in enumerate(transitions) if one.is_enabled(marking)]

    start = (net.initial, tuple((t, 0) for t in enabled(net.initial)))
    found: dict[object, int] = {}
    best = {start: 0}
    queue = [(0, 0, start)]
    count = 0
    while queue:
        time, _, state = heapq.heappop(queue)
        if time > best[state]:
            continue
        marking, clocks = state
        found.setdefault(marking, time)
        after: list[tuple[int, tuple[tuple[int, ...], tuple[tuple[int, int], ...]]]] = []
        ready = set()
        can_wait = True
        for t, clock in clocks:
            one = transitions[t]
            low = one.earliest * steps
            if clock > low or (clock == low and not one.is_open_below):
                ready.add(t)
            if one.latest is not None:
                high = one.latest * steps
                can_wait &= clock + 1 < high or (clock + 1 == high and not one.is_open_above)
        if can_wait:
            later = tuple((t, min(c + 1, (transitions[t].beyond + 1) * steps)) for t, c in clocks)
            after.append((1, (marking, later)))
        for t in ready:
            one = transitions[t]
            if one.above & ready:
                continue
            found.setdefault(one.name, time)
            between = list(marking)
            for p, w in one.take.items():
                between[p] -= w
            new = list(between)
            for p, w in one.put.items():
                new[p] += w
            kept = dict(clocks)
            made = tuple(
                (u, kept[u] if u != t and u in kept and transitions[u].is_enabled(tuple(between)) else 0)
                for u in enabled(tuple(new))
            )
            after.append((0, (tuple(new), made)))
        for cost, there in after:
            if time + cost < best.get(there, 1 << 60):
                best[there] = time + cost
                count += 1
                heapq.heappush(queue, (time + cost, count, there))
    return found


@pytest.mark.long
@pytest.mark.parametrize("seed", range(24))
def test_quickest_ways_of_closed_nets(seed: int) -> None:
    net = lively_net(Random(seed), has_priorities=seed % 4 == 0, is_closed=True, most=600)
    compare(net, 1)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(100, 112))
def test_quickest_ways_of_open_nets(seed: int) -> None:
    net = lively_net(Random(seed), has_priorities=seed % 4 == 0, most=150)
    compare(net, STEPS)


def compare(net: RandomNet, steps: int) -> None:
    expected = least_steps(net, steps)
    timed = net.net
    goals = sorted((goal for goal in expected if isinstance(goal, tuple)), key=str)
    for marking in goals[:6]:
        text = " & ".join(f"p{p} == {n}" for p, n in enumerate(marking))
        agree(quickest_marking(timed, text), expected[marking], steps, timed)
    for one in net.transitions:
        found = quickest_firing(timed, one.name)
        if one.name in expected:
            agree(found, expected[one.name], steps, timed)
        else:
            assert found.outcome.status == "unreachable"


def agree(found, steps_taken: int, steps: int, net: TimedNet) -> None:  # type: ignore[no-untyped-def]
    """The unit of the random nets is a seventh; in steps, what is not attained is rounded up."""
    assert found.outcome.status == "reachable" and found.is_least
    whole, rest = divmod(steps_taken, steps)
    assert (found.time, found.is_attained) == (Fraction(whole, 7), rest == 0)
    trace = found.outcome.trace
    if trace:
        assert schedule(net, trace)[-1].earliest == found.time


def race() -> TimedNet:
    """Return a net with a short way that takes long, and a long way that is quick; one bound is open."""
    steps = [
        Transition("direct", {"p": 1}, {"goal": 1}),
        Transition("first", {"p": 1}, {"q": 1}),
        Transition("second", {"q": 1}, {"goal": 1}),
    ]
    times = {
        "direct": Interval(Fraction(9)),
        "first": Interval(Fraction(3, 2), Fraction(4), is_open_below=True),
        "second": Interval(Fraction(1, 10), Fraction(5)),
    }
    return TimedNet.build({"p": 1, "q": 0, "goal": 0}, steps, times)


def test_a_long_way_may_be_quick_and_its_time_not_attained() -> None:
    found = quickest_marking(race(), "goal >= 1")
    assert found.outcome.trace == (1, 2)
    assert (found.time, found.is_attained) == (Fraction(8, 5), False)
    assert str(found) == "every firing sequence takes more than 8/5, and some take arbitrarily little more"
    assert quickest_firing(race(), "direct").outcome.status == "unreachable"


def test_a_deadlock_is_one_of_the_net_and_not_of_its_observer() -> None:
    found = quickest_marking(race(), "deadlock")
    assert (found.outcome.trace, found.time) == ((1, 2), Fraction(8, 5))


def test_where_the_net_begins_takes_no_time() -> None:
    found = quickest_marking(race(), "p >= 1")
    assert (found.outcome.trace, found.time, found.is_attained) == ((), Fraction(0), True)
