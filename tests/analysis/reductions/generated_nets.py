"""Small nets made from a sequence of choices, with the patterns in them that reduction rules look for."""

from __future__ import annotations

import random
from collections.abc import Callable

from hypothesis import strategies as st

from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.reductions import Arcs, MutableNet

#: Draws an integer between two limits, both included.
Choose = Callable[[int, int], int]


def make_net(choose: Choose) -> CompiledNet:
    """Make a net of a few places and transitions, then work some patterns into it."""
    net = MutableNet()
    for p in range(choose(2, 4)):
        net._add_place(f"p{p}", 1 if p == 0 else choose(0, 2))
    for t in range(choose(2, 6)):
        net._add_transition(f"t{t}", _arcs(net, choose))
    for k in range(choose(0, 3)):
        PATTERNS[choose(0, len(PATTERNS) - 1)](net, choose, f"x{k}")
    return net.compile()


@st.composite
def nets(draw: st.DrawFn) -> CompiledNet:
    """Nets for Hypothesis."""
    return make_net(lambda low, high: draw(st.integers(low, high)))


def random_net(seed: int) -> CompiledNet:
    """Make a net from a seed, to try many of them outside Hypothesis."""
    return make_net(random.Random(seed).randint)


def _place(net: MutableNet, choose: Choose) -> str:
    return list(net.places)[choose(0, len(net.places) - 1)]


def _transition(net: MutableNet, choose: Choose) -> str:
    return list(net.transitions)[choose(0, len(net.transitions) - 1)]


def _weight(choose: Choose) -> int:
    return 2 if choose(0, 9) == 9 else 1


def _arcs(net: MutableNet, choose: Choose) -> Arcs:
    # Most transitions take one token from one place and put one on another: what rules are made for.
    if choose(0, 3):
        return Arcs({_place(net, choose): _weight(choose)}, {_place(net, choose): _weight(choose)}, {})
    inputs = {_place(net, choose): _weight(choose) for _ in range(choose(0, 2))}
    outputs = {_place(net, choose): _weight(choose) for _ in range(choose(0, 2))}
    inhibitors = {_place(net, choose): _weight(choose) for _ in range(choose(0, 3) // 3)}
    for _ in range(choose(0, 3) // 2):
        read = _place(net, choose)
        inputs[read] = inputs.get(read, 0) + 1
        outputs[read] = outputs.get(read, 0) + 1
    return Arcs(inputs, outputs, inhibitors)


def _set(net: MutableNet, transition: str, arcs: Arcs) -> None:
    net._unlink(transition, net.transitions[transition])
    net._add_transition(transition, arcs)


def _plus(row: object, place: str, weight: int) -> dict[str, int]:
    assert isinstance(row, dict)
    return {**row, place: row.get(place, 0) + weight}


def _shadow(sign: int) -> Callable[[MutableNet, Choose, str], None]:
    """Add a place that changes with another one, in the same or the opposite direction."""

    def work(net: MutableNet, choose: Choose, name: str) -> None:
        original = _place(net, choose)
        net._add_place(name, choose(0, 3))
        factor = sign * _weight(choose)
        for t, arcs in list(net.transitions.items()):
            gain = factor * arcs.delta.get(original, 0)
            inputs, outputs = arcs.inputs, arcs.outputs
            if gain < 0:
                inputs = _plus(inputs, name, -gain)
            if gain > 0:
                outputs = _plus(outputs, name, gain)
            if gain and choose(0, 5) == 5:
                inputs, outputs = _plus(inputs, name, 1), _plus(outputs, name, 1)
            _set(net, t, Arcs(inputs, outputs, arcs.inhibitors))
        if choose(0, 1):
            t = _transition(net, choose)
            arcs = net.transitions[t]
            _set(net, t, Arcs(arcs.inputs, arcs.outputs, {**arcs.inhibitors, name: choose(1, 2)}))

    return work


def _signal(net: MutableNet, choose: Choose, name: str) -> None:
    """Add two places with transitions between them, tested by others."""
    true, false = name, f"not {name}"
    net._add_place(true, choose(0, 1))
    net._add_place(false, 1 - net.places[true])
    targets = [_transition(net, choose) for _ in range(choose(0, 2))]
    for target in targets:
        arcs = net.transitions[target]
        tested = (true, false)[choose(0, 1)]
        if choose(0, 3):
            _set(
                net,
                target,
                Arcs(_plus(arcs.inputs, tested, 1), _plus(arcs.outputs, tested, 1), arcs.inhibitors),
            )
        else:
            _set(net, target, Arcs(arcs.inputs, arcs.outputs, {**arcs.inhibitors, tested: 1}))
    net._add_transition(f"set {name}", Arcs({false: 1}, {true: 1}, {}))
    if choose(0, 3):
        net._add_transition(f"clear {name}", Arcs({true: 1}, {false: 1}, {}))
    if choose(0, 5) == 5:
        spoiled = _transition(net, choose)
        arcs = net.transitions[spoiled]
        _set(net, spoiled, Arcs(arcs.inputs, _plus(arcs.outputs, true, 1), arcs.inhibitors))


def _copied(net: MutableNet, choose: Choose, name: str) -> None:
    """Repeat a transition, perhaps with one more test."""
    arcs = net.transitions[_transition(net, choose)]
    if choose(0, 1):
        read = _place(net, choose)
        arcs = Arcs(_plus(arcs.inputs, read, 1), _plus(arcs.outputs, read, 1), arcs.inhibitors)
    net._add_transition(name, arcs)


def _composed(net: MutableNet, choose: Choose, name: str) -> None:
    """Add a transition that does what two others do."""
    one, other = (net.transitions[_transition(net, choose)] for _ in range(2))
    inputs, outputs = dict(one.inputs), dict(one.outputs)
    for place, weight in other.inputs.items():
        there = min(weight, outputs.get(place, 0))
        outputs[place] = outputs.get(place, 0) - there
        if weight > there:
            inputs[place] = inputs.get(place, 0) + weight - there
    for place, weight in other.outputs.items():
        outputs[place] = outputs.get(place, 0) + weight
    arcs = Arcs(inputs, {p: w for p, w in outputs.items() if w}, {**one.inhibitors, **other.inhibitors})
    net._add_transition(name, arcs)


def _source(net: MutableNet, choose: Choose, name: str) -> None:
    """Add a transition that can always fire."""
    net._add_transition(name, Arcs({}, {_place(net, choose): _weight(choose)}, {}))


def _identity(net: MutableNet, choose: Choose, name: str) -> None:
    """Add a transition without effect."""
    row = {_place(net, choose): _weight(choose)}
    net._add_transition(name, Arcs(row, row, {}))


def _split(net: MutableNet, choose: Choose, name: str) -> None:
    """Put a place into the middle of a transition; sometimes others end or begin there, too."""
    t = _transition(net, choose)
    arcs = net.transitions[t]
    net._add_place(name, choose(0, 4) // 4)
    _set(net, t, Arcs(arcs.inputs, {name: 1}, arcs.inhibitors))
    for k in range(choose(1, 2)):
        outputs = arcs.outputs if k == 0 else {_place(net, choose): 1}
        net._add_transition(f"{name}.{k}", Arcs({name: 1}, outputs, {}))
    if choose(0, 3) == 3:
        joined = _transition(net, choose)
        others = net.transitions[joined]
        if name not in others.inputs:
            _set(net, joined, Arcs(others.inputs, _plus(others.outputs, name, 1), others.inhibitors))


def _delayed(net: MutableNet, choose: Choose, name: str) -> None:
    """Put a place and a new input place before a transition."""
    t = _transition(net, choose)
    arcs = net.transitions[t]
    net._add_place(name, 0)
    net._add_place(f"{name}.in", choose(0, 2))
    net._add_transition(f"{name}.begin", Arcs({f"{name}.in": 1}, {name: 1}, {}))
    _set(net, t, Arcs(_plus(arcs.inputs, name, 1), arcs.outputs, arcs.inhibitors))
    feeder = _transition(net, choose)
    others = net.transitions[feeder]
    if choose(0, 1) and f"{name}.in" not in others.inputs:
        _set(net, feeder, Arcs(others.inputs, _plus(others.outputs, f"{name}.in", 1), others.inhibitors))


PATTERNS = (
    _shadow(1),
    _shadow(-1),
    _signal,
    _signal,
    _copied,
    _composed,
    _source,
    _identity,
    _split,
    _split,
    _delayed,
)
