"""Runs that are planned in the relaxed net, and tried in the net."""

from __future__ import annotations

from itertools import pairwise

from hypothesis import given, settings

from dineros.analysis.callbacks.plans import Plans
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import replay
from tests.analysis.strategies import nets


@given(nets())
@settings(deadline=None)
def test_a_plan_is_a_firing_sequence_to_its_transition(net: CompiledNet) -> None:
    plans = Plans(net)
    for transition in range(len(net.transitions)):
        way = plans.way_to(transition)
        if way is not None:
            assert way[-1] == transition
            replay(net, way)


def test_what_is_taken_twice_has_no_plan() -> None:
    net = CompiledNet.build({"a": 1, "b": 0}, [("t", {"a": 1}, {"b": 1}), ("u", {"b": 2}, {})])
    assert Plans(net).way_to(0) == (0,)
    assert Plans(net).way_to(1) is None


def test_what_can_never_fire_has_no_plan() -> None:
    net = CompiledNet.build({"a": 0, "b": 0}, [("t", {"a": 1}, {"b": 1})])
    assert Plans(net).way_to(0) is None


def test_a_chain_is_planned_without_what_does_not_lead_there() -> None:
    names = [f"p{number}" for number in range(50)]
    steps = [
        (f"t{number}", {name: 1}, {then: 1, "log": 1}) for number, (name, then) in enumerate(pairwise(names))
    ]
    noise = [(f"n{number}", {"always": 1}, {"always": 1, f"heap{number}": 1}) for number in range(30)]
    places = {name: int(name == "p0") for name in [*names, "log"]} | {"always": 1}
    places |= {f"heap{number}": 0 for number in range(30)}
    net = CompiledNet.build(places, [*noise, *steps])
    assert Plans(net).way_to(len(noise) + 48) == tuple(range(len(noise), len(noise) + 49))
