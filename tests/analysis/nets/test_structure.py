"""Tests of compiled nets, invariants, semiflows, bounds and dropped places."""

from __future__ import annotations

import itertools
from typing import Any

import networkx as nx
import numpy as np
import pytest
from hypothesis import example, given, settings
from numpy.typing import NDArray

from dineros.analysis.nets import bounds as bounds_module
from dineros.analysis.nets.bounds import flows_and_bounds, place_bounds
from dineros.analysis.nets.compiled import CompiledNet, NetError
from dineros.analysis.nets.linear_programs import LinearProgram
from dineros.analysis.nets.semiflows import semiflows
from dineros.analysis.nets.state_machines import state_machines
from dineros.analysis.nets.structure import place_invariants, proportional_places
from dineros.analysis.symbolic.levels import UnknownBoundError, encode
from tests.analysis import classic_nets as classic
from tests.analysis.reference_case_study import reference_case_study
from tests.analysis.reference_search import reachability_graph, reference_search
from tests.analysis.strategies import nets


def incidence_matrix(net: CompiledNet) -> NDArray[np.int64]:
    """Tokens that a firing adds, by place and transition."""
    matrix = np.zeros((len(net.places), len(net.transitions)), dtype=np.int64)
    for transition, change in enumerate(net.delta):
        matrix[list(change), transition] = list(change.values())
    return matrix


@given(nets())
@settings(max_examples=100, deadline=None)
def test_invariants_span_the_kernel(net: CompiledNet) -> None:
    found, incidence = place_invariants(net), incidence_matrix(net)
    rank = np.linalg.matrix_rank(incidence) if incidence.size else 0
    assert len(found) == len(net.places) - rank
    for invariant in found:
        row = np.zeros(len(net.places), dtype=np.int64)
        row[list(invariant.weights)] = list(invariant.weights.values())
        assert not (row @ incidence).any()
        assert invariant.constant == row @ net.initial


@given(nets())
@settings(max_examples=100, deadline=None)
def test_bounds_hold(net: CompiledNet) -> None:
    counts = reference_search(net, 500)
    if counts is not None:
        for bounds in (flows_and_bounds(net)[1], place_bounds(net)):
            for bound, largest in zip(bounds, counts.largest_place, strict=True):
                assert bound is None or bound.value >= largest


_OTHER_PLACE_PAYS = CompiledNet.build(
    {"p0": 1, "p1": 0, "p2": 0, "p3": 1, "p4": 0},
    [("t0", {"p0": 1}, {"p4": 1}), ("t1", {"p0": 2, "p4": 2}, {"p3": 2, "p4": 2})],
)
"""The weighting of p3 also bounds p4, by 2; the best one of p4 bounds it by 1."""
_ROUNDED = CompiledNet.build(
    {"p0": 0, "p1": 0, "p2": 0, "p3": 2, "p4": 1, "p5": 3},
    [
        ("t0", {"p0": 1, "p4": 2}, {"p1": 2, "p3": 1}),
        ("t1", {"p3": 1, "p4": 1}, {"p0": 1}),
        ("t2", {"p1": 1}, {"p2": 1}),
    ],
)
"""A weighted sum of 2 bounds p1, of weight 3, by 0; with equal weights, the bound is 1."""


@given(nets())
@example(_OTHER_PLACE_PAYS)
@example(_ROUNDED)
@settings(max_examples=100, deadline=None)
def test_linear_programs_bound_as_tightly_as_semiflows(net: CompiledNet) -> None:
    # All of these nets are small, so that each place gets a program of its own.
    assert semiflows(net) is not None
    for bound, other in zip(flows_and_bounds(net)[1], place_bounds(net), strict=True):
        assert (bound is None) == (other is None)
        assert bound is None or other is None or other.value <= bound.value


def test_programs_bound_places_more_tightly_than_semiflows() -> None:
    net = CompiledNet.build(
        {"p0": 1, "p1": 0, "p2": 1, "p3": 1, "p4": 0},
        [
            ("t0", {"p4": 1}, {"p4": 1}),
            ("t1", {"p0": 1, "p1": 1}, {"p2": 1, "p3": 1}),
            ("t2", {"p2": 1}, {"p4": 1}),
            ("t3", {"p2": 1, "p3": 1}, {"p0": 1, "p4": 1}),
        ],
    )
    assert semiflows(net) is not None
    bound = flows_and_bounds(net)[1][3]
    assert bound is not None and bound.value == 1  # the semiflow of p0 and p3 bounds it by 2


def test_a_place_that_never_gets_a_token_is_bounded_by_its_own_weighting() -> None:
    net = CompiledNet.build(
        {"p": 0, "q": 2, "r": 0}, [("take", {"r": 1}, {}), ("make", {"p": 1, "r": 1}, {"q": 2})]
    )
    bounds = place_bounds(net)
    assert [bound.value for bound in bounds if bound is not None] == [0, 2, 0]


@given(nets())
@settings(max_examples=100, deadline=None)
def test_proportional_places_are_proportional(net: CompiledNet) -> None:
    found, incidence = proportional_places(net), incidence_matrix(net)
    for invariant in found:
        for change in net.delta:
            assert sum(w * change.get(p, 0) for p, w in invariant.weights.items()) == 0
    # None is left out: two places are connected by what was found if, and only if, they are proportional.
    graph: nx.Graph[int] = nx.Graph()
    graph.add_nodes_from(range(len(net.places)))
    graph.add_edges_from((min(y.weights), max(y.weights)) for y in found if len(y.weights) == 2)
    constant = {p for p, row in enumerate(incidence) if not row.any()}
    assert {p for y in found if len(y.weights) == 1 for p in y.weights} == constant
    for p, q in itertools.combinations(sorted(set(range(len(net.places))) - constant), 2):
        is_proportional = np.linalg.matrix_rank(incidence[[p, q]]) == 1
        assert nx.has_path(graph, p, q) == is_proportional


@given(nets())
@settings(max_examples=100, deadline=None)
def test_state_machines_hold_one_token(net: CompiledNet) -> None:
    graph = None if reference_search(net, 500) is None else reachability_graph(net)
    groups = state_machines(net, range(len(net.places)))
    assert len({p for group in groups for p in group}) == sum(map(len, groups))
    for marking in graph or ():
        for group in groups:
            assert sum(marking[p] for p in group) <= 1


def test_state_machines_of_philosophers_are_their_forks() -> None:
    net = classic.philosophers(6)
    groups = state_machines(net, range(len(net.places)))
    alone = set(range(len(net.places))) - {p for group in groups for p in group}
    assert len(groups[0]) == 5
    assert {net.places[p] for p in alone} == {f"think{i}" for i in range(6)}


def test_a_spent_share_gives_way() -> None:
    net = classic.philosophers(6)
    assert semiflows(net, most_work=100) is None
    assert len(place_invariants(net, work=20)) < len(place_invariants(net))
    program = LinearProgram(net.delta, len(net.places), most_work=10)
    zeros = np.zeros(len(net.places))
    assert program.solve(zeros, np.zeros(len(net.delta)), zeros, zeros) is None


def test_invariants_of_the_semantics_are_found() -> None:
    net = reference_case_study((2, 1, 1), "input", "weighted")
    names = [{net.places[p]: w for p, w in y.weights.items()} for y in semiflows(net) or ()]
    assert {"StateGet": 1, "StateEnd": 1} in names
    assert {"Red": 1, "not Red": 1} in names
    queue = "LeftCellObjects.publish.SortRed"
    assert {f"{queue}.Load": 1, f"{queue}.Capacity": 1} in names


def test_determined_places_are_recovered() -> None:
    net = reference_case_study((1, 1, 0), "input")
    boxes = encode(net).boxes
    marking = net.initial.tolist()
    for _ in range(200):
        enabled = [t for t in range(len(net.transitions)) if net.is_enabled(t, marking)]
        marking = net.fire(enabled[sum(marking) * 7 % len(enabled)], marking)
        assert boxes.full_marking({p: marking[p] for p in boxes.kept}) == marking


def test_kanban_bounds() -> None:
    net = classic.kanban(3)
    assert all(bound is not None and bound.value == 3 for bound in place_bounds(net))


def test_unknown_bounds_name_the_places() -> None:
    net = CompiledNet.build({"a": 1, "b": 0}, [("grow", {"a": 1}, {"a": 1, "b": 1})])
    with pytest.raises(UnknownBoundError, match="b"):
        encode(net)


@pytest.mark.parametrize(
    ("places", "transitions", "message"),
    [
        ({"a": -1}, [], "starts with -1"),
        ({"a": 1}, [("t", {"b": 1})], "unknown place 'b'"),
        ({"a": 1}, [("t", {"a": 0})], "weight 0"),
        ({"a": 1}, [("t", {}), ("t", {})], "more than once: t"),
    ],
)
def test_wrong_nets_are_refused(places, transitions, message) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(NetError, match=message):
        CompiledNet.build(places, transitions)


def test_importing_the_package_does_not_import_numba() -> None:
    import subprocess
    import sys

    modules = "dineros.analysis, dineros.analysis.nets.compiled, dineros.analysis.nets.structure"
    code = f"import sys, {modules}; print('numba' in sys.modules)"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "False"


def test_bounds_are_proved_once_for_a_net() -> None:
    net = CompiledNet.build({"a": 1, "b": 0}, [("t", {"a": 1}, {"b": 1})])
    assert place_bounds(net) is place_bounds(net)


def test_parts_of_a_weighting_are_sought_once_for_places_after_the_same_marked_places(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # One search per place took 40 s for 17 000 places.
    chain = ["first", *(f"p{i}" for i in range(200))]
    moves = [(f"t{i}", {a: 1}, {b: 1}) for i, (a, b) in enumerate(itertools.pairwise(chain))]
    ends = [("end", {chain[-1]: 1}, {"last": 1}), ("other", {"second": 1}, {"last": 1})]
    net = CompiledNet.build(
        {"first": 2, "second": 1, "last": 0} | dict.fromkeys(chain[1:], 0), [*moves, *ends]
    )
    calls: list[object] = []
    flowing = bounds_module._flowing_to

    def counted(*given: Any) -> dict[int, int]:
        calls.append(given)
        return flowing(*given)

    monkeypatch.setattr(bounds_module, "_flowing_to", counted)
    values = {
        place: bound and bound.value for place, bound in zip(net.places, place_bounds(net), strict=True)
    }
    assert values == {**dict.fromkeys(chain, 2), "second": 1, "last": 3}
    assert len(calls) <= 3


@given(nets())
@settings(max_examples=100, deadline=None)
def test_parts_of_a_weighting_give_the_least_sums(net: CompiledNet) -> None:
    producers = bounds_module.producers_of(net)
    for flow in semiflows(net) or []:
        found: list[bounds_module.Bound | None] = [None] * len(net.places)
        bounds_module._use(net, found, flow.weights)
        bounds_module._use_parts(net, found, producers, flow.weights)
        for place, weight in flow.weights.items():
            part, size = {place}, 0
            while len(part) > size:
                size = len(part)
                into = {t for p in part for t in producers[p]}
                part |= {p for t in into for p, n in net.delta[t].items() if n < 0 and p in flow.weights}
            bound = found[place]
            assert bound is not None
            assert bound.value == sum(int(net.initial[p]) * flow.weights[p] for p in part) // weight
            assert not bounds_module.grows(net, bound.weights)
