"""The independent check: plain breadth-first search, backward search and the tree of Karp and Miller.

Slow and short, so that each is obviously right. Nothing of the analysis is used but the arcs of the net.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf

from dineros.analysis.nets.compiled import CompiledNet

OmegaMarking = tuple[float, ...]


@dataclass
class Seen:
    """What a breadth-first search saw.

    Attributes
    ----------
    markings : set of tuple of int
        The markings, as many as were allowed.
    enabled : set of int
        Transitions that some of them enable.
    has_deadlock : bool
        Whether some of them enables nothing.
    is_complete : bool
        Whether these are all reachable markings.
    """

    markings: set[tuple[int, ...]] = field(default_factory=set)
    enabled: set[int] = field(default_factory=set)
    has_deadlock: bool = False
    is_complete: bool = False


def plain_search(net: CompiledNet, most: int = 100_000) -> Seen:
    """Search breadth first until so many markings are seen."""
    transitions = [(net.pre.row(t), net.inhibitor.row(t), net.delta[t]) for t in range(len(net.transitions))]
    start = tuple(net.initial.tolist())
    seen = Seen({start})
    frontier = [start]
    for marking in frontier:
        enabled = [
            t
            for t, (needs, inhibitors, _) in enumerate(transitions)
            if all(marking[p] >= w for p, w in needs) and all(marking[p] < w for p, w in inhibitors)
        ]
        seen.enabled.update(enabled)
        seen.has_deadlock |= not enabled
        for t in enabled:
            change = transitions[t][2]
            after = tuple(n + change.get(p, 0) for p, n in enumerate(marking))
            if after not in seen.markings:
                seen.markings.add(after)
                frontier.append(after)
        if len(seen.markings) > most:
            return seen
    seen.is_complete = True
    return seen


def covers(large: OmegaMarking, small: OmegaMarking) -> bool:
    """Whether one marking has at least the tokens of another, in each place."""
    return all(one >= other for one, other in zip(large, small, strict=True))


def plain_karp_miller(net: CompiledNet, most: int = 3_000) -> set[OmegaMarking] | None:
    """Return the maximal markings of the tree without pruning, or None if it is too large.

    Inhibitor arcs are left out: with them, there is no such tree.
    """
    seen: set[OmegaMarking] = set()
    todo: list[tuple[OmegaMarking, ...]] = [(tuple(float(n) for n in net.initial.tolist()),)]
    made = 0
    while todo:
        branch = todo.pop()
        here = branch[-1]
        if here in branch[:-1]:
            continue
        seen.add(here)
        for t in range(len(net.transitions)):
            if all(here[p] >= w for p, w in net.pre.row(t)):
                new = [n + net.delta[t].get(p, 0) for p, n in enumerate(here)]
                for old in branch:
                    if covers(tuple(new), old):
                        new = [inf if n > o else n for n, o in zip(new, old, strict=True)]
                todo.append((*branch, tuple(new)))
                made += 1
        if made > most:
            return None
    return {m for m in seen if not any(m != other and covers(other, m) for other in seen)}


def can_fire_by_karp_miller(net: CompiledNet, most: int = 3_000) -> set[int] | None:
    """Return the transitions that can fire where inhibitor arcs are left out: all others are dead."""
    maximal = plain_karp_miller(net, most)
    if maximal is None:
        return None
    return {
        t
        for t in range(len(net.transitions))
        if any(all(marking[p] >= w for p, w in net.pre.row(t)) for marking in maximal)
    }


def plain_backward(net: CompiledNet, target: tuple[int, ...], most: int = 3_000) -> bool | None:
    """Whether a target can be covered where inhibitor arcs are left out; None if that takes too much."""
    initial = tuple(net.initial.tolist())
    smallest: list[tuple[int, ...]] = []
    todo = [target]
    made = 0
    while todo:
        marking = todo.pop(0)
        if any(covers(marking, small) for small in smallest):
            continue
        if covers(initial, marking):
            return True
        smallest = [marking, *(other for other in smallest if not covers(other, marking))]
        for t in range(len(net.transitions)):
            needs, puts = dict(net.pre.row(t)), dict(net.post.row(t))
            before = [needs.get(p, 0) + max(0, n - puts.get(p, 0)) for p, n in enumerate(marking)]
            todo.append(tuple(before))
            made += 1
        if made > most:
            return None
    return False
