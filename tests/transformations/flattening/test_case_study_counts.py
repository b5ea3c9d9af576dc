"""The flattened case study has the places, transitions and reachable markings that its description says."""

from __future__ import annotations

import pytest

from case_study.build import build
from dineros.metamodel import pn
from dineros.metamodel.elements import find, places, transitions
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.rules.phases import OverflowVariant, SignalVariant
from tests.support.reachability import ReachabilityGraph
from tests.support.references.flattening import plain_net_of

SIZES: dict[SignalVariant, tuple[int, int]] = {
    "none": (149, 127),
    "input-enabled": (188, 185),
    "io-enabled": (188, 243),
    "fully-enabled": (188, 145),
}
MARKINGS: list[tuple[tuple[int, int, int], SignalVariant, int]] = [
    ((1, 0, 0), "none", 432),
    ((1, 1, 0), "none", 9_640),
    ((1, 0, 0), "input-enabled", 4_942),
    ((1, 0, 0), "io-enabled", 30_016),
]


def net_of(objects: tuple[int, int, int], signals: SignalVariant, overflow: OverflowVariant) -> pn.Net:
    model = build()
    for colour, tokens in zip(("Red", "Blue", "Green"), objects, strict=True):
        pool = find(model, f"{colour}Objects", pn.Place)
        pool.tokens = tokens
    return flatten(model, signals, overflow).net


@pytest.mark.long
@pytest.mark.parametrize("overflow", ["weighted", "inhibitor"])
@pytest.mark.parametrize("signals", SIZES)
def test_places_and_transitions(signals: SignalVariant, overflow: OverflowVariant) -> None:
    net = net_of((1, 1, 1), signals, overflow)

    assert (len(places(net)), len(transitions(net))) == SIZES[signals]


@pytest.mark.long
@pytest.mark.parametrize("overflow", ["weighted", "inhibitor"])
@pytest.mark.parametrize(("objects", "signals", "expected"), MARKINGS)
def test_reachable_markings(
    objects: tuple[int, int, int], signals: SignalVariant, expected: int, overflow: OverflowVariant
) -> None:
    net = plain_net_of(net_of(objects, signals, overflow))

    assert ReachabilityGraph(net).count(limit=expected + 1) == expected
