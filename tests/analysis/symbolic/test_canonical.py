"""A net becomes the same one whatever the names and the order of its elements."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.symbolic.canonical import arranged
from tests.analysis import classic_nets as classic
from tests.analysis.reference_case_study import reference_case_study
from tests.analysis.strategies import nets
from tests.support.shuffled_nets import shuffled

NETS = {
    "philosophers": classic.philosophers(30),
    "kanban": classic.kanban(4),
    "manufacturing": classic.flexible_manufacturing(3),
    "round robin": classic.round_robin_mutex(20),
    "pool": classic.swimming_pool(1),
    "case study": reference_case_study((1, 1, 1), "io"),
    "alike, apart": CompiledNet.build(
        dict.fromkeys("abcd", 1), [(f"t{p}", {p: 1}, {q: 1}) for p, q in ("ab", "ba", "cd", "dc")]
    ),
    "nothing": CompiledNet.build({}, []),
}


def shape(net: CompiledNet) -> list[list[int]]:
    """Return all of a net but its names."""
    tables = (net.pre, net.post, net.inhibitor)
    return [
        net.initial.tolist(),
        *(part.tolist() for arcs in tables for part in (arcs.pointer, arcs.place, arcs.weight)),
    ]


@pytest.mark.parametrize("name", NETS)
@pytest.mark.parametrize("seed", range(5))
def test_shuffled_nets_become_the_same(name: str, seed: int) -> None:
    assert shape(arranged(shuffled(NETS[name], seed)).net) == shape(arranged(NETS[name]).net)


@given(nets(), st.integers(0, 100))
def test_it_is_the_net_itself_in_another_order(net: CompiledNet, seed: int) -> None:
    net = shuffled(net, seed)
    found = arranged(net)
    assert sorted(found.places) == list(range(len(net.places)))
    assert sorted(found.transitions) == list(range(len(net.transitions)))
    for number, transition in enumerate(found.transitions):
        assert found.net.transitions[number] == net.transitions[transition]
        pairs = ((net.pre, found.net.pre), (net.post, found.net.post), (net.inhibitor, found.net.inhibitor))
        for before, after in pairs:
            arcs = [(found.places[place], weight) for place, weight in after.row(number)]
            assert sorted(arcs) == list(before.row(transition))
    assert [net.places[place] for place in found.places] == list(found.net.places)
    assert net.initial[list(found.places)].tolist() == found.net.initial.tolist()
