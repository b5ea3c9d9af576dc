"""Time Petri nets by their meaning: a graph of clock regions, plain and slow, independent of the product.

A state is a marking and, for each enabled transition, for how long it has been enabled. Two states of a
marking belong to one region if their clocks have the same whole parts, the same clocks with no fraction, and
the same order of fractions; a clock beyond all bounds of its transition counts as such (Alur and Dill, 1994).
From a region time passes to the next one, or a transition fires; the graph is finite if the markings are.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

Marking: TypeAlias = tuple[int, ...]
Clocks: TypeAlias = tuple[tuple[int, int, int], ...]
"""By enabled transition: its number, the whole part of its clock (-1: beyond all bounds), its rank."""
State: TypeAlias = tuple[Marking, Clocks]


@dataclass(frozen=True)
class TimedTransition:
    """A transition; arcs are place number -> weight, bounds are whole numbers."""

    name: str
    take: dict[int, int]
    put: dict[int, int]
    read: dict[int, int]
    inhibitor: dict[int, int]
    earliest: int = 0
    latest: int | None = None
    is_open_below: bool = False
    is_open_above: bool = False
    above: frozenset[int] = frozenset()
    """Numbers of the transitions with priority over it, through others too."""

    @property
    def beyond(self) -> int:
        """A whole number: a clock above it can be told from no other such clock."""
        return self.earliest if self.latest is None else self.latest

    def is_enabled(self, marking: Marking) -> bool:
        """Whether it has its tokens."""
        needs = dict(self.take)
        for place, weight in self.read.items():
            needs[place] = needs.get(place, 0) + weight
        return all(marking[p] >= w for p, w in needs.items()) and all(
            marking[p] < w for p, w in self.inhibitor.items()
        )

    def may_fire(self, whole: int, rank: int) -> bool:
        """Whether a clock has reached the interval; it never is past it."""
        if whole == -1:
            return True
        if self.is_open_below:
            return whole > self.earliest or (whole == self.earliest and rank > 0)
        return whole >= self.earliest

    def is_within(self, whole: int, rank: int) -> bool:
        """Whether a clock has not passed the latest bound."""
        if self.latest is None:
            return True
        if whole == -1:
            return False
        if self.is_open_above:
            return whole < self.latest
        return whole < self.latest or (whole == self.latest and rank == 0)


class RegionGraph:
    """All regions of a net, and what follows them.

    Parameters
    ----------
    initial
        The first marking.
    transitions
        The transitions.
    most
        Regions at which it gives up with `OverflowError`.

    Attributes
    ----------
    waits : dict
        By region: the next one in time, where time may pass.
    fires : dict
        By region: what can fire there, and the region after it.
    """

    def __init__(self, initial: Marking, transitions: list[TimedTransition], most: int = 20_000) -> None:
        self.transitions = transitions
        self.start: State = (initial, tuple((t, 0, 0) for t in self._enabled(initial)))
        self.waits: dict[State, State] = {}
        self.fires: dict[State, list[tuple[int, State]]] = {}
        todo = deque([self.start])
        known = {self.start}
        while todo:
            state = todo.popleft()
            self.fires[state] = list(self._fired(state))
            later = self._later(state)
            if later is not None:
                self.waits[state] = later
            for after in [*([later] if later else []), *(after for _, after in self.fires[state])]:
                if after not in known:
                    if len(known) >= most:
                        raise OverflowError(f"more than {most} regions")
                    known.add(after)
                    todo.append(after)

    @property
    def markings(self) -> set[Marking]:
        """The reachable markings."""
        return {marking for marking, _ in self.fires}

    def _enabled(self, marking: Marking) -> list[int]:
        return [t for t, one in enumerate(self.transitions) if one.is_enabled(marking)]

    def _fired(self, state: State) -> Iterator[tuple[int, State]]:
        marking, clocks = state
        ready = {t for t, whole, rank in clocks if self.transitions[t].may_fire(whole, rank)}
        for t in sorted(ready):
            one = self.transitions[t]
            if one.above & ready:
                continue
            between = list(marking)
            for place, weight in one.take.items():
                between[place] -= weight
            after = list(between)
            for place, weight in one.put.items():
                after[place] += weight
            kept = {u: (whole, rank) for u, whole, rank in clocks}
            made = []
            for u in self._enabled(tuple(after)):
                goes_on = u != t and u in kept and self.transitions[u].is_enabled(tuple(between))
                made.append((u, *(kept[u] if goes_on else (0, 0))))
            yield t, (tuple(after), _ranked(made))

    def _later(self, state: State) -> State | None:
        """Let time pass into the next region; None where a latest bound forbids it, or nothing changes."""
        marking, clocks = state
        moving = [(t, whole, rank) for t, whole, rank in clocks if whole != -1]
        if not moving:
            return None
        ranks = max(rank for _, _, rank in moving)
        made = []
        has_whole = any(rank == 0 for _, _, rank in moving)
        for t, whole, rank in clocks:
            if whole == -1:
                made.append((t, -1, 0))
            elif has_whole:
                beyond = rank == 0 and whole >= self.transitions[t].beyond
                made.append((t, -1, 0) if beyond else (t, whole, rank + 1))
            elif rank == ranks:
                made.append((t, whole + 1, 0))
            else:
                made.append((t, whole, rank))
        if not all(self.transitions[t].is_within(whole, rank) for t, whole, rank in made):
            return None
        return marking, _ranked(made)


def _ranked(clocks: list[tuple[int, int, int]]) -> Clocks:
    """Number the fractions without gaps; 0 is not a fraction."""
    ranks = sorted({rank for _, whole, rank in clocks if whole != -1 and rank > 0})
    number = {rank: position for position, rank in enumerate(ranks, 1)} | {0: 0}
    return tuple((t, whole, number[rank] if whole != -1 else 0) for t, whole, rank in clocks)
