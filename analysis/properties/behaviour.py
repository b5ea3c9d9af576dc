"""Liveness, reversibility and home markings, by the terminal components of the reachability graph.

A component is terminal if it is strongly connected and no arc leaves it. A net is live iff each terminal
component fires every transition, reversible iff all markings form one component, and has home markings iff
there is exactly one terminal component, whose markings they are (Murata, Proc. IEEE 77(4), 1989, Sect. IV).
Steps within a terminal component are firings of repeatable transitions only, which leaves few markings to
examine in many nets.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from dineros.analysis.answers.budget import UNLIMITED, Budget, Progress
from dineros.analysis.nets.repetition import repeatable_transitions
from dineros.analysis.symbolic.counting import DiagramCounts
from dineros.analysis.symbolic.engine import SymbolicStateSpace
from dineros.analysis.symbolic.vector_sets import Scope, VectorSets

#: Number of terminal components examined one by one; with more, transitions are examined one by one.
MOST_PARTS = 30


@dataclass(frozen=True)
class Behaviour:
    """Liveness, reversibility and home markings of a net.

    Attributes
    ----------
    reversible : bool
        Whether the initial marking can be reached from every reachable one.
    home_markings : int
        Number of markings that can be reached from every reachable one.
    not_live : tuple of int
        Transitions that can become permanently disabled; empty in a live net.
    """

    reversible: bool
    home_markings: int
    not_live: tuple[int, ...]


class TooMuchWorkError(Exception):
    """The decision needs more work than allowed."""


def behaviour(space: SymbolicStateSpace, budget: Budget = UNLIMITED, work: int | None = None) -> Behaviour:
    """Decide liveness, reversibility and home markings.

    Parameters
    ----------
    budget : Budget, optional
        Limit of its time; the memory is that of the state space.
    work : int, optional
        Cache misses of saturation after which it gives up; no limit by default.

    Raises
    ------
    TooMuchWorkError
        It needs more work.
    DiagramMemoryError
        Memory is exhausted.
    BudgetExceededError
        The time is over.
    """
    limit = None if work is None else space.diagram.effort + work

    def check_work() -> None:
        if limit is not None and space.diagram.effort > limit:
            raise TooMuchWorkError

    def tell(progress: Progress) -> None:
        check_work()
        if budget.progress is not None:
            budget.progress(progress)

    transitions = range(len(space.net.transitions))
    again = repeatable_transitions(space.net)
    sets = VectorSets(space.diagram, replace(budget, progress=tell)).restricted(again)
    with Scope(space.diagram) as scope:
        last = _settled(sets, space, again)
        scope.hold(last)
        if last == space.diagram.root:
            start = sets.single([level.initial for level in space.encoding.levels])
            scope.hold(last, start)
            back = sets.closure(start, last, backwards=True)
            check_work()
            if back == last:
                # All markings are one component: a transition is live if it can fire at all.
                never = tuple(t for t in transitions if not space.counts.in_boxes(space.event_masks(t)))
                return Behaviour(True, space.markings, never)
            # From the other markings, the initial marking cannot be reached, so no step leaves this set;
            # since all
            # markings are reachable from it, it contains no terminal component.
            scope.hold(last, back)
            last = sets.difference(last, back)
            scope.hold(last)
            check_work()
        dead = sets.without_boxes(last, space.event_masks())
        scope.hold(last, dead)
        check_work()
        if dead:
            # A deadlock is a terminal component without firings.
            others = sets.difference(last, sets.closure(dead, last, backwards=True))
            alone = others == 0 and DiagramCounts(space.diagram, dead).vectors() == 1
            return Behaviour(space.markings == 1, int(alone), tuple(transitions))
        live, parts, rest, home = set(transitions), 0, last, 0
        while rest and parts < MOST_PARTS:
            scope.hold(last, rest)
            part, _ = sets.last_part(rest)
            scope.hold(last, rest, part)
            parts += 1
            live = {t for t in live if sets.without_boxes(part, space.event_masks(t)) != part}
            home = DiagramCounts(space.diagram, part).vectors()
            rest = sets.difference(rest, sets.closure(part, last, backwards=True))
            check_work()
        if rest:
            live = {t for t in live if _always_possible(sets, space, last, t)}
        shut_off = tuple(t for t in transitions if t not in live)
        only = parts == 1 and rest == 0
        return Behaviour(only and home == space.markings, home if only else 0, shut_off)


def _settled(sets: VectorSets, space: SymbolicStateSpace, again: frozenset[int]) -> int:
    """Return the markings after which only repeatable transitions fire, including all terminal components.

    Every run reaches this set, and no run leaves it.
    """
    everything = space.diagram.root
    once = [box for t in range(len(space.net.transitions)) if t not in again for box in space.event_masks(t)]
    with Scope(space.diagram) as scope:
        calm = sets.without_boxes(everything, once)
        scope.hold(calm)
        others = sets.difference(everything, calm)
        scope.hold(calm, others)
        return sets.difference(calm, sets.closure(others, everything, backwards=True))


def _always_possible(sets: VectorSets, space: SymbolicStateSpace, last: int, transition: int) -> bool:
    """Whether from each marking of a closed set, one that enables the transition is reachable."""
    with Scope(space.diagram) as scope:
        disabled = sets.without_boxes(last, space.event_masks(transition))
        scope.hold(disabled)
        enabled = sets.difference(last, disabled)
        return sets.closure(enabled, last, backwards=True) == last
