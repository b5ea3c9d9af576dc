"""Minimal siphons and traps, and Commoner's condition on them.

A *siphon* is a set of places in which every transition that puts tokens also takes some: once empty, it stays
empty. A *trap* is a set of places in which every transition that takes tokens also puts some: once marked, it
stays marked. Inhibitor arcs only keep transitions from firing, so both facts hold with them.

References
----------
T. Murata, *Petri nets: properties, analysis and applications*, Proc. IEEE 77(4), 1989, section VI. F.
Commoner, *Deadlocks in Petri nets*, Applied Data Research 1972. O. Oanea, H. Wimmel, K. Wolf, *New algorithms
for deciding the siphon-trap property*, Petri Nets 2010, LNCS 6128 (by satisfiability).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal

from dineros.analysis.nets.compiled import ArcTable, CompiledNet

Places = tuple[int, ...]


@dataclass(frozen=True)
class Family:
    """Minimal siphons or traps of a net.

    Attributes
    ----------
    members : tuple of tuples of int
        The place indices of each, in ascending order.
    is_complete : bool
        Whether all of them were found.
    """

    members: tuple[Places, ...]
    is_complete: bool


@dataclass(frozen=True)
class Commoner:
    """Whether every minimal siphon that can disable a transition contains an initially marked trap.

    Attributes
    ----------
    holds : bool or None
        None: a limit was exceeded before a counterexample was found.
    siphon : tuple of int, optional
        A minimal siphon without such a trap.
    conclusion : str, optional
        The conclusion for the net: "deadlock-free", "live" or "not live"; None: there is none.
    """

    holds: bool | None
    siphon: Places | None = None
    conclusion: Literal["deadlock-free", "live", "not live"] | None = None


def minimal_siphons(net: CompiledNet, limit: int = 1_000) -> Family:
    """Non-empty siphons that contain no other one.

    Parameters
    ----------
    net
        The net.
    limit
        Maximum number of siphons.
    """
    return _minimal(len(net.places), net.post, net.pre, limit)


def minimal_traps(net: CompiledNet, limit: int = 1_000) -> Family:
    """Non-empty traps that contain no other one; parameters as for `minimal_siphons`."""
    return _minimal(len(net.places), net.pre, net.post, limit)


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


def commoner(net: CompiledNet, limit: int = 1_000) -> Commoner:
    """Check Commoner's condition: every minimal siphon contains a trap that is initially marked.

    In a net whose arcs all have weight 1, without inhibitor arcs and with a transition at all, the condition
    excludes deadlocks (in a deadlock, the empty places are a siphon). If the net is also free-choice, it
    decides liveness. Elsewhere nothing is concluded. Siphons that no transition takes tokens from (a place
    without consumers) disable nothing and do not count.

    Parameters
    ----------
    net
        The net.
    limit
        Maximum number of minimal siphons examined.
    """
    plain = bool(len(net.transitions)) and not net.inhibitor.place.size
    plain = plain and bool((net.pre.weight == 1).all()) and bool((net.post.weight == 1).all())
    free_choice = plain and _is_free_choice(net)
    for seen, siphon in enumerate(_enumerate(len(net.places), net.post, net.pre)):
        if seen == limit:
            return Commoner(None)
        disables = any(net.consumers[place] for place in siphon)
        if disables and not any(net.initial[place] for place in largest_trap(net, siphon)):
            return Commoner(False, siphon, "not live" if free_choice else None)
    if free_choice:
        return Commoner(True, conclusion="live")
    return Commoner(True, conclusion="deadlock-free" if plain else None)


def _is_free_choice(net: CompiledNet) -> bool:
    """Whether transitions that share an input place have the same input places (extended free choice)."""
    inputs = [frozenset(p for p, _ in net.pre.row(t)) for t in range(len(net.transitions))]
    return all(len({inputs[t] for t in takers}) <= 1 for takers in net.consumers)


def _minimal(places: int, arcs: ArcTable, answers: ArcTable, limit: int) -> Family:
    members: list[Places] = []
    for member in _enumerate(places, arcs, answers):
        if len(members) == limit:
            return Family(tuple(sorted(members)), False)
        members.append(member)
    return Family(tuple(sorted(members)), True)


def _enumerate(places: int, arcs: ArcTable, answers: ArcTable) -> Iterator[Places]:
    """Yield minimal non-empty sets that have, for each transition with arcs into them, an answering arc.

    Variable p + 1 means that place p is in the set; softly, each place should not be in it: a minimal set is
    a minimal correction set of these soft constraints.
    """
    from pysat.examples.mcsls import MCSls
    from pysat.formula import WCNF

    if not places:
        return
    formula = WCNF()
    formula.append(list(range(1, places + 1)))
    for t in range(len(arcs.pointer) - 1):
        answering = [p + 1 for p, _ in answers.row(t)]
        for place, _ in arcs.row(t):
            if place + 1 not in answering:
                formula.append([-(place + 1), *answering])
    for place in range(places):
        formula.append([-(place + 1)], weight=1)
    with MCSls(formula, solver_name="g4") as search:
        while found := search.compute():
            search.block(found)
            yield tuple(sorted(number - 1 for number in found))
