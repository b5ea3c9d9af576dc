"""Reductions of time Petri nets: the smaller net has the same markings, runs and times."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterator
from dataclasses import replace
from fractions import Fraction
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.nets.compiled import Transition
from dineros.analysis.reductions import ReductionError
from dineros.analysis.timed.goals import find_timed, find_timed_firing
from dineros.analysis.timed.graph import timed_graph
from dineros.analysis.timed.linear_time import verify_timed_ltl
from dineros.analysis.timed.nets import Interval, TimedNet
from dineros.analysis.timed.plain_classes import Bound, PlainClass
from dineros.analysis.timed.reductions.reduction import TimedReduction, reduce_timed
from tests.analysis.timed.test_linear_time import FORMULAS
from tests.analysis.timed.time_nets import RandomNet, lively_net
from tests.support.references.regions import TimedTransition

MOST_PAIRS = 150
"""Pairs of classes that are compared of a net."""


def crowded(net: RandomNet, random: Random) -> RandomNet:
    """Add what may be left out, and what looks like it but may not."""
    initial, made = list(net.initial), list(net.transitions)
    for _ in range(random.randint(1, 3)):
        match random.randrange(7):
            case 0:  # a copy of a place, perhaps with more tokens
                place = random.randrange(len(initial))
                initial.append(initial[place] + random.randint(0, 1))
                made = [_copied(one, place, len(initial) - 1) for one in made]
            case 1:  # a place that is read, or taken and put back
                initial.append(random.randint(1, 2))
                made = [_looped(one, len(initial) - 1, random) for one in made]
            case 2:  # a place that only receives
                initial.append(0)
                one = random.choice(made)
                made[made.index(one)] = replace(one, put={**one.put, len(initial) - 1: 1})
            case 3:  # the same transition again, perhaps with another interval
                one = random.choice(made)
                shift, longer = random.choice(((0, 0), (1, 1), (0, 1), (1, 0)))
                latest = None if one.latest is None else one.latest + shift + longer
                made.append(replace(one, name=f"t{len(made)}", earliest=one.earliest + shift, latest=latest))
            case 4:  # one that may come too late
                one = random.choice(made)
                earliest = random.randint(2, 6)
                made.append(
                    replace(
                        one,
                        name=f"t{len(made)}",
                        earliest=earliest,
                        latest=earliest + 1,
                        is_open_below=False,
                        is_open_above=False,
                    )
                )
            case 5:  # one that needs what is never there
                initial.append(0)
                made.append(replace(made[0], name=f"t{len(made)}", read={len(initial) - 1: 1}))
            case 6:  # a complementary pair of places: one of them may decide nothing
                place = random.randrange(len(initial))
                initial.append(2)
                made = [_complemented(one, place, len(initial) - 1) for one in made]
    return RandomNet(tuple(initial), made, net.pairs)


def _copied(one: TimedTransition, place: int, copy: int) -> TimedTransition:
    rows = [{**row, **({copy: row[place]} if place in row else {})} for row in (one.take, one.put, one.read)]
    return replace(one, take=rows[0], put=rows[1], read=rows[2])


def _looped(one: TimedTransition, place: int, random: Random) -> TimedTransition:
    match random.randrange(4):
        case 0:
            return replace(one, read={**one.read, place: 1})
        case 1:
            return replace(one, take={**one.take, place: 1}, put={**one.put, place: 1})
    return one


def _complemented(one: TimedTransition, place: int, other: int) -> TimedTransition:
    gain = one.put.get(place, 0) - one.take.get(place, 0)
    if gain > 0:
        return replace(one, take={**one.take, other: gain})
    return replace(one, put={**one.put, other: -gain}) if gain else one


def kept_markings(net: TimedNet, places: tuple[str, ...]) -> set[tuple[int, ...]]:
    graph = timed_graph(net, "S" if net.has_priorities else "W", Budget(states=20_000))
    columns = [net.untimed.places.index(place) for place in places]
    return {tuple(row) for row in graph.markings[:, columns].tolist()}


def check_times(made: TimedReduction) -> int:
    """Walk through the classes of both nets: kept transitions fire at the same times. Count the pairs."""
    nets = made.original, made.net
    index = [{name: t for t, name in enumerate(net.untimed.transitions)} for net in nets]
    start = PlainClass.initial(nets[0]), PlainClass.initial(nets[1])
    seen, queue = {start}, deque([start])
    while queue and len(seen) < MOST_PAIRS:
        pair = queue.popleft()
        windows = [dict(named(net, one, index[1].keys())) for net, one in zip(nets, pair, strict=True)]
        assert windows[0] == windows[1]
        for name in index[1]:
            after = tuple(one.after(net, t[name]) for net, one, t in zip(nets, pair, index, strict=True))
            assert (after[0] is None) == (after[1] is None), name
            if after[0] is not None and after[1] is not None:
                both = after[0], after[1]
                if both not in seen:
                    seen.add(both)
                    queue.append(both)
    return len(seen)


def named(net: TimedNet, one: PlainClass, kept: Collection[str]) -> Iterator[tuple[tuple[str, str], Bound]]:
    """Yield the bounds of a class, by the names of the transitions that are kept."""
    names = ["", *(net.untimed.transitions[t] for t in one.enabled)]
    for i, first in enumerate(names):
        for j, second in enumerate(names):
            if all(not name or name in kept for name in (first, second)):
                yield (first, second), one.matrix[i][j]


def nets(part: int, count: int, has_priorities: bool = False) -> Iterator[tuple[TimedNet, Random]]:
    """Yield crowded nets that are small enough to be compared."""
    seed = 0
    while count:
        seed += 1
        random = Random(f"{part} {seed}")
        plain = lively_net(random, has_priorities, most=300)
        net = crowded(plain, random)
        try:
            net.regions(3_000)
        except OverflowError:
            continue
        count -= 1
        yield net.net, random


@pytest.mark.long
@pytest.mark.parametrize("part", range(4))
def test_smaller_nets_do_the_same(part: int) -> None:
    """Of 200 random nets in all: markings, reachability, LTL and times agree."""
    rules: set[str] = set()
    fewer = pairs = 0
    for net, random in nets(part, 50, has_priorities=part == 3):
        observed = random.sample([*net.untimed.places, *net.untimed.transitions], 2)
        made = reduce_timed(net, observed)
        rules.update(step.rule for step in made.steps)
        fewer += bool(made.steps)
        names, places = made.net.untimed.transitions, made.net.untimed.places
        assert {*observed} <= {*names, *places}
        assert kept_markings(net, places) == kept_markings(made.net, places)
        if not net.has_priorities:
            pairs += check_times(made)
        for one in names:
            assert find_timed_firing(net, one).status == find_timed_firing(made.net, one).status
        end = find_timed(net, "deadlock").status
        assert end == find_timed(made.net, "deadlock").status
        for formula in FORMULAS:
            needed = {word for word in ("p0", "p1", "t0", "t1", "t2") if word in formula}
            if needed <= {*names, *places} and "enabled" not in formula:
                said = [
                    verify_timed_ltl(one, formula, NetNames(one.untimed)).status for one in (net, made.net)
                ]
                assert said[0] == said[1], formula
    assert fewer > 20 and (part == 3 or pairs > 500)
    if part < 3:
        assert rules >= {"NeverEnabled", "Overtaken", "StandsIn", "Untested"}


def interval(earliest: int, latest: int | None) -> Interval:
    return Interval(Fraction(earliest), None if latest is None else Fraction(latest))


def steps(net: TimedNet, *observed: str) -> list[tuple[str, str]]:
    return [(one.rule, one.removed) for one in reduce_timed(net, observed).steps]


def test_a_loop_that_restarts_a_clock_stays() -> None:
    """Place lock never disables anything for long, but each firing of one restarts the clock of other."""
    one = Transition("one", {"lock": 1, "p": 1}, {"lock": 1, "p": 1})
    other = Transition("other", {"lock": 1, "q": 1}, {"lock": 1})
    times = {"one": interval(1, 1), "other": interval(2, 2)}
    net = TimedNet.build({"p": 1, "q": 1, "lock": 1}, [one, other], times)
    assert find_timed(net, "q = 0").status == "unreachable"
    assert not [removed for _, removed in steps(net, "q", "other") if removed == "lock"]
    reading = replace_reads(net)
    assert find_timed(reading, "q = 0").status == "reachable"
    assert ("Untested", "lock") in steps(reading, "q", "other")


def replace_reads(net: TimedNet) -> TimedNet:
    """Return the net with read arcs instead of loops at the lock."""
    one = Transition("one", {"p": 1}, {"p": 1}, reads={"lock": 1})
    other = Transition("other", {"q": 1}, {}, reads={"lock": 1})
    times = {"one": interval(1, 1), "other": interval(2, 2)}
    return TimedNet.build({"p": 1, "q": 1, "lock": 1}, [one, other], times)


def test_two_that_are_the_same_are_two_if_tokens_suffice_for_both() -> None:
    rows = [Transition(name, {"p": 1}, {"q": 1}) for name in ("a", "b")]
    times = dict.fromkeys(("a", "b"), interval(1, 2))
    crowd = TimedNet.build({"p": 2, "q": 0}, rows, times)
    assert steps(crowd, "p", "q") == []
    alone = TimedNet.build({"p": 1, "q": 0}, rows, times)
    assert steps(alone, "p", "q") == [("StandsIn", "b")]
    free = TimedNet.build({"p": 2, "q": 0}, rows, {})
    assert steps(free, "p", "q") == [("StandsIn", "b")]


def test_a_late_one_stays_if_the_early_one_can_fire_beside_it() -> None:
    """With two tokens, soon fires and late keeps its clock: it fires at 3."""
    rows = [Transition("soon", {"p": 1}, {"q": 1}), Transition("late", {"p": 1}, {"r": 1})]
    times = {"soon": interval(2, 2), "late": interval(3, 3)}
    two = TimedNet.build({"p": 2, "q": 0, "r": 0}, rows, times)
    assert find_timed_firing(two, "late").status == "reachable"
    assert steps(two, "r") == [("Untested", "q")]
    one = TimedNet.build({"p": 1, "q": 0, "r": 0}, rows, times)
    assert ("Overtaken", "late") in steps(one, "r")


def test_a_late_one_at_the_same_moment_stays() -> None:
    rows = [Transition("soon", {"p": 1}, {"q": 1}), Transition("late", {"p": 1}, {"r": 1})]
    times = {"soon": interval(2, 3), "late": interval(3, 3)}
    assert steps(TimedNet.build({"p": 1, "q": 0, "r": 0}, rows, times), "q", "r") == []
    times["soon"] = replace(interval(2, 3), is_open_above=True)
    assert steps(TimedNet.build({"p": 1, "q": 0, "r": 0}, rows, times), "q", "r") == [("Overtaken", "late")]


def test_a_copy_of_a_place_goes() -> None:
    rows = [
        Transition("start", {"idle": 1}, {"busy": 1, "copy": 1}),
        Transition("end", {"busy": 1, "copy": 1}, {"idle": 1}),
    ]
    net = TimedNet.build({"idle": 1, "busy": 0, "copy": 0}, rows, {"end": interval(3, 5)})
    assert steps(net, "busy")[0] == ("NeverDecides", "copy") or ("NeverDecides", "copy") in steps(net, "busy")


def test_what_is_observed_and_unknown() -> None:
    rows = [Transition("t", {"p": 1}, {"q": 1})]
    net = TimedNet.build({"p": 1, "q": 0}, rows, {"t": interval(1, 2)})
    assert reduce_timed(net, ["p", "q", "t"]).net is net
    with pytest.raises(ReductionError, match="'x'"):
        reduce_timed(net, ["x"])


def test_time_that_runs_out_leaves_the_net() -> None:
    rows = [Transition("t", {"p": 1}, {"q": 1})]
    net = TimedNet.build({"p": 1, "q": 0}, rows, {"t": interval(1, 2)})
    assert reduce_timed(net, ["p"], Budget(seconds=0.0)).net is net
