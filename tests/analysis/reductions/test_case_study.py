"""Algorithm 4 of the paper: the reduced nets of fully-enabled and of no signals count the same."""

from __future__ import annotations

import pytest

from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.reductions import MutableNet, Property, Reduction, reduce, replay
from tests.analysis.reductions.brute_force import Graph
from tests.analysis.reference_case_study import MARKINGS, OverflowVariant, SignalVariant, reference_case_study
from tests.analysis.reference_search import reference_search

OBJECTS = (1, 0, 0)


def _count(net: CompiledNet) -> int:
    counts = reference_search(net)
    assert counts is not None
    return counts.markings


@pytest.mark.long
@pytest.mark.parametrize("overflow", ["weighted", "inhibitor"])
@pytest.mark.parametrize("item", Property)
def test_fully_enabled_and_none_count_the_same(item: Property, overflow: OverflowVariant) -> None:
    fully, none = (reduce(reference_case_study(OBJECTS, v, overflow), {item}) for v in ("fully", "none"))
    assert _count(fully.net) == _count(none.net)
    assert len(fully.net.places) == len(none.net.places)


def test_the_signals_vanish_and_the_rest_counts_what_it_counts_without_them() -> None:
    fully, none = (reference_case_study(OBJECTS, v, "weighted") for v in ("fully", "none"))
    reduction = reduce(fully, {"kept_places"}, observed_places=none.places)
    assert reduction.net.places == none.places
    assert _count(reduction.net) == _count(none) == MARKINGS[OBJECTS]["none"] == 432
    without = reduce(none, {"kept_places"}, observed_places=none.places)
    assert _count(without.net) == 432


@pytest.mark.parametrize("objects", [(1, 0, 0), (1, 1, 0)])
def test_factors_give_the_unreduced_counts(objects: tuple[int, int, int]) -> None:
    # 4096 = 512 values of the nine signals * 8 markings of the safety loop, which others only test.
    factors: dict[SignalVariant, int] = {"none": 8, "fully": 4096}
    for variant, factor in factors.items():
        reduction = reduce(reference_case_study(objects, variant), {"state_space_size"})
        assert reduction.count_factor == factor
        assert _count(reduction.net) * factor == MARKINGS[objects][variant]


def test_signals_that_depend_on_the_net_stay() -> None:
    reduction = reduce(reference_case_study(OBJECTS, "input"), {"state_space_size"})
    assert "Sensor" in reduction.net.places or "not Sensor" in reduction.net.places
    assert _count(reduction.net) * reduction.count_factor == MARKINGS[OBJECTS]["input"]


@pytest.mark.long
@pytest.mark.parametrize("variant", ["none", "fully", "input"])
@pytest.mark.parametrize("item", Property)
def test_witnesses_replay_on_the_unreduced_net(variant: SignalVariant, item: Property) -> None:
    net = reference_case_study(OBJECTS, variant)
    reduction = reduce(net, {item}, observed_places=["Shown"])
    trace = _trace_to_shown(reduction)
    assert replay(MutableNet.of(net), reduction.expand(trace))["Shown"] == 1


def _trace_to_shown(reduction: Reduction) -> list[str]:
    graph = Graph.of(reduction.net, 8_000)
    position = reduction.net.places.index("Shown")
    return graph.trace_to(next(marking for marking in graph.successors if marking[position]))
