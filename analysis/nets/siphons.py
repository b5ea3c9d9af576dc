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
    found = _Shrinking(net, places)
    found.remove([p for t, number in found.puts.items() if number == 0 for p, _ in net.pre.row(t)])
    return tuple(sorted(found.places))


def smaller_trap(net: CompiledNet, trap: Places) -> Places:
    """Return a marked trap within a marked trap, of which no place can be left out."""
    found = _Shrinking(net, trap)
    marked = [place for place in trap if net.initial[place]]
    for place in trap:
        removed = found.remove([place])
        if found.places.isdisjoint(marked):
            found.restore(removed)
    return tuple(sorted(found.places))


class _Shrinking:
    """Places of which some are removed, and then those that can be in no trap within the rest.

    Attributes
    ----------
    places : set of int
        The places left.
    puts : mapping
        Transition that takes tokens from the places given -> number of the places left on which it puts some.
    """

    def __init__(self, net: CompiledNet, places: Iterable[int]) -> None:
        self._net, self._putting = net, net.once(_putting)
        self.places = set(places)
        takers = {t for place in self.places for t in net.consumers[place]}
        self.puts = {t: sum(p in self.places for p, _ in net.post.row(t)) for t in takers}

    def remove(self, todo: list[int]) -> list[int]:
        """Remove places, and all from which a transition takes that puts tokens on none; return them."""
        removed = []
        while todo:
            place = todo.pop()
            if place not in self.places:
                continue
            self.places.remove(place)
            removed.append(place)
            for t in self._putting[place]:
                if t in self.puts:
                    self.puts[t] -= 1
                    if self.puts[t] == 0:
                        todo += [p for p, _ in self._net.pre.row(t)]
        return removed

    def restore(self, removed: Iterable[int]) -> None:
        """Add places again that were removed last."""
        for place in removed:
            self.places.add(place)
            for t in self._putting[place]:
                if t in self.puts:
                    self.puts[t] += 1


def _putting(net: CompiledNet) -> list[list[int]]:
    """For each place, the transitions with an output arc to it."""
    lists: list[list[int]] = [[] for _ in net.places]
    for t in range(len(net.transitions)):
        for place, _ in net.post.row(t):
            lists[place].append(t)
    return lists


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
