"""Packed markings: what goes in comes out, in every layout."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.analysis.explicit.kernels.markings import repack
from dineros.analysis.explicit.layout import WIDEST, Cell, Layout
from dineros.analysis.explicit.layout import layout as choose_layout
from dineros.analysis.logic import verify_ltl
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.portfolio.branching_time import check_ctl


@given(st.lists(st.integers(0, 2**30), max_size=40), st.sets(st.integers(0, 39)), st.integers(0, 5))
def test_markings_survive_packing_and_widening(tokens: list[int], grown: set[int], number: int) -> None:
    cells = [
        Cell((place,), (1,), None, max(1, count.bit_length()), has_guard=True)
        for place, count in enumerate(tokens)
    ]
    narrow = Layout.of(cells)
    layout, wider = narrow.with_number(6), narrow.widened(grown).with_number(6)
    words, expected = layout.pack(tokens), wider.pack(tokens)
    words[layout.word[-1]] |= number << layout.shift[-1]
    expected[wider.word[-1]] |= number << wider.shift[-1]
    assert layout.unpack(words) == tokens
    assert not (words & layout.guards).any()
    converted = np.empty((2, wider.words), dtype=np.int64)
    repack(
        np.array([words, words]),
        converted,
        2,
        *(layout.word, layout.shift, layout.masks),
        *(wider.word, wider.shift),
    )
    assert converted.tolist() == [expected.tolist()] * 2


def test_the_smallest_layout_holds_weights() -> None:
    net = CompiledNet.build({"p": 1, "q": 0}, [("t", {}, {"q": 900}, {"p": 2})])
    bits = {cell.places[0]: cell.bits for cell in choose_layout(net).cells if cell.places == (1,)}
    assert bits == {1: 10}


def test_too_many_tokens_for_any_field() -> None:
    with pytest.raises(OverflowError):
        Layout.of([Cell((0,), (1,), None, WIDEST, has_guard=True)]).widened({0})
    net = CompiledNet.build({"p": 2**62}, [("t", {"p": 1})])
    assert verify_ltl(net, "G p >= 0").reason.startswith("tokens: ")


def test_nets_without_places_or_transitions() -> None:
    empty = CompiledNet.build({}, [])
    assert verify_ltl(empty, "G (deadlock & !F false)").status == "holds"
    assert check_ctl(empty, "AG deadlock").status == "holds"
    free = CompiledNet.build({}, [("t",)])
    assert verify_ltl(free, "G F fired(t)").status == "holds"
    assert check_ctl(free, "EG enabled(t) & AG !deadlock").status == "holds"
