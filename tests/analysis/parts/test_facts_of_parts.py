"""What a part takes over from its net, semiflows and bounds, is true of the part."""

from __future__ import annotations

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.parts.part import TOO_LARGE, GrowingPart, Whole
from dineros.analysis.symbolic.engine import symbolic_state_space
from tests.analysis.parts.test_part_firings import nets_of_machines
from tests.analysis.strategies import nets


@pytest.mark.parametrize("kind", [nets_of_machines(), nets()], ids=["machines", "nets"])
def test_facts(kind: st.SearchStrategy[CompiledNet]) -> None:
    @settings(max_examples=30, deadline=None)
    @given(kind, st.data())
    def check(net: CompiledNet, data: st.DataObject) -> None:
        whole = Whole(net)
        assume(whole.free)
        places = data.draw(st.sets(st.sampled_from(sorted(whole.free)), min_size=1))
        try:
            part = GrowingPart(whole, places, (), Budget(seconds=20).begun(), 2_000_000)
        except TOO_LARGE:
            return
        flows, bounds = part._facts(sorted(places))
        assert flows is not None
        initial = part.net.initial.tolist()
        for flow in flows:
            assert sum(initial[p] * weight for p, weight in flow.weights.items()) == flow.constant
            assert all(
                sum(flow.weights.get(p, 0) * tokens for p, tokens in change.items()) == 0
                for change in part.net.delta
            )
        assert len(bounds) == len(initial)
        for most, bound in zip(part.space.largest_place(), bounds, strict=True):
            assert bound is not None
            assert most <= bound.value
        assert part.space.markings == symbolic_state_space(part.net).markings

    check()
