"""Splits a net into parts that interact only by shown messages.

A silent firing changes one part and depends on no other. So the markings that are possible after some
messages
are products, with one factor for each part: the possible markings of a part depend only on its shown
transitions that have fired. Each part is small, and its sets of markings are computed once.

That holds if the first marking is known. If it is not, parts depend on each other: the initial markings of
one part depend on the messages that the others have shown before. Parts that are *joined* are followed as
one, and their first
markings are those that they can have together.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection
from dataclasses import dataclass
from itertools import chain
from typing import Literal

import networkx as nx

from dineros.analysis.nets.bounds import flows_and_bounds
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.reductions.cut_out import cut_out

ASSUMED = 16
"""Limit of the tokens of an unbounded place, beyond its initial ones."""


Joining = Literal["silence", "invariants", "all"]
"""Which places form one part: those connected by a silent firing; also those of one invariant, such as the
state of a callback; or all places that any firing connects."""


@dataclass(frozen=True)
class NetPart:
    """A part of a net, as a net of its own."""

    net: CompiledNet
    """Its places, their free room, and the transitions that change or test them."""
    places: tuple[int, ...]
    """In the whole net: the places of `net`, which are its first."""
    transitions: tuple[int, ...]
    """In the whole net: the transitions of `net`, in its order."""
    silent: frozenset[int]
    """The transitions of `net` that show no message."""
    edges: dict[int, int]
    """By unbounded place of `net`: the fewest tokens with which some firing is ignored."""


def parts_of(net: CompiledNet, shown: Collection[int], joining: Joining = "silence") -> list[NetPart]:
    """Return the parts of a net that some shown transition affects; the others never have to change.

    Parameters
    ----------
    net : CompiledNet
        The whole net.
    shown : collection of int
        The transitions that show a message.
    joining : Joining
        The criterion for one part.
    """
    touched = [
        {place for arcs in (net.pre, net.post, net.inhibitor) for place, _ in arcs.row(transition)}
        for transition in range(len(net.transitions))
    ]
    together: nx.Graph[int] = nx.Graph()
    together.add_nodes_from(range(len(net.places)))
    invariants, proved = net.once(flows_and_bounds)
    firings = (
        places for transition, places in enumerate(touched) if joining == "all" or transition not in shown
    )
    for places in chain(firings, (flow.weights for flow in invariants or () if joining != "silence")):
        nx.add_path(together, sorted(places))
    bounds = [None if bound is None else bound.value for bound in proved]
    users = defaultdict(set)
    for transition, places in enumerate(touched):
        for place in places:
            users[place].add(transition)
    parts = []
    for component in nx.connected_components(together):
        used = sorted(set().union(*(users[place] for place in component)))
        if not set(shown).isdisjoint(used):
            parts.append(_part(net, sorted(component), used, shown, bounds))
    return parts


def _part(
    net: CompiledNet,
    places: list[int],
    used: list[int],
    shown: Collection[int],
    bounds: list[int | None],
) -> NetPart:
    """Extract a part; unbounded places are followed only up to a number of tokens."""
    free, edges = {}, {}
    for number, place in enumerate(places):
        initial, bound = int(net.initial[place]), bounds[place]
        if bound is None:
            gain = max((net.delta[transition].get(place, 0) for transition in used), default=0)
            free[place], edges[number] = gain + ASSUMED, initial + ASSUMED + 1
        else:
            free[place] = bound - initial
    silent = frozenset(number for number, transition in enumerate(used) if transition not in shown)
    return NetPart(cut_out(net, places, used, free), tuple(places), tuple(used), silent, edges)
