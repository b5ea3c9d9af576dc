"""Independent parts of a net: no transition of one part touches a changing place of another one.

The markings of the net are all combinations of those of its parts, so they are counted part by part. A place
that no transition changes belongs to no part, since its conditions are decided at once.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.graph_parts import representatives
from dineros.analysis.symbolic.canonical import arranged


@dataclass(frozen=True)
class Independent:
    """A net as independent parts, or as one part that is the net itself.

    Attributes
    ----------
    parts : tuple of CompiledNet
        The changing places, with the transitions that touch them and that no constant place disables.
    constant : tuple of int
        Tokens of each place that no transition changes.
    always_enabled : int
        Number of transitions that are enabled in all markings and touch no changing place.
    """

    parts: tuple[CompiledNet, ...]
    constant: tuple[int, ...]
    always_enabled: int


def independent(net: CompiledNet) -> Independent:
    """Return the independent parts of a net; if there is only one, the net itself.

    Examples
    --------
    >>> net = CompiledNet.build({"a": 1, "b": 1}, [("t", {"a": 1}, {}), ("u", {"b": 1}, {})])
    >>> [part.places for part in independent(net).parts]
    [('a',), ('b',)]
    """
    touched = [_touched(net, t) for t in range(len(net.transitions))]
    changing = [place for place, transitions in enumerate(net.changing) if transitions]
    part_of = representatives(changing, (tuple(places) for places in touched if places))
    inside: defaultdict[int, list[int]] = defaultdict(list)
    for place in changing:
        inside[part_of[place]].append(place)
    if len(inside) < 2:
        return Independent((net,), (), 0)
    firing: defaultdict[int, list[int]] = defaultdict(list)
    always_enabled = 0
    for t, places in enumerate(touched):
        if _is_disabled(net, t):
            continue
        if places:
            firing[part_of[places[0]]].append(t)
        else:
            always_enabled += 1
    return Independent(
        tuple(_part(net, places, firing[first]) for first, places in inside.items()),
        tuple(int(net.initial[p]) for p, transitions in enumerate(net.changing) if not transitions),
        always_enabled,
    )


def shape(net: CompiledNet) -> tuple[bytes, ...]:
    """Return a key: nets with the same one differ at most in names and in the order of their elements."""
    net = arranged(net).net
    tables = (net.pre, net.post, net.inhibitor)
    arcs = (array.tobytes() for table in tables for array in (table.pointer, table.place, table.weight))
    return (net.initial.tobytes(), *arcs)


def _touched(net: CompiledNet, transition: int) -> list[int]:
    """Return the changing places that a transition tests or changes."""
    places = net.tested(transition) | net.delta[transition].keys()
    return sorted(place for place in places if net.changing[place])


def _is_disabled(net: CompiledNet, transition: int) -> bool:
    """Return whether a constant place disables a transition forever."""
    initial, changing = net.initial, net.changing
    return any(initial[p] < weight for p, weight in net.pre.row(transition) if not changing[p]) or any(
        initial[p] >= weight for p, weight in net.inhibitor.row(transition) if not changing[p]
    )


def _part(net: CompiledNet, places: list[int], transitions: list[int]) -> CompiledNet:
    made = []
    for t in transitions:
        rows = (
            {net.places[place]: weight for place, weight in table.row(t) if net.changing[place]}
            for table in (net.pre, net.post, net.inhibitor)
        )
        made.append(Transition(net.transitions[t], *rows))
    return CompiledNet.build({net.places[place]: int(net.initial[place]) for place in places}, made)
