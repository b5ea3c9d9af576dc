"""Places that share a level hold at most one token together."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given

from dineros.analysis.nets import bounds as bounds_of_places
from dineros.analysis.nets.bounds import flows_and_bounds
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.symbolic import grouping
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.analysis.symbolic.grouping import groups_of_bounds, groups_of_wide_net
from dineros.analysis.symbolic.levels import encode
from dineros.analysis.symbolic.saturation import Diagram
from tests.analysis.reference_case_study import reference_case_study
from tests.analysis.reference_search import distances, reference_search
from tests.analysis.strategies import SLOW, nets


def readers(values: int, readers: int) -> CompiledNet:
    """Each reader reads one of several values, and forgets it."""
    places = {f"value{v}": 1 for v in range(values)}
    transitions = []
    for r in range(readers):
        places[f"start{r}"] = 1
        for v in range(values):
            places[f"read{r}.{v}"] = 0
            value = {f"value{v}": 1}
            transitions.append((f"read{r}.{v}", {f"start{r}": 1, **value}, {f"read{r}.{v}": 1, **value}))
            transitions.append((f"forget{r}.{v}", {f"read{r}.{v}": 1}, {}))
    return CompiledNet.build(places, transitions)


def shared_memory(size: int) -> CompiledNet:
    """Each processor uses the memory of each other one over one bus: 3^n + n(n - 1)3^(n - 1) markings."""
    places = {"bus": 1}
    transitions = []
    for p in range(size):
        places |= {f"memory{p}": 1, f"active{p}": 1, f"queue{p}": 0, f"own{p}": 0}
        transitions.append((f"ask{p}", {f"active{p}": 1}, {f"queue{p}": 1}))
        transitions.append((f"begin{p}", {f"active{p}": 1}, {f"own{p}": 1}))
        transitions.append((f"end{p}", {f"own{p}": 1}, {f"active{p}": 1}))
        for m in set(range(size)) - {p}:
            places[f"uses{p}.{m}"] = 0
            free = {f"memory{m}": 1, "bus": 1}
            transitions.append((f"take{p}.{m}", {f"queue{p}": 1, **free}, {f"uses{p}.{m}": 1}))
            transitions.append((f"free{p}.{m}", {f"uses{p}.{m}": 1}, {f"active{p}": 1, **free}))
    return CompiledNet.build(places, transitions)


@pytest.mark.parametrize("with_flows", [True, False])
def test_places_of_a_wide_group_go_to_narrower_ones(
    with_flows: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    size = 5
    monkeypatch.setattr(grouping, "WIDE", 3 * size)
    if not with_flows:
        monkeypatch.setattr(bounds_of_places, "semiflows", lambda net: None)
    net = shared_memory(size)
    assert max(len(level.states) for level in encode(net).levels) == size + 3
    space = symbolic_state_space(net)
    expected = reference_search(net)
    assert expected is not None
    assert space.markings == expected.markings == 3**size + size * (size - 1) * 3 ** (size - 1)
    assert (space.arcs(), space.deadlocks()) == expected[1:3]


def test_a_wide_group_alone_stays_together(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(grouping, "WIDE", 3)
    ring = {f"p{n}": int(n == 0) for n in range(9)}
    net = CompiledNet.build(ring, [(f"t{n}", {f"p{n}": 1}, {f"p{(n + 1) % 9}": 1}) for n in range(9)])
    assert len(encode(net).levels) == 1


@given(nets(largest_weight=1))
@SLOW
def test_groups_of_a_wide_net_have_at_most_one_token(net: CompiledNet) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(grouping, "WIDE", 1)
        _, bounds = net.once(flows_and_bounds)
        places = [p for p, bound in enumerate(bounds) if bound and bound.value == 1]
        groups = groups_of_wide_net(net, places, bounds)
        assert len({place for group in groups for place in group}) == sum(map(len, groups))
        for marking in distances(net):
            assert all(sum(marking[place] for place in group) <= 1 for group in groups)


def test_wide_levels_at_the_top_are_tried_where_spans_are_long(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(grouping, "WIDE", 64)
    space = symbolic_state_space(shared_memory(20))
    assert space.markings == 3**20 + 20 * 19 * 3**19
    assert space.diagram.effort < 100_000  # 280 000 under the best of the other orders


def test_wide_levels_at_the_top_get_little_work_before_short_searches(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Levels of the case study differ in width, but a short search finds an order with 100 000 misses."""
    used: list[int] = []
    run = Diagram.run

    def counting(self: Diagram, *args: Any) -> bool:
        before = self.effort
        is_complete = run(self, *args)
        used.append(self.effort - before if self.effort >= before else self.effort)
        return is_complete

    monkeypatch.setattr(Diagram, "run", counting)
    assert symbolic_state_space(reference_case_study((5, 5, 5), "input")).complete
    assert sum(used) < 1_000_000


@given(nets(largest_weight=1))
@SLOW
def test_a_group_has_at_most_one_token(net: CompiledNet) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(grouping, "WORTH_GROUPING", 1.0)
        _, bounds = net.once(flows_and_bounds)
        groups = groups_of_bounds(net, (p for p, b in enumerate(bounds) if b and b.value == 1), bounds)
        assert len({place for group in groups for place in group}) == sum(map(len, groups))
        for marking in distances(net):
            assert all(sum(marking[place] for place in group) <= 1 for group in groups)
        expected = reference_search(net, 2_000)
        if groups and expected is not None and all(bounds):
            space = symbolic_state_space(net)
            assert (space.markings, space.arcs(), space.deadlocks()) == expected[:3]
            assert space.largest_place() == expected.largest_place


@pytest.mark.parametrize("most", [2, 3, 64])
def test_values_that_are_read_and_forgotten(most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(grouping, "MOST_TOGETHER", most)
    monkeypatch.setattr(grouping, "WORTH_GROUPING", 1.0)
    net = readers(4, 3)
    assert len(encode(net).levels) == 3 * -(-5 // most)
    expected = reference_search(net)
    assert expected is not None
    space = symbolic_state_space(net)
    assert (space.markings, space.arcs(), space.deadlocks()) == expected[:3] == (216, 3 * 8 * 36, 1)
    assert space.largest_place() == expected.largest_place
    assert space.largest_total() == expected.largest_total


def test_many_values_need_few_levels() -> None:
    space = symbolic_state_space(readers(300, 3))
    assert space.markings == 302**3
    assert len(space.order) == 15


def test_places_that_never_change_have_no_level() -> None:
    net = CompiledNet.build({"a": 1, "b": 0, "key": 2}, [("t", {"a": 1, "key": 2}, {"b": 1, "key": 2})])
    space = symbolic_state_space(net)
    assert "key" not in {place for level in space.order for place in level}
    assert (space.markings, space.largest_place(), space.largest_total()) == (2, (1, 1, 2), 3)
    assert space.satisfying({"key": (2, None)}) == 2
    assert space.satisfying({"key": (0, 1)}) == 0
    locked = CompiledNet.build({"a": 1, "b": 0, "key": 1}, [("t", {"a": 1, "key": 2}, {"b": 1, "key": 2})])
    assert symbolic_state_space(locked).markings == 1
    still = symbolic_state_space(CompiledNet.build({"key": 2}, [("t", {"key": 1}, {"key": 1})]))
    assert (still.markings, still.arcs(), still.deadlocks(), still.largest_total()) == (1, 1, 0, 2)
