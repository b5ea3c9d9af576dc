"""A part of a net as a separate net: some places, with the transitions that change or test them.

Conditions on other places are ignored, so the part can do everything that the net can, and more. A complement
for each place keeps its bound, which may depend on other places in the whole net.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from dineros.analysis.nets.compiled import CompiledNet, Transition


def cut_out(
    net: CompiledNet, places: Sequence[int], transitions: Iterable[int], free: Mapping[int, int]
) -> CompiledNet:
    """Return a part of a net.

    Parameters
    ----------
    places : sequence of int
        Places of the part, in this order; their complements follow them.
    transitions : iterable of int
        Transitions of the part, in order.
    free : mapping of int to int
        For each place of the part, how many tokens it may have beyond its initial ones.

    Examples
    --------
    >>> net = CompiledNet.build({"a": 1, "b": 0}, [("t", {"a": 1}, {"b": 1})])
    >>> part = cut_out(net, [1], [0], {1: 1})
    >>> part.initial.tolist(), part.delta
    ([0, 1], ({0: 1, 1: -1},))
    """
    inside = set(places)

    def row(pairs: tuple[tuple[int, int], ...]) -> dict[str, int]:
        return {net.places[place]: weight for place, weight in pairs if place in inside}

    made = []
    for transition in transitions:
        inputs, outputs = row(net.pre.row(transition)), row(net.post.row(transition))
        for place, change in net.delta[transition].items():
            if place in inside and change > 0:
                inputs[_room(net, place)] = change
            elif place in inside and change < 0:
                outputs[_room(net, place)] = -change
        inhibitors = row(net.inhibitor.row(transition))
        made.append(Transition(net.transitions[transition], inputs, outputs, inhibitors))
    marked = {net.places[place]: int(net.initial[place]) for place in places}
    marked |= {_room(net, place): free[place] for place in places}
    return CompiledNet.build(marked, made)


def _room(net: CompiledNet, place: int) -> str:
    return f"{net.places[place]}\0"  # names of places have no NUL, so the name is unused
