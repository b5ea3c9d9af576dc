"""What a time Petri net can do: which transitions fire, where it ends, and what takes no time.

Classes are compared by inclusion, so only the largest ones are kept. They have the markings and firings of
all classes; a class in which nothing can fire holds no state in which something can.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from dineros.analysis.answers.budget import RAN_OUT, Budget
from dineros.analysis.logic.graphs.predicates import MarkingMatrix, enabled
from dineros.analysis.nets.compiled import CompiledNet, Int64Array
from dineros.analysis.nets.coverability import Pumping
from dineros.analysis.timed.classes import Kind
from dineros.analysis.timed.growth import growing_loop
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.search import ClassSearch

FIRST_LOOK = 500
"""Classes after which it is asked whether tokens grow forever, and again with four times as many."""

LONGEST_WAY = 20_000
"""Firings of a sequence whose times are computed."""

SEARCH_REASONS = {
    **RAN_OUT,
    "states": "there are too many state classes",
    "tokens": "a place holds too many tokens",
}
"""Why a search for state classes did not end, by its reason, in words."""

Trace = tuple[int, ...]


@dataclass(frozen=True)
class Explored:
    """What was found.

    Attributes
    ----------
    search : ClassSearch
        Ended.
    growth : Pumping or None
        A loop by which tokens grow forever; then the search ended early.
    """

    net: TimedNet
    search: ClassSearch
    growth: Pumping | None = None

    @property
    def kind(self) -> Kind:
        """Which classes were built."""
        return self.search.kind

    @property
    def is_complete(self) -> bool:
        """Whether all markings and firings are known."""
        return self.search.is_done

    @property
    def reason(self) -> str:
        """Why not all is known; empty if it is."""
        if self.is_complete:
            return ""
        reason = self.search.reason or "tokens grow without bound, so the search has no end"
        return SEARCH_REASONS.get(reason, reason)

    @cached_property
    def markings(self) -> Int64Array:
        """The markings found, one a row, places in the order of the net."""
        return self.search.markings()

    @cached_property
    def ways(self) -> dict[int, Trace]:
        """By transition that was seen to fire: a sequence that ends with it, with as few firings as found."""
        return {
            transition: (*self.search.trace(number), transition)
            for transition, number in self.search.first_sources().items()
        }

    @cached_property
    def ends(self) -> list[tuple[int, Trace]]:
        """The markings in which nothing can fire any more, by row, with a way there; if all are known."""
        dead = np.flatnonzero(self.search.dead()) if self.is_complete else np.zeros(0, dtype=np.int64)
        first: dict[int, int] = {}
        for number in dead.tolist():
            first.setdefault(int(self.search.marking_of[number]), number)
        return [(row, self.search.trace(number)) for row, number in first.items()]

    def way_to(self, row: int) -> Trace:
        """Return a way to a marking that was found."""
        return self.search.trace(int(np.flatnonzero(self.search.marking_of == row)[0]))

    def enabled_at(self, transition: int) -> Int64Array:
        """Return the rows of the markings with the tokens for a transition."""
        return np.flatnonzero(enabled(MarkingMatrix(self.net.untimed, self.markings), transition))


def explore_timed(net: TimedNet, budget: Budget, begun: Explored | None = None) -> Explored:
    """Build the largest state classes of a net, or find out that tokens grow forever.

    The strong classes (E) are built if the net has priorities, else the linear ones (M). A complete search is
    kept with the net, for all further questions.

    Parameters
    ----------
    begun : Explored, optional
        What was found of the net when time ran out: the search continues there.
    """
    last = net.untimed.once(_Complete)
    if last.explored is not None and last.explored.net is net:
        return last.explored
    kind: Kind = "E" if net.has_priorities else "M"
    if begun is None:
        search = ClassSearch(net, kind, budget, keeps_parents=True, is_breadth_first=True)
    elif begun.growth is not None or not begun.search.allow(budget):
        return begun
    else:
        search = begun.search
    found: list[Pumping] = []
    next_look = FIRST_LOOK
    while next_look < search.classes:
        next_look *= 4

    def grows() -> bool:
        nonlocal next_look
        while not found and (search.classes >= next_look or search.reason == "tokens"):
            pumping = growing_loop(net, search.trace(_fullest(search, next_look)))
            found.extend([pumping] if pumping is not None else [])
            if search.reason == "tokens":
                break
            next_look *= 4
        return bool(found)

    search.run(grows)
    explored = Explored(net, search, found[0] if found else None)
    if explored.is_complete:
        last.explored = explored
    return explored


class _Complete:
    """The complete search of a net, once there is one."""

    def __init__(self, _: CompiledNet) -> None:
        self.explored: Explored | None = None


def fire_far_away(net: TimedNet, known: Iterable[int], budget: Budget) -> tuple[dict[int, Trace], set[int]]:
    """Find transitions that fire only far from the initial class: search depth first.

    Parameters
    ----------
    known
        Transitions that are known to fire.
    budget
        Limits; the search ends when they are reached, or when all transitions have fired.

    Returns
    -------
    ways : dict of int to Trace
        By transition a sequence that ends with it, if that has at most `LONGEST_WAY` firings.
    others : set of int
        Transitions that fire after longer ones.
    """
    search = ClassSearch(net, "E" if net.has_priorities else "M", budget, keeps_parents=True)
    wanted = set(range(len(net.untimed.transitions))) - set(known)
    next_look = FIRST_LOOK

    def is_met() -> bool:
        nonlocal next_look
        if search.classes < next_look:
            return False
        next_look = 2 * search.classes
        return wanted <= search.first_sources().keys()

    search.run(is_met)
    sources = {t: number for t, number in search.first_sources().items() if t in wanted}
    ways = {t: (*search.trace(number), t) for t, number in sources.items()}
    short = {t: way for t, way in ways.items() if len(way) <= LONGEST_WAY}
    return short, ways.keys() - short.keys()


def _fullest(search: ClassSearch, among: int) -> int:
    """Return a class with the most tokens, among a number of classes that were found first."""
    chosen = search.marking_of[:among]
    sums = search.markings(0, int(chosen.max()) + 1).sum(axis=1)
    return int(sums[chosen].argmax())
