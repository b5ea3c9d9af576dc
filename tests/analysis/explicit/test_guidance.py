"""Searches led by the state equation: its bound, and ways as short as those of a plain search."""

from __future__ import annotations

import random
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget
from dineros.analysis.explicit import Comparison, Goal, engine, find, find_all, guidance, search
from dineros.analysis.explicit.guidance import guidance as bound_for
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.witness import replay
from tests.analysis import classic_nets as classic
from tests.analysis.reference_case_study import reference_case_study
from tests.analysis.reference_search import distances
from tests.analysis.strategies import SLOW, goals, nets

MEMORY = 1 << 26


@pytest.fixture
def led_from_the_start(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the bound lead every search, and all workers go at levels of any size."""
    monkeypatch.setattr(engine, "NEAR", 0)
    monkeypatch.setattr(guidance, "LEAST_BOUND", 0)
    monkeypatch.setattr(search, "LEAST_FOR_THREADS", 1)
    monkeypatch.setattr(search, "LEAST_WITH_GOALS", 0)


@st.composite
def rings(draw: st.DrawFn) -> CompiledNet:
    """Up to three rings of places with tokens, which wait for, read and inhibit each other; all bounded."""
    sizes = draw(st.lists(st.integers(2, 5), min_size=1, max_size=3))
    names = [[f"r{i}_{j}" for j in range(size)] for i, size in enumerate(sizes)]
    places = {
        place: draw(st.integers(0, 2)) if place.endswith("_0") else 0 for ring in names for place in ring
    }
    transitions: list[Transition] = []
    for ring in names:
        others = [place for other in names if other is not ring for place in other]
        for j in range(len(ring) + draw(st.integers(0, 2))):
            weight = draw(st.sampled_from([1, 1, 1, 2]))
            taken, put = {ring[j % len(ring)]: weight}, {draw(st.sampled_from(ring)): weight}
            inhibited: dict[str, int] = {}
            match draw(st.sampled_from(["alone", "alone", "moves", "reads", "inhibited"])) if others else "":
                case "moves":
                    first = draw(st.sampled_from(others))
                    own = next(other for other in names if first in other)
                    taken[first], put[draw(st.sampled_from(own))] = 1, 1
                case "reads":
                    place = draw(st.sampled_from(others))
                    taken[place] = put[place] = 1
                case "inhibited":
                    inhibited[draw(st.sampled_from(others))] = draw(st.integers(1, 2))
            transitions.append(Transition(f"t{len(transitions)}", taken, put, inhibited))
    return CompiledNet.build(places, transitions)


@pytest.mark.usefixtures("led_from_the_start")
@given(st.data())
@SLOW
def test_ways_are_shortest_and_what_is_not_there_is_not_found(data: st.DataObject) -> None:
    net = data.draw(st.one_of(rings(), nets()))
    goal = data.draw(st.one_of(goals(net), st.builds(lambda t: Goal((t,)), transitions_of(net))))
    distance = distances(net)
    if not distance:
        return
    best = min((steps for marking, steps in distance.items() if goal.holds(net, marking)), default=None)
    known = bound_for(net, goal)
    if known is not None:
        assert min(known.costs) >= 0
        assert all(known.bound(marking) <= 0 for marking in distance if goal.holds(net, marking))
        assert best is None or known.bound(net.initial.tolist()) <= known.unit * best
    answer = find(net, goal, Budget(MEMORY), workers=data.draw(st.sampled_from([1, 2])))
    if best is None:
        assert answer.status == "unreachable" and answer.states == len(distance)
    else:
        assert answer.trace is not None and len(answer.trace) == best
        assert goal.holds(net, replay(net, answer.trace)[-1])


def transitions_of(net: CompiledNet) -> st.SearchStrategy[int]:
    return st.integers(0, len(net.transitions) - 1)


def chain(length: int) -> CompiledNet:
    """A chain of places, and at each a choice of a ring that leads back."""
    places = {f"p{i}": int(i == 0) for i in range(length + 1)} | {f"q{i}": 0 for i in range(length)}
    steps = [Transition(f"on{i}", {f"p{i}": 1}, {f"p{i + 1}": 1}) for i in range(length)]
    off = [Transition(f"off{i}", {f"p{i}": 1}, {f"q{i}": 1}) for i in range(length)]
    back = [Transition(f"back{i}", {f"q{i}": 1}, {f"p{i}": 1}) for i in range(length)]
    return CompiledNet.build(places, [*steps, *off, *back])


def test_bound_of_a_chain_is_its_length() -> None:
    net = chain(9)
    known = bound_for(net, Goal.where(net, [({"p9": 1}, ">=", 1)]))
    assert known is not None and known.bound(net.initial.tolist()) == 9 * known.unit
    assert [known.costs[net.transitions.index(f"on{i}")] for i in range(9)] == [0] * 9
    # A way back counts twice: off and back again.
    for i in range(9):
        assert (
            sum(known.costs[net.transitions.index(name)] for name in (f"off{i}", f"back{i}"))
            == 2 * known.unit
        )


def test_no_bound_where_none_leads() -> None:
    net = chain(9)
    goal = Goal.where(net, [({"p9": 1}, ">=", 1)])
    assert bound_for(net, goal) is not None
    assert bound_for(net, Goal.where(net, [({"p9": 1}, ">=", 2)])) is None, "excluded"
    assert bound_for(net, Goal.where(net, [({"p2": 1}, ">=", 1)])) is None, "near"
    assert bound_for(net, Goal.where(net, [({"p9": 1}, "!=", 0)])) is None, "two conjunctions"
    assert bound_for(net, Goal.enabled(net, "on8", "off8")) is None, "two transitions"
    assert bound_for(net, Goal.deadlock()) is None


@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """Markings by search, as they are made."""
    seen: list[int] = []
    run = search.Search.run

    def counting(self: search.Search) -> None:
        run(self)
        seen.append(self.markings)

    monkeypatch.setattr(search.Search, "run", counting)
    yield seen


def test_fewer_markings_than_a_plain_search(runs: list[int]) -> None:
    net = reference_case_study((1, 1, 1), "input")
    goal = Goal.enabled(net, next(t for t in net.transitions if "ShowResult" in t))
    plain = find_all(net, [goal])[0]
    few = sum(runs)
    runs.clear()
    led = find(net, goal)
    assert len(led.stem) == len(plain.stem) > 40
    assert sum(runs) < few * 0.7


def test_far_goals_of_large_state_spaces() -> None:
    """A way of 16 steps among 5e47 markings, of which a plain search sees the first few levels."""
    net = classic.philosophers(100)
    eating = [p for p in net.places if p.lower().startswith("eat")]
    goal = Goal.where(net, [({place: 1}, ">=", 1) for place in eating[:16:2]])
    answer = find(net, goal, Budget(states=200_000))
    assert len(answer.stem) == 16 and goal.holds(net, replay(net, answer.stem)[-1])
    assert find_all(net, [goal], Budget(states=200_000))[0].reason == "states"


@pytest.mark.usefixtures("led_from_the_start")
def test_a_second_search_may_find_longer_ways() -> None:
    """What is met first is a shortest way of 5 steps; what is less far below the bound takes 6."""
    net = CompiledNet.build(
        {"a": 2, "b": 0, "c": 0, "d": 0},
        [
            ("ab", {"a": 1}, {"b": 1}),
            ("bc", {"b": 1}, {"c": 1}),
            ("cd", {"c": 2}, {"d": 2}),
            ("dc", {"d": 1}, {"c": 1}),
        ],
    )
    answer = find(net, Goal.enabled(net, "dc"), Budget(MEMORY), workers=1)
    assert len(answer.stem) == min(
        steps for marking, steps in distances(net).items() if net.is_enabled(3, marking)
    )


@pytest.mark.long
@pytest.mark.usefixtures("led_from_the_start")
def test_ways_beyond_the_cheapest_marking(runs: list[int]) -> None:
    """Where the bound is below 0 in the marking met first, a second search looks for a shorter way."""
    picked, again = random.Random(1), 0
    for _ in range(300):
        size = picked.randint(3, 6)
        places = [f"p{i}" for i in range(size)]
        transitions: list[Transition] = []
        for t in range(size + 2):
            one, other = picked.sample(places, 2)
            weight, gain = picked.choice([(1, 1), (2, 2), (2, 1), (3, 1)])
            transitions.append(Transition(f"t{t}", {one: weight}, {other: gain}))
        net = CompiledNet.build({place: picked.randint(0, 3) for place in places}, transitions)
        distance = distances(net)
        for t in range(len(transitions)):
            goal = Goal((t,))
            best = min(
                (steps for marking, steps in distance.items() if goal.holds(net, marking)), default=None
            )
            runs.clear()
            answer = find(net, goal, Budget(MEMORY), workers=1)
            again += len(runs) > 2
            runs.clear()
            assert find(net, goal, Budget(MEMORY), is_shortest=False).status == answer.status
            assert len(runs) <= 2, "any way will do"
            assert (None if answer.trace is None else len(answer.trace)) == best
    assert again > 10


def test_unbounded_places_are_searched_without_a_bound() -> None:
    net = CompiledNet.build(
        {"a": 1, "b": 0, "c": 0}, [("more", {"a": 1}, {"a": 1, "b": 1}), ("take", {"b": 50}, {"c": 1})]
    )
    answer = find(net, Goal.where(net, [({"c": 1}, ">=", 1)]))
    assert answer.trace is not None and len(answer.trace) == 51


def test_bounds_are_fractions_of_a_firing() -> None:
    net = chain(9)
    first, last = Comparison({0: 1}, "<=", 0), Comparison({8: 1, 9: 1}, ">=", 1)
    known = bound_for(net, Goal(conjunctions=((first, last),)))
    assert known is not None and known.bound(net.initial.tolist()) == 8 * known.unit
    # Half a token would do: 8 steps of it, and one step of the other half.
    known = bound_for(net, Goal(conjunctions=((first, Comparison({8: 2, 9: 1}, ">=", 1)),)))
    assert known is not None and (known.bound(net.initial.tolist()), known.unit) == (9, 2)
