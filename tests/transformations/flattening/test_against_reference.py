"""The rules against a second flattener that shares no code with them: equal nets but for names."""

from __future__ import annotations

from typing import get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from case_study.build import build
from dineros.metamodel import sym
from dineros.metamodel.constraints import validate
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.rules.phases import OverflowVariant, SignalVariant
from tests.support.isomorphism import are_isomorphic
from tests.support.reachability import ReachabilityGraph, TooManyMarkingsError
from tests.support.references.flattening import PlainNet, plain_net_of, reference_flattening
from tests.support.systems.calling_systems import calling_systems
from tests.support.systems.models import system_models
from tests.support.systems.small_systems import small_system_models

SIGNALS: tuple[SignalVariant, ...] = get_args(SignalVariant)
OVERFLOW: tuple[OverflowVariant, ...] = get_args(OverflowVariant)


def both(
    model: sym.SystemModel, signals: SignalVariant, overflow: OverflowVariant
) -> tuple[PlainNet, PlainNet]:
    return plain_net_of(flatten(model, signals, overflow).net), reference_flattening(model, signals, overflow)


@given(small_system_models(clients=0))
@settings(max_examples=30)
def test_the_small_models_are_valid(model: sym.SystemModel) -> None:
    assert [found for found in validate(model) if found.severity == "error"] == []


@given(small_system_models(clients=0), st.sampled_from(SIGNALS), st.sampled_from(OVERFLOW))
@settings(max_examples=50)
def test_small_models(model: sym.SystemModel, signals: SignalVariant, overflow: OverflowVariant) -> None:
    flattened, reference = both(model, signals, overflow)

    assert len(flattened.places) == len(reference.places)
    assert len(flattened.transitions) == len(reference.transitions)
    assert are_isomorphic(flattened, reference)


@pytest.mark.long
@given(system_models(), st.sampled_from(SIGNALS), st.sampled_from(OVERFLOW))
@settings(max_examples=25)
def test_models_with_everything(
    model: sym.SystemModel, signals: SignalVariant, overflow: OverflowVariant
) -> None:
    assert are_isomorphic(*both(model, signals, overflow))


@pytest.mark.long
@given(calling_systems(circles=True), st.sampled_from(SIGNALS), st.sampled_from(OVERFLOW))
@settings(max_examples=50)
def test_ports_inside_server_pages(
    model: sym.SystemModel, signals: SignalVariant, overflow: OverflowVariant
) -> None:
    assert [found for found in validate(model) if found.severity == "error"] == []
    flattened, reference = both(model, signals, overflow)

    assert len(flattened.places) == len(reference.places)
    assert are_isomorphic(flattened, reference)


@given(small_system_models(), st.sampled_from(SIGNALS), st.sampled_from(OVERFLOW))
@settings(max_examples=30)
def test_equal_numbers_of_markings(
    model: sym.SystemModel, signals: SignalVariant, overflow: OverflowVariant
) -> None:
    counts = []
    for net in both(model, signals, overflow):
        try:
            counts.append(ReachabilityGraph(net).count(limit=2000))
        except TooManyMarkingsError:
            counts.append(-1)

    assert counts[0] == counts[1]


@pytest.mark.long
@pytest.mark.parametrize(
    ("signals", "overflow"),
    [("none", "inhibitor"), ("fully-enabled", "weighted"), ("input-enabled", "weighted")],
)
def test_the_case_study(signals: SignalVariant, overflow: OverflowVariant) -> None:
    assert are_isomorphic(*both(build(), signals, overflow))


@pytest.mark.long
def test_a_difference_is_noticed() -> None:
    flattened, reference = both(build(), "none", "weighted")
    source, target, weight, kind = reference.arcs[-1]
    assert kind == "normal"
    for changed in (
        reference.arcs[:-1],
        [*reference.arcs, reference.arcs[-1]],
        [*reference.arcs[:-1], (source, target, weight + 1, kind)],
        [*reference.arcs[:-1], (source, target, weight, "read")],
        [*reference.arcs[:-1], (target, source, weight, kind)],
    ):
        altered = PlainNet(reference.places, reference.transitions, changed, reference.overrides)
        assert not are_isomorphic(flattened, altered)
