"""Hypothesis strategies for small nets: weights, inhibitor arcs, read arcs, bounded or not."""

from __future__ import annotations

from hypothesis import strategies as st

from dineros.analysis.nets.compiled import CompiledNet, Transition


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
