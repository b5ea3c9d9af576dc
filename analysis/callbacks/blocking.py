"""Callbacks that can wait forever while others continue, and the circles in which they wait.

A callback can wait forever where a marking can be reached from which none can be that has ended it. From
there the net can only go into a part that it never leaves again: there the circle is closed, if it is one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.callbacks.circles import Circle, Waiter
from dineros.analysis.callbacks.waiting import Waiting
from dineros.analysis.logic.ctl.symbolic_sets import SymbolicSets
from dineros.analysis.symbolic.engine import SymbolicStateSpace

MOST_PARTS = 24
"""Limit of the parts of the state space that are examined for each callback; others are not distinguished."""


@dataclass(frozen=True)
class Blocked:
    """A callback that can wait forever."""

    callback: Waiter
    """The callback."""
    circle: Circle | None
    """Those that wait for each other then, the callback among them or waiting for them; None if a token is
    missing that no callback holds or makes.
    """
    trace: tuple[int, ...]
    """Transitions that lead there."""


def blocked(space: SymbolicStateSpace, waiting: Waiting, budget: Budget = UNLIMITED) -> Iterator[Blocked]:
    """Yield the callbacks that can wait forever: each circle once, and each other callback once.

    A callback that waits for a circle which it is not in is not named, only the circle.

    `space` must be complete.

    Raises
    ------
    DiagramMemoryError
        If memory runs out.
    BudgetExceededError
        If time runs out.
    """
    sets = SymbolicSets(space, budget=budget)
    known: set[Circle] = set()
    for callback in waiting.callbacks.values():
        doomed = never_without(sets, callback.places)
        is_alone = bool(doomed)
        for marking, trace in last_parts(sets, doomed):
            circle = waiting.circle(marking, callback.waiter)
            is_alone &= circle is None
            if circle is not None and circle not in known:
                known.add(circle)
                yield Blocked(callback.waiter, circle, trace)
        if is_alone:
            marking, trace = next(last_parts(sets, doomed))
            yield Blocked(callback.waiter, None, trace)


def never_without(sets: SymbolicSets, places: Iterable[int]) -> int:
    """Return the markings from which at least one of some places always stays marked."""
    return sets.complement(sets.some_until(sets.everything, without(sets, places)))


def without(sets: SymbolicSets, places: Iterable[int]) -> int:
    """Return the markings in which none of some places is marked."""
    weights, constant = sets.space.encoding.weights_of(dict.fromkeys(places, 1))
    return sets.intersection(sets.everything, sets.sets.sums(weights, None, -constant))


def last_parts(sets: SymbolicSets, states: int) -> Iterator[tuple[list[int], tuple[int, ...]]]:
    """Yield a marking of each part that a set ends in, a set that is never left, and a way there."""
    pinned, vectors = sets.space.diagram.pinned, sets.sets
    for _ in range(MOST_PARTS):
        if states == 0:
            return
        part, _ = vectors.last_part(states)
        pinned.append(part)
        yield sets.space.marking_of(vectors.some_vector(part)), sets.way_to(part)
        before = vectors.closure(part, states, backwards=True)
        pinned.append(before)
        states = vectors.difference(states, before)
        pinned.append(states)
