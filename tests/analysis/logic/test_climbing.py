"""Ways to a goal past switches, which alone make more markings than are ever looked at."""

from __future__ import annotations

from dineros.analysis.logic.ctl.climbing import MOST_MARKINGS, climb
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.repetition import repeatable_transitions

SWITCHES = 16
STEPS = 5


def stairs() -> CompiledNet:
    """A token climbs a step where one switch is on, the next one where another is."""
    places = {"step0": 1, **{f"step{n}": 0 for n in range(1, STEPS + 1)}}
    transitions = []
    for n in range(SWITCHES):
        places |= {f"on{n}": 0, f"off{n}": 1}
        transitions += [
            (f"up{n}", {f"off{n}": 1}, {f"on{n}": 1}),
            (f"down{n}", {f"on{n}": 1}, {f"off{n}": 1}),
        ]
    for n in range(STEPS):
        switch = {f"on{n * 3}": 1}
        transitions.append((f"climb{n}", {f"step{n}": 1, **switch}, {f"step{n + 1}": 1, **switch}))
    return CompiledNet.build(places, transitions)


def test_switches_do_not_stand_in_the_way() -> None:
    assert 2**SWITCHES > MOST_MARKINGS
    net = stairs()
    top = net.places.index(f"step{STEPS}")
    route = climb(
        net,
        tuple(net.initial.tolist()),
        lambda _: True,
        lambda marking: marking[top] == 1,
        repeatable_transitions(net),
    )
    assert route is not None
    marking = tuple(net.initial.tolist())
    for transition in route:
        assert net.is_enabled(transition, marking)
        marking = tuple(net.fire(transition, marking))
    assert marking[top] == 1
    assert len(route) == 2 * STEPS  # each step needs one switch more, and none is touched in vain


def test_too_many_markings_between_two_steps_end_it() -> None:
    places = {f"p{n}": int(n % 2 == 0) for n in range(26)} | {"never": 0}
    # Three places in a ring each: no transition undoes another one.
    places |= {f"q{n}": 0 for n in range(13)}
    transitions = []
    for n in range(13):
        ring = [f"p{2 * n}", f"p{2 * n + 1}", f"q{n}"]
        transitions += [(f"t{n}.{i}", {ring[i]: 1}, {ring[(i + 1) % 3]: 1}) for i in range(3)]
    net = CompiledNet.build(places, transitions)
    never = net.places.index("never")
    start = tuple(net.initial.tolist())
    found = climb(net, start, lambda _: True, lambda m: m[never] == 1, repeatable_transitions(net))
    assert found is None
