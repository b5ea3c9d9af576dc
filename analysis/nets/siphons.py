"""The largest trap within places, and the largest siphon without tokens.

A *siphon* is a set of places in which every transition that puts tokens also takes some: once empty, it stays
empty. A *trap* is a set of places in which every transition that takes tokens also puts some: once marked, it
stays marked. Inhibitor arcs only keep transitions from firing, so both facts hold with them.

References
----------
T. Murata, *Petri nets: properties, analysis and applications*, Proc. IEEE 77(4), 1989, section VI.
"""

from __future__ import annotations

from collections.abc import Iterable

from dineros.analysis.nets.compiled import CompiledNet

Places = tuple[int, ...]


def largest_trap(net: CompiledNet, places: Iterable[int]) -> Places:
    """Return the union of all traps within a set of places (which is a trap itself; it can be empty)."""
    trap = set(places)
    takers: dict[int, list[int]] = {place: list(net.consumers[place]) for place in trap}
    todo = sorted(trap)
    while todo:
        place = todo.pop()
        if place not in trap:
            continue
        if any(all(p not in trap for p, _ in net.post.row(t)) for t in takers[place]):
            trap.discard(place)
            # A transition that puts tokens on this place may now put none on the others.
            todo = sorted(trap)
    return tuple(sorted(trap))


def unmarked_siphon(net: CompiledNet) -> Places:
    """Return the largest siphon without tokens: the places that never get tokens according to the arcs."""
    missing = [len(net.pre.row(t)) for t in range(len(net.transitions))]
    marked: set[int] = set()
    todo = [place for place, tokens in enumerate(net.initial) if tokens]
    todo += [place for t, number in enumerate(missing) if number == 0 for place, _ in net.post.row(t)]
    while todo:
        place = todo.pop()
        if place in marked:
            continue
        marked.add(place)
        for t in net.consumers[place]:
            missing[t] -= 1
            if missing[t] == 0:
                todo += [other for other, _ in net.post.row(t)]
    return tuple(place for place in range(len(net.places)) if place not in marked)
