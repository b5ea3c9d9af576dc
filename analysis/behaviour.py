"""Liveness, reversibility and home markings, by the terminal parts of the reachability graph.

A part is terminal if it is strongly connected and nothing leaves it. A net is live iff every terminal part
fires every transition, reversible iff all markings are one part, and has home markings iff there is one
terminal part only: then they are its markings (Murata, Proc. IEEE 77(4), 1989, Sect. IV).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from dineros.analysis.counting import DiagramCounts
from dineros.analysis.symbolic import SymbolicStateSpace
from dineros.analysis.vector_sets import Scope, VectorSets

#: Terminal parts looked at one by one; with more of them, transitions are.
MOST_PARTS = 30


@dataclass(frozen=True)
class Behaviour:
    """What a net can do again and again.

    Attributes
    ----------
    reversible : bool
        Whether the initial marking can be reached from every reachable one.
    home_markings : int
        Number of markings that can be reached from every reachable one.
    not_live : tuple of int
        Transitions that some reachable marking shuts off for ever; none in a live net.
    """

    reversible: bool
    home_markings: int
    not_live: tuple[int, ...]


class TooMuchWorkError(Exception):
    """Deciding takes more work than was allowed."""


def behaviour(
    space: SymbolicStateSpace, progress: Callable[[Any], None] | None = None, work: int | None = None
) -> Behaviour:
    """Decide liveness, reversibility and home markings.

    Parameters
    ----------
    space : SymbolicStateSpace
        Complete.
    progress : callable, optional
        Told now and then how far it is.
    work : int, optional
        Cache misses of saturation at which to give up; no limit by default.

    Raises
    ------
    TooMuchWorkError
        If it needs more work.
    DiagramMemoryError
        If memory runs out.
    """
    limit = None if work is None else space.diagram.effort + work

    def tell(seen: Any) -> None:
        if limit is not None and space.diagram.effort > limit:
            raise TooMuchWorkError
        if progress is not None:
            progress(seen)

    sets = VectorSets(space.diagram, tell)
    everything, transitions = space.diagram.root, range(len(space.net.transitions))
    with Scope(space.diagram) as scope:
        dead = sets.without_boxes(everything, space.event_masks())
        scope.hold(dead)
        if dead:
            # A deadlock is a terminal part that fires nothing.
            others = sets.difference(everything, sets.closure(dead, everything, backwards=True))
            alone = others == 0 and DiagramCounts(space.diagram, dead).vectors() == 1
            return Behaviour(space.markings == 1, int(alone), tuple(transitions))
        live, parts, rest, home = set(transitions), 0, everything, 0
        while rest and parts < MOST_PARTS:
            scope.hold(rest)
            part, _ = sets.last_part(rest)
            scope.hold(rest, part)
            parts += 1
            live = {t for t in live if sets.without_boxes(part, space.event_masks(t)) != part}
            home = DiagramCounts(space.diagram, part).vectors()
            rest = sets.difference(rest, sets.closure(part, everything, backwards=True))
        if rest:
            live = {t for t in live if _always_possible(sets, space, t)}
        shut_off = tuple(t for t in transitions if t not in live)
        only = parts == 1 and rest == 0
        return Behaviour(only and home == space.markings, home if only else 0, shut_off)


def _always_possible(sets: VectorSets, space: SymbolicStateSpace, transition: int) -> bool:
    """Whether from every marking one that enables the transition can be reached."""
    everything = space.diagram.root
    with Scope(space.diagram) as scope:
        disabled = sets.without_boxes(everything, space.event_masks(transition))
        scope.hold(disabled)
        enabled = sets.difference(everything, disabled)
        return sets.closure(enabled, everything, backwards=True) == everything
