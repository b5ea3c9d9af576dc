"""Tests of compiled nets, invariants, semiflows, bounds and dropped places."""

from __future__ import annotations

import pytest
from hypothesis import given, settings

from dineros.analysis.nets.bounds import place_bounds
from dineros.analysis.nets.compiled import CompiledNet, NetError
from dineros.analysis.nets.structure import place_invariants, semiflows
from dineros.analysis.symbolic.levels import UnknownBoundError, encode
from tests.analysis import classic_nets as classic
from tests.analysis.reference_case_study import reference_case_study
from tests.analysis.reference_search import reference_search
from tests.analysis.strategies import nets


@given(nets())
@settings(max_examples=100, deadline=None)
def test_invariants_span_the_kernel(net: CompiledNet) -> None:
    import numpy as np

    found = place_invariants(net)
    rank = np.linalg.matrix_rank(net.incidence) if net.incidence.size else 0
    assert len(found) == len(net.places) - rank
    for invariant in found:
        row = np.zeros(len(net.places), dtype=np.int64)
        row[list(invariant.weights)] = list(invariant.weights.values())
        assert not (row @ net.incidence).any()
        assert invariant.exact and invariant.constant == row @ net.initial


@given(nets())
@settings(max_examples=100, deadline=None)
def test_bounds_hold(net: CompiledNet) -> None:
    counts = reference_search(net, 500)
    bounds = place_bounds(net, semiflows(net))
    if counts is not None:
        for bound, largest in zip(bounds, counts.largest_place, strict=True):
            assert bound is None or bound.value >= largest


def test_invariants_of_the_semantics_are_found() -> None:
    net = reference_case_study((2, 1, 1), "input", "weighted")
    names = [{net.places[p]: w for p, w in y.weights.items()} for y in semiflows(net)]
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
    assert all(bound is not None and bound.value == 3 for bound in place_bounds(net, semiflows(net)))


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
