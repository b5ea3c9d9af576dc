"""A sequence can be fired in the part of a net that its transitions use exactly if the net can fire it."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import can_fire, replay
from dineros.analysis.walks.used_part import UsedPart
from tests.analysis.strategies import nets


@given(nets(), st.data())
@settings(max_examples=200, deadline=None)
def test_the_part_fires_what_the_net_fires(net: CompiledNet, data: st.DataObject) -> None:
    own = st.sampled_from(range(len(net.transitions)))
    used = data.draw(st.lists(own, min_size=1, max_size=4))
    part = UsedPart(net, used)
    sequence = data.draw(st.lists(st.sampled_from(used), max_size=6))
    inside = part.inside(sequence)
    assert part.outside(inside) == sequence
    fires = can_fire(net, sequence, net.initial.tolist())
    assert can_fire(part.net, inside, part.net.initial.tolist()) == fires
    if fires:
        whole = dict(zip(net.places, replay(net, sequence)[-1], strict=True))
        small = dict(zip(part.net.places, replay(part.net, inside)[-1], strict=True))
        assert small == {place: whole[place] for place in part.net.places}
        start = dict(zip(net.places, net.initial.tolist(), strict=True))
        assert all(whole[place] == start[place] for place in net.places if place not in small)
