"""Differential tests: explicit engine = symbolic engine = plain reference search."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings

from dineros.analysis.answers.budget import Budget
from dineros.analysis.explicit import explore
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.symbolic import engine as symbolic
from dineros.analysis.symbolic.counting import DiagramCounts
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.analysis.symbolic.kernels.diagrams import POOL_LIMIT
from dineros.analysis.symbolic.levels import UnknownBoundError, encode
from dineros.analysis.symbolic.saturation import Diagram
from tests.analysis import classic_nets as classic
from tests.analysis.reference_case_study import MARKINGS, SIGNAL_VARIANTS, SIZES, reference_case_study
from tests.analysis.reference_search import ReferenceCounts, reference_search
from tests.analysis.strategies import nets

REFERENCE_LIMIT = 3_000


def explicit_counts(net: CompiledNet, workers: int) -> ReferenceCounts:
    space = explore(net, Budget(1 << 26), workers=workers)
    assert space.complete, space.reason
    return ReferenceCounts(
        space.markings, space.arcs, space.deadlocks, space.largest_place, space.largest_total
    )


def symbolic_counts(net: CompiledNet) -> ReferenceCounts:
    space = symbolic_state_space(net, Budget(1 << 26))
    assert space.complete, space.reason
    deadlocks = space.deadlocks()
    assert deadlocks is not None
    return ReferenceCounts(
        space.markings, space.arcs(), deadlocks, space.largest_place(), space.largest_total()
    )


@given(nets())
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_engines_agree_with_reference_on_generated_nets(net: CompiledNet) -> None:
    expected = reference_search(net, REFERENCE_LIMIT)
    if expected is None:
        space = explore(net, Budget(1 << 24), workers=1)
        assert space.markings > REFERENCE_LIMIT or space.reason in ("unbounded", "memory")
        return
    assert explicit_counts(net, 1) == expected
    assert symbolic_counts(net) == expected


@pytest.mark.long
@pytest.mark.parametrize(
    "net",
    [
        classic.philosophers(5),
        classic.kanban(2),
        classic.flexible_manufacturing(2),
        classic.round_robin_mutex(6),
        CompiledNet.build({"a": 0}, []),
        CompiledNet.build({"a": 1}, [Transition("t", {}, {}, {"a": 1})]),
        CompiledNet.build({"a": 3}, [Transition("t", {"a": 2}, {"a": 1}, {}, {"a": 1})]),
    ],
)
@pytest.mark.parametrize("workers", [1, 2, 3])
def test_engines_agree_with_reference_on_classic_nets(net: CompiledNet, workers: int) -> None:
    expected = reference_search(net)
    assert expected is not None
    assert explicit_counts(net, workers) == expected
    assert symbolic_counts(net) == expected


def test_published_counts() -> None:
    assert symbolic_state_space(classic.philosophers(10)).markings == 59_049
    assert symbolic_state_space(classic.philosophers(20)).markings == 3_486_784_401
    assert symbolic_state_space(classic.swimming_pool(1)).markings == 89_621
    assert symbolic_state_space(classic.flexible_manufacturing(5)).markings == 2_895_018
    space = symbolic_state_space(classic.kanban(5))
    assert (space.markings, space.arcs()) == (2_546_432, 24_460_016)


def test_published_counts_explicitly() -> None:
    space = explore(classic.kanban(5))
    assert (space.markings, space.arcs) == (2_546_432, 24_460_016)


@pytest.mark.long
@pytest.mark.parametrize("signals", SIGNAL_VARIANTS)
@pytest.mark.parametrize("overflow", ["inhibitor", "weighted"])
@pytest.mark.parametrize("objects", MARKINGS)
def test_case_study(objects, signals, overflow) -> None:  # type: ignore[no-untyped-def]
    net = reference_case_study(objects, signals, overflow)
    assert (len(net.places), len(net.transitions)) == SIZES[signals]
    expected = MARKINGS[objects][signals]
    assert symbolic_state_space(net).markings == expected
    if expected < 200_000:
        assert explore(net).markings == expected


@pytest.mark.parametrize("objects", [(2, 1, 0), (3, 3, 3)])
def test_signals_vary_independently_when_fully_enabled(objects: tuple[int, int, int]) -> None:
    none = symbolic_state_space(reference_case_study(objects, "none"))
    fully = symbolic_state_space(reference_case_study(objects, "fully"))
    assert fully.markings == none.markings * 2**9


def test_unbounded_net_is_recognised() -> None:
    net = CompiledNet.build({"a": 1, "b": 0}, [("grow", {"a": 1}, {"a": 1, "b": 1})])
    space = explore(net)
    assert not space.complete
    assert space.reason == "unbounded"
    assert space.pumping is not None
    with pytest.raises(UnknownBoundError, match="b"):
        symbolic_state_space(net)


def test_memory_budget_ends_with_what_was_seen() -> None:
    space = symbolic_state_space(reference_case_study((3, 3, 3), "io"), Budget(1 << 16))
    assert not space.complete and space.reason == "memory"
    # It gives up after a few orders: what is left of the search would not make a small store large.
    assert space.search_work < 5_000_000


def test_the_same_net_takes_the_same_way(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(symbolic, "ROUNDS", symbolic.ROUNDS[1:])  # the first round searches nothing
    spaces = [symbolic_state_space(reference_case_study((2, 2, 2), "input")) for _ in range(2)]
    assert len({space.order for space in spaces}) == 1
    assert len({space.diagram.effort for space in spaces}) == 1
    assert len({space.search_work for space in spaces}) == 1


def test_a_store_may_be_full_at_any_moment() -> None:
    net = classic.kanban(2)
    order = range(len(encode(net).levels))
    diagram = Diagram(encode(net), order, 1 << 20)
    ended = {True: 0, False: 0}
    for words in range(200, 3_000, 7):
        diagram.restart(order)
        diagram.control[POOL_LIMIT] = words
        complete = diagram.run()
        ended[complete and diagram.collections > 0] += 1
        assert complete != diagram.out_of_memory
        if complete:
            assert DiagramCounts(diagram).vectors() == 4_600
    assert min(ended.values()) >= 5  # some runs ended early, and some collected garbage and counted right


def test_satisfying_and_enabled_counts() -> None:
    net = classic.kanban(2)
    space = symbolic_state_space(net)
    reached, frontier = set(), [tuple(net.initial.tolist())]
    for marking in frontier:
        if marking not in reached:
            reached.add(marking)
            frontier += [
                tuple(net.fire(t, marking)) for t in range(len(net.transitions)) if net.is_enabled(t, marking)
            ]
    out, kan = net.places.index("out1"), net.places.index("kanban4")
    assert space.satisfying({"out1": (1, None), "kanban4": (0, 1)}) == sum(
        m[out] >= 1 and m[kan] <= 1 for m in reached
    )
    for t, name in enumerate(net.transitions):
        assert space.enabled(name) == sum(net.is_enabled(t, m) for m in reached)


def test_known_order_is_taken_again() -> None:
    first = symbolic_state_space(reference_case_study((1, 1, 1), "none"))
    again = symbolic_state_space(reference_case_study((2, 2, 2), "none"), order=first.order)
    assert again.complete and len(again.order) == len(first.order)


def test_wide_nodes_count_as_more_work() -> None:
    """Else a hundred thousand tokens keep an interrupt, or a budget, waiting for minutes."""

    def effort(tokens: int) -> int:
        arcs = [("t", {"a": 1}, {"b": 1}), ("u", {"b": 1}, {"c": 1}), ("v", {"c": 1}, {"a": 1})]
        space = symbolic_state_space(CompiledNet.build({"a": tokens, "b": 0, "c": 0}, arcs))
        assert space.markings == (tokens + 1) * (tokens + 2) // 2
        return space.diagram.effort

    assert effort(1500) > 5 * effort(500)
