"""Hypothesis strategies for small nets: weights, inhibitor arcs, read arcs, bounded or not."""

from __future__ import annotations

from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

from dineros.analysis.explicit import Comparison, Goal
from dineros.analysis.nets.compiled import CompiledNet, Transition

SLOW = settings(
    max_examples=25,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
"""For tests of engines, which take long."""


@st.composite
def nets(draw: st.DrawFn, largest_weight: int = 2) -> CompiledNet:
    """A net of up to five places and six transitions."""
    places = [f"p{i}" for i in range(draw(st.integers(1, 5)))]
    arcs = st.dictionaries(st.sampled_from(places), st.integers(1, largest_weight), max_size=2)
    few = st.dictionaries(st.sampled_from(places), st.integers(1, largest_weight), max_size=1)
    transitions = [
        Transition(f"t{i}", draw(arcs), draw(arcs), draw(few), draw(few))
        for i in range(draw(st.integers(1, 6)))
    ]
    return CompiledNet.build({place: draw(st.integers(0, 3)) for place in places}, transitions)


@st.composite
def goals(draw: st.DrawFn, net: CompiledNet) -> Goal:
    """A goal of any kind: transitions, a deadlock, comparisons."""
    kind = draw(st.sampled_from(["enabled", "deadlock", "where"]))
    if kind == "deadlock":
        return Goal.deadlock()
    if kind == "enabled":
        return Goal.enabled(net, *draw(st.lists(st.sampled_from(net.transitions), min_size=1, max_size=2)))
    weights = st.dictionaries(st.integers(0, len(net.places) - 1), st.integers(-2, 2), min_size=1, max_size=3)
    comparison = st.builds(
        Comparison, weights, st.sampled_from(["<", "<=", "=", "!=", ">=", ">"]), st.integers(-2, 5)
    )
    rows = draw(st.lists(st.lists(comparison, min_size=1, max_size=2), min_size=1, max_size=2))
    return Goal(conjunctions=tuple(map(tuple, rows)))
