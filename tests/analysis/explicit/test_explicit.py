"""Explicit engine against the reference search: counts, witnesses, limits, unbounded nets."""

from __future__ import annotations

import itertools
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget, Progress
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.explicit import (
    Goal,
    Order,
    explore,
    find,
    find_all,
    search,
)
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.witness import WitnessError, replay
from tests.analysis import classic_nets as classic
from tests.analysis.reference_case_study import MARKINGS, SIGNAL_VARIANTS, reference_case_study
from tests.analysis.reference_search import REFERENCE_LIMIT, ReferenceCounts, distances, reference_search
from tests.analysis.strategies import SLOW, goals, nets

WAYS: list[tuple[int, Order]] = [(1, "breadth-first"), (2, "breadth-first"), (1, "depth-first")]
MEMORY = 1 << 26


@pytest.fixture
def threads_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let all workers go at levels of any size."""
    monkeypatch.setattr(search, "LEAST_FOR_THREADS", 1)
    monkeypatch.setattr(search, "LEAST_WITH_GOALS", 0)


def counts(net: CompiledNet, workers: int = 1, order: Order = "breadth-first") -> ReferenceCounts:
    space = explore(net, Budget(MEMORY), workers=workers, order=order)
    assert space.complete, space.reason
    return ReferenceCounts(
        space.markings, space.arcs, space.deadlocks, space.largest_place, space.largest_total
    )


@pytest.mark.usefixtures("threads_at_once")
@given(nets(), st.sampled_from(WAYS))
@SLOW
def test_counts_agree_with_reference_on_generated_nets(net: CompiledNet, way: tuple[int, Order]) -> None:
    workers, order = way
    expected = reference_search(net, REFERENCE_LIMIT)
    if expected is None:
        space = explore(net, Budget(MEMORY, states=5 * REFERENCE_LIMIT), workers=workers, order=order)
        assert space.markings > REFERENCE_LIMIT or space.reason == "unbounded"
        assert (space.reason == "unbounded") == (space.pumping is not None)
        return
    assert counts(net, workers, order) == expected


@pytest.mark.usefixtures("threads_at_once")
@given(st.data())
@SLOW
def test_witnesses_are_shortest_on_generated_nets(data: st.DataObject) -> None:
    net = data.draw(nets())
    wanted = data.draw(st.lists(goals(net), min_size=1, max_size=3))
    distance = distances(net)
    if not distance:
        return
    for reduction in (None, "stubborn"):
        workers = data.draw(st.sampled_from([1, 2]))
        for goal, answer in zip(
            wanted, find_all(net, wanted, Budget(MEMORY), reduction=reduction, workers=workers), strict=True
        ):
            best = min((d for m, d in distance.items() if goal.holds(net, m)), default=None)
            if best is None:
                assert answer.status == "unreachable"
                assert answer.states == len(distance) or reduction or len(wanted) > 1
            else:
                assert answer.trace is not None and len(answer.trace) == best
                assert goal.holds(net, replay(net, answer.stem)[-1])


@given(st.data())
@SLOW
def test_depth_first_finds_what_is_there(data: st.DataObject) -> None:
    net = data.draw(nets())
    wanted = data.draw(st.lists(goals(net), min_size=1, max_size=3))
    distance = distances(net)
    if not distance:
        return
    for reduction in (None, "stubborn"):
        answers = find_all(net, wanted, Budget(MEMORY), order="depth-first", reduction=reduction)
        for goal, answer in zip(wanted, answers, strict=True):
            if any(goal.holds(net, marking) for marking in distance):
                assert answer.status == "reachable"
                assert goal.holds(net, replay(net, answer.stem)[-1])
            else:
                assert answer.status == "unreachable"


@given(nets(), st.sampled_from(["breadth-first", "depth-first"]))
@SLOW
def test_stubborn_sets_keep_all_deadlocks(net: CompiledNet, order: Order) -> None:
    distance = distances(net)
    if distance:
        space = explore(net, Budget(MEMORY), reduction="stubborn", order=order, workers=1)
        assert space.complete and space.markings <= len(distance)
        assert space.deadlocks == sum(Goal.deadlock().holds(net, marking) for marking in distance)


@given(nets())
@SLOW
def test_dead_transitions_on_generated_nets(net: CompiledNet) -> None:
    distance = distances(net)
    if distance:
        expected = [any(net.is_enabled(t, m) for m in distance) for t in range(len(net.transitions))]
        assert explore(net, Budget(MEMORY), workers=1).enabled.tolist() == expected


@pytest.mark.long
@pytest.mark.parametrize(
    "net",
    [
        classic.philosophers(5),
        classic.kanban(2),
        classic.flexible_manufacturing(2),
        classic.round_robin_mutex(6),
        CompiledNet.build({"a": 0}, []),
        CompiledNet.build({}, []),
        CompiledNet.build({}, [Transition("t")]),
        CompiledNet.build({"a": 1}, [Transition("t", {}, {}, {"a": 1})]),
        CompiledNet.build({"a": 3}, [Transition("t", {"a": 2}, {"a": 1}, {}, {"a": 1})]),
        CompiledNet.build({"a": 1000, "b": 0}, [Transition("t", {"a": 7}, {"b": 3})]),
    ],
)
@pytest.mark.parametrize(("workers", "order"), [*WAYS, (3, "breadth-first")])
@pytest.mark.usefixtures("threads_at_once")
def test_counts_agree_with_reference(net: CompiledNet, workers: int, order: Order) -> None:
    if net.places:
        assert counts(net, workers, order) == reference_search(net)
    else:
        assert counts(net, workers).markings == 1


@pytest.mark.parametrize("signals", SIGNAL_VARIANTS)
def test_case_study(signals: str) -> None:
    for objects, workers in ((1, 0, 0), 1), ((1, 0, 0), 2), ((1, 1, 0), 2):
        expected = MARKINGS[objects][signals]  # type: ignore[index]
        if expected < 200_000:
            assert counts(reference_case_study(objects, signals), workers).markings == expected  # type: ignore[arg-type]


@pytest.mark.long
def test_large_state_spaces() -> None:
    space = explore(classic.kanban(5))
    assert (space.markings, space.arcs) == (2_546_432, 24_460_016)
    assert explore(classic.flexible_manufacturing(5)).markings == 2_895_018
    space = explore(classic.kanban(4), order="depth-first")
    assert (space.markings, space.arcs) == (454_475, 3_979_850)
    assert explore(reference_case_study((1, 1, 1), "input")).markings == MARKINGS[1, 1, 1]["input"]


def test_published_counts() -> None:
    assert counts(classic.philosophers(10)).markings == 59_049
    assert counts(classic.swimming_pool(1), 2).markings == 89_621


def test_wide_markings() -> None:
    """More words than kernels are specialised for, and more transitions than bits in a word."""
    size = 150
    places = {f"p{i}": int(i == 0) * 3 for i in range(size)} | {f"q{i}": 0 for i in range(size)}
    ring = [Transition(f"t{i}", {f"p{i}": 1}, {f"p{(i + 1) % size}": 1}) for i in range(4)]
    ring += [Transition(f"u{i}", {f"p{i}": 3}, {f"q{i}": 5}, {f"q{(i + 1) % size}": 4}) for i in range(size)]
    net = CompiledNet.build(places, ring)
    assert counts(net) == reference_search(net)
    assert counts(net, 2) == reference_search(net)
    assert counts(net, order="depth-first") == reference_search(net)


@pytest.mark.long
@pytest.mark.parametrize("order", ["breadth-first", "depth-first"])
def test_places_outgrow_their_cells(order: Order) -> None:
    """No invariant bounds b, but an inhibitor arc does, far above the first size of a cell."""
    net = CompiledNet.build(
        {"a": 1, "b": 0, "c": 0},
        [
            ("up", {"a": 1}, {"a": 1, "b": 3}, {"b": 5_000}),
            ("mark", {"b": 4_000}, {"c": 1, "b": 4_000}, {"c": 300}),
        ],
    )
    assert counts(net, order=order) == reference_search(net)
    answer = find(net, Goal.where(net, [({"c": 1}, "=", 299), ({"b": 1}, ">", 4_500)]))
    assert answer.trace is not None and len(answer.trace) == 1_501 + 299


def test_unbounded_net_is_recognised() -> None:
    net = CompiledNet.build(
        {"a": 1, "b": 0}, [("grow", {"a": 1}, {"a": 1, "b": 1}), ("swap", {"b": 2}, {"a": 1})]
    )
    space = explore(net)
    assert not space.complete and space.reason == "unbounded" and space.pumping is not None
    markings = replay(net, space.pumping.prefix + space.pumping.suffix)
    start, end = markings[len(space.pumping.prefix)], markings[-1]
    assert all(after >= before for before, after in zip(start, end, strict=True)) and start != end


def test_goal_in_an_unbounded_net() -> None:
    net = CompiledNet.build({"a": 0, "b": 0}, [("more", {}, {"a": 1}), ("take", {"a": 200}, {"b": 1})])
    answer = find(net, Goal.enabled(net, "take"))
    assert answer == Outcome("reachable", (0,) * 200)
    assert replay(net, answer.stem)[-1] == [200, 0]
    answer = find(net, Goal.where(net, [({"a": 1}, "<", 0)]), Budget(states=5_000))
    assert answer.status == "unknown" and answer.reason == "unbounded"


def test_limits_end_with_what_was_seen() -> None:
    net = classic.kanban(4)
    small = explore(net, Budget(1 << 21), workers=1)
    assert small.reason == "memory" and 1_000 < small.markings < 454_475 and small.memory <= 1 << 21
    assert explore(net, Budget(1 << 22), workers=2).reason == "memory"
    assert explore(net, Budget(states=10_000)).reason == "states"
    assert explore(net, Budget(seconds=0)).reason == "time"
    answer = find(net, Goal.where(net, [({"out1": 1}, ">", 9)]), Budget(states=100), workers=1)
    assert answer.status == "unknown" and answer.reason == "states" and 100 < (answer.states or 0) < 1_000


def test_progress_may_interrupt(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "PROGRESS_SECONDS", 0.0)
    reports = []

    def stop(progress: Progress) -> None:
        reports.append(progress)
        if len(reports) == 3:
            raise KeyboardInterrupt

    space = explore(classic.kanban(4), Budget(progress=stop))
    assert space.reason == "interrupted" and len(reports) == 3 and 0 < space.markings < 454_475


def test_a_search_that_is_asked_to_end_after_its_time_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "PROGRESS_SECONDS", 0.0)

    def stop(_: Progress) -> None:
        time.sleep(0.05)
        raise KeyboardInterrupt  # as the process that watches over the time has it

    assert explore(classic.kanban(4), Budget(seconds=0.04, progress=stop)).reason == "time"


def test_stubborn_sets_are_small_where_nothing_conflicts() -> None:
    places = {f"a{i}": 1 for i in range(12)} | {f"b{i}": 0 for i in range(12)}
    net = CompiledNet.build(places, [(f"t{i}", {f"a{i}": 1}, {f"b{i}": 1}) for i in range(12)])
    answer = find(net, Goal.deadlock(), reduction="stubborn")
    assert answer.trace is not None and len(answer.trace) == 12
    assert explore(net, reduction="stubborn").markings == 13
    assert find(net, Goal.where(net, [({"a0": 1, "b0": 1}, "=", 2)]), reduction="stubborn") == Outcome(
        "unreachable", states=1
    )


@pytest.mark.long
def test_goals_of_many_shapes_at_once() -> None:
    net = reference_case_study((1, 0, 0), "none")
    wanted = [Goal((t,)) for t in range(len(net.transitions))]
    distance: dict[int, int] = {}
    for marking, steps in distances(net).items():
        for t in range(len(net.transitions)):
            if net.is_enabled(t, marking):
                distance.setdefault(t, steps)
    for workers, reduction in itertools.product((1, 2), (None, "stubborn")):
        answers = find_all(net, wanted, workers=workers, reduction=reduction)  # type: ignore[arg-type]
        for t, answer in enumerate(answers):
            assert (len(answer.trace) if answer.trace is not None else None) == distance.get(t)


def test_ordinary_searches_find_the_same_traces_on_any_number_of_processors(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Which thread stores a marking first is chance; the trace that is shown must not depend on it."""
    monkeypatch.setattr(search, "LEAST_FOR_THREADS", 1)
    net = reference_case_study((2, 1, 1), "none")
    wanted = [Goal((t,)) for t in range(len(net.transitions))]
    alone = find_all(net, wanted, workers=1)
    for _ in range(3):
        assert [each.trace for each in find_all(net, wanted, workers=3)] == [each.trace for each in alone]


def test_a_wrong_witness_is_never_shown() -> None:
    net = CompiledNet.build({"a": 0}, [("t", {"a": 1}, {})])
    with pytest.raises(WitnessError, match="step 0: transition 't'"):
        replay(net, [0])


def test_goals_are_of_one_kind() -> None:
    with pytest.raises(ValueError, match="not several"):
        Goal((0,), is_deadlock=True)
