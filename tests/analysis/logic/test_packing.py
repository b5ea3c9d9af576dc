"""Packed markings: what goes in comes out, in every layout."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.analysis.logic import check_ctl, verify_ltl
from dineros.analysis.logic.graphs.packing import Layout
from dineros.analysis.nets.compiled import CompiledNet


@given(st.lists(st.integers(0, 2**30), max_size=40), st.lists(st.integers(0, 2**50), max_size=40))
def test_markings_survive_packing_and_widening(tokens: list[int], more: list[int]) -> None:
    layout = Layout(tuple(max(1, count.bit_length()) for count in tokens), 3)
    words = layout.pack(tokens, 5)
    assert layout.unpack(words) == tuple(tokens)
    assert not (words & layout.guards).any()
    wider = layout.widened([max(pair) for pair in zip(tokens, [*more, *tokens], strict=False)])
    converted = layout.convert(np.array([words, words]), wider)
    assert converted.tolist() == [wider.pack(tokens, 5).tolist()] * 2


def test_the_smallest_layout_holds_weights() -> None:
    net = CompiledNet.build({"p": 1, "q": 0}, [("t", {"p": 1}, {"q": 9}, {"q": 3})])
    assert Layout.smallest(net).bits == (1, 4)


def test_too_many_tokens_for_any_field() -> None:
    with pytest.raises(OverflowError):
        Layout((1,)).widened([2**63])


def test_nets_without_places_or_transitions() -> None:
    empty = CompiledNet.build({}, [])
    assert verify_ltl(empty, "G (deadlock & !F false)").status == "holds"
    assert check_ctl(empty, "AG deadlock").status == "holds"
    free = CompiledNet.build({}, [("t",)])
    assert verify_ltl(free, "G F fired(t)").status == "holds"
    assert check_ctl(free, "EG enabled(t) & AG !deadlock").status == "holds"
