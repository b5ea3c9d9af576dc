"""What is counted on a reduced net, against plain search of the net itself."""

from __future__ import annotations

from math import comb

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.model.subject import subject_of
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.portfolio.count import StateSpace
from dineros.analysis.questions.reduced_space import reduced_state_space
from dineros.analysis.questions.state_space import Engine
from dineros.analysis.sweeps.grid import Point
from dineros.analysis.sweeps.point import Job, count
from dineros.metamodel import sym
from dineros.metamodel.elements import transitions
from dineros.metamodel.files.xmi.writer import xmi_bytes
from dineros.transformations.rules.phases import SignalVariant
from tests.analysis.covering.plain import plain_search
from tests.analysis.reductions.generated_nets import nets as nets_with_patterns
from tests.analysis.strategies import nets
from tests.support.systems.small_systems import small_system_models

SIGNALS: list[SignalVariant] = ["none", "fully-enabled", "input-enabled", "io-enabled"]
MOST = 3_000


def without_priorities(model: sym.SystemModel) -> sym.SystemModel:
    """Priorities are not analysed."""
    for transition in transitions(model):
        transition.overrides.clear()
    return model


MODELS = small_system_models().map(without_priorities)


def agrees(net: CompiledNet, engine: Engine = "auto") -> StateSpace | None:
    """Compare figures with plain search, where that ends; None where it does not."""
    seen = plain_search(net, MOST)
    if not seen.is_complete:
        return None
    space = reduced_state_space(net, engine)
    assert space.complete
    assert space.states == len(seen.markings)
    assert space.deadlocks == sum(
        not any(net.is_enabled(t, marking) for t in range(len(net.transitions))) for marking in seen.markings
    )
    assert (space.arcs, space.max_tokens_in_place, space.max_tokens_in_marking) == (None, None, None)
    assert space.places <= len(net.places) and (space.reduced_states or 0) <= space.states
    return space


@pytest.mark.parametrize("engine", ["auto", "explicit"])
@settings(max_examples=30, deadline=None)
@given(net=st.one_of(nets(), nets_with_patterns()))
def test_figures_of_a_reduced_net_are_those_of_the_net(net: CompiledNet, engine: Engine) -> None:
    agrees(net, engine)


@pytest.mark.long
@pytest.mark.parametrize("signals", SIGNALS)
@settings(max_examples=12, deadline=None)
@given(model=MODELS)
def test_of_all_signal_variants(model: sym.SystemModel, signals: SignalVariant) -> None:
    net = subject_of(model, signals, "weighted").net
    agrees(net)


def test_input_enabled_nets_shrink() -> None:
    # A signal that changes only while its transition could fire, in a chain of places.
    net = CompiledNet.build(
        {"a": 3, "b": 0, "c": 0, "d": 0, "on": 0, "off": 1},
        [
            ("t", {"a": 1}, {"b": 1}),
            ("u", {"b": 1}, {"c": 1}),
            ("v", {"c": 1, "on": 1}, {"d": 1, "on": 1}),
            ("rise", {"off": 1, "c": 1}, {"on": 1, "c": 1}),
            ("fall", {"on": 1, "c": 1}, {"off": 1, "c": 1}),
        ],
    )
    space = agrees(net)
    assert space is not None and space.reduced_states is not None and space.states is not None
    assert space.reduced_states < space.states


def test_weights_of_any_size_are_exact() -> None:
    names = [f"p{i}" for i in range(40)]
    rows = [(f"t{i}", {names[i]: 1}, {names[i + 1]: 1}) for i in range(39)]
    net = CompiledNet.build({name: 60 if name == "p0" else 0 for name in names}, rows)
    space = reduced_state_space(net)
    assert (space.states, space.deadlocks, space.reduced_states) == (comb(99, 39), 1, 1)


def test_an_unbounded_net_shows_its_own_loop() -> None:
    rows = [("t", {"a": 1}, {"a": 1, "b": 1}), ("u", {"b": 1}, {"c": 1})]
    net = CompiledNet.build({"a": 1, "b": 0, "c": 0}, rows)
    space = reduced_state_space(net)
    assert not space.complete and space.pumping is not None
    assert space.pumping.suffix == (0,)


@settings(max_examples=5, deadline=None)
@given(model=MODELS, signals=st.sampled_from(SIGNALS))
def test_a_sweep_prints_the_same_of_both(model: sym.SystemModel, signals: SignalVariant) -> None:
    points = [Point((), signals, "weighted", reduced) for reduced in (False, True)]
    whole, reduced = (count(Job(xmi_bytes(model).decode(), point)) for point in points)
    assert (whole.states, whole.deadlocks, whole.complete) == (
        reduced.states,
        reduced.deadlocks,
        reduced.complete,
    )
    assert whole.reduced_states is None and reduced.arcs is None
