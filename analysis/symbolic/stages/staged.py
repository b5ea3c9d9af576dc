"""State spaces in stages: at first one component moves, then two of them, at last all.

Saturation makes fixed points from the bottom up, and the events that touch a high level come last. If all
components share a few variables, such as those of a mutual exclusion protocol, these must be at the top, as
the diagram of all markings is small then. But nearly all events touch them, so saturation of the top level
explores all components at once. The sets it meets say who was when before whom, and are far larger than the
set of all markings, in which this is forgotten.

Here the events belong to stages. Stage n has the events of component n. When those of a stage are added, the
set is closed under the events of each stage so far, the latest ones first, until none adds a marking. The set
after each stage is the state space of a smaller net of the same kind, and the sets between are hardly larger.

The closure under the events of one stage is a saturation run (see `kernels.saturation`), with a key of its
own in the cache.
"""

from __future__ import annotations

import math
from collections import defaultdict
from contextlib import suppress
from dataclasses import replace

import numpy as np

from dineros.analysis.answers.budget import ProgressCallback
from dineros.analysis.symbolic.counting import DiagramCounts
from dineros.analysis.symbolic.kernels import diagrams as store
from dineros.analysis.symbolic.kernels import saturation as machine
from dineros.analysis.symbolic.level_starts import first_start
from dineros.analysis.symbolic.levels import Encoding, LocalEvent, changes
from dineros.analysis.symbolic.relations import EventTables, Relations
from dineros.analysis.symbolic.saturation import FIRST_CLOSED_KEY, Diagram, DiagramMemoryError
from dineros.analysis.symbolic.stages.joining import (
    Joined,
    components,
    components_without_shared,
    joined,
)

#: Number of components that stages pay for, at least and at most.
FEWEST, MOST = 3, 64
#: Levels that may be left after components were joined, as a part of all levels: few shared variables, or as
#: many as components.
FEW_LEFT, SOME_LEFT = 0.5, 0.7
#: Work for the first stages, and work that all stages may need at most by the growth from one to the next, in
#: cache misses.
FIRST_WORK, MOST_WORK = 300_000, 40_000_000
#: Nodes above which garbage is collected, at least, and as a multiple of those that were left the last time.
#: Sooner costs cached results, later costs memory and slower access to it.
FIRST_GARBAGE, GARBAGE = 1_500_000, 4
#: Entries that the cache may have: most results are not asked for again once their stage is closed.
MOST_CACHE = 1 << 22
#: Earlier stages that take part in a closure once it is closed under all later ones.
ADDED_STAGES = 2
#: Stage from which on the growth is known.
KNOWN_GROWTH = 3


def staged(
    encoding: Encoding,
    memory: int,
    progress: ProgressCallback | None = None,
    allowed: tuple[int, int] = (MOST_WORK, MOST_WORK),
) -> tuple[Diagram | None, int]:
    """Compute the diagram of the reachable markings in stages, over joined levels.

    Parameters
    ----------
    progress
        Called regularly; an exception raised in it ends the work.
    allowed
        Work that all stages may need, in cache misses: if few levels are left after components were joined,
        and if more are left.

    Returns
    -------
    Diagram or None
        None if the levels do not fall into components that share a few of them, or it costs too much.
    int
        Work, in cache misses.
    """
    groups = components(encoding)
    if not _serve(groups, encoding):
        groups = components_without_shared(encoding, FEWEST) or groups
    most_work = allowed[len(groups) > FEW_LEFT * len(encoding.levels)]
    parts = joined(encoding, groups) if most_work and _serve(groups, encoding) else None
    if parts is None:
        return None, 0
    tried: list[_StagedRun] = []
    for order in _orders(parts):
        tried.append(_StagedRun(parts, order, memory, most_work, progress, KNOWN_GROWTH if tried else 0))
    begun = [run for run in tried if run.reaches(KNOWN_GROWTH)]
    work = sum(run.work for run in tried)
    tried.clear()  # their memory is free again
    if not begun:
        return None, work
    best = min(begun, key=lambda run: run.work)
    begun.clear()
    work -= best.work
    done = best.reaches(best.stages)
    return best.diagram if done else None, work + best.work


def _orders(parts: Joined) -> list[list[int]]:
    """Return orders to begin with, bottom first: components, and above them the others in both directions.

    Where processes pass shared variables one after the other, those that they pass first should be near them.
    """
    start = first_start(parts.encoding, EventTables.of(parts.encoding))
    inside = set(parts.components)
    lower = [level for level in start if level in inside]
    upper = [level for level in start if level not in inside]
    return [lower + upper, lower + upper[::-1]][: max(1, len(upper))]


def _serve(groups: list[tuple[int, ...]], encoding: Encoding) -> bool:
    """Return whether groups of levels may be worth stages."""
    several = sum(len(group) > 1 for group in groups)
    return FEWEST <= several <= MOST and len(groups) <= SOME_LEFT * len(encoding.levels)


def _events_of_stages(parts: Joined, order: list[int]) -> list[list[LocalEvent]]:
    """Return the events of each stage: those that change its component, and none of a later stage.

    An event that changes no component belongs to the last that it touches.
    """
    stage_of = {level: number for number, level in enumerate(order[: len(parts.components)])}
    stages: defaultdict[int, list[LocalEvent]] = defaultdict(list)
    for event in parts.encoding.events:
        moved = {stage_of[k] for k, table in event.tables.items() if k in stage_of and changes(table)}
        if not moved and not event.is_change:
            continue
        moved = moved or {stage_of[k] for k in event.tables if k in stage_of}
        stages[max(moved, default=0)].append(event)
    return [stages[number] for number in sorted(stages)]


def _log_at_end(work: int, growth: float, earlier: float, stage: int, stages: int) -> float:
    """Return the logarithm of the work of all stages by the work of the stages so far.

    It is exponential in the number of stages, or a power of it if the growth falls. This is too little for
    an exponential function, but less so after each stage.
    """
    if growth < earlier:
        return math.log(work) + math.log(growth) * math.log(stages / stage, stage / (stage - 1))
    return math.log(work) + math.log(growth) * (stages - stage)


class _StagedRun:
    """One diagram that is made in stages; it can stop after some of them and continue.

    Parameters
    ----------
    parts, order
        Joined levels and their order, bottom first.
    most_work
        Work that all stages may need, in cache misses.
    told
        Number of stages whose markings were reported before.
    """

    def __init__(
        self,
        parts: Joined,
        order: list[int],
        memory: int,
        most_work: int,
        progress: ProgressCallback | None,
        told: int,
    ) -> None:
        self.diagram = diagram = Diagram(parts.encoding, order, memory, most_cache=MOST_CACHE)
        self._most_work, self._progress, self._told = most_work, progress, told
        self._relations: list[Relations] = []
        for events in _events_of_stages(parts, order):
            tables = EventTables.of(replace(diagram.encoding, events=tuple(events)))
            self._relations.append(Relations.under(tables, diagram.position))
        self._left = 0
        self._room = FIRST_GARBAGE
        self._states = 0  # the set so far; 0: not made yet
        self._closed_stages, self._before, self._growth = 0, 0, math.inf

    @property
    def stages(self) -> int:
        """Number of stages."""
        return len(self._relations)

    @property
    def work(self) -> int:
        """Work so far, in cache misses."""
        return self.diagram.effort

    def reaches(self, stages: int) -> bool:
        """Run up to a number of stages; False if they cost too much. The last one completes the diagram."""
        try:
            self._states = self._states or self._initial()
            while self._closed_stages < min(stages, self.stages):
                if not self._passes(self._closed_stages):
                    return False
                self._closed_stages += 1
        except DiagramMemoryError:
            return False
        if self._closed_stages == self.stages:
            self.diagram.finish(self._states)
        return True

    def _initial(self) -> int:
        """Return the set with the initial marking only."""
        diagram, states = self.diagram, 1
        for level in range(1, diagram.top + 1):
            children = [0] * int(diagram.width[level])
            children[diagram.encoding.levels[diagram.order[level - 1]].initial] = states
            states = diagram.node(level, children)
        return states

    def _passes(self, last: int) -> bool:
        """Run one stage; False if it, or all stages by their growth, cost too much."""
        self._left = self._most_work if last >= KNOWN_GROWTH else min(FIRST_WORK, self._most_work)
        found = self._closed_under(self._states, last)
        if found is None:
            return False
        self._states, work = found, self.work
        if last >= self._told:
            self._report(found)
        if self._before:
            self._growth, earlier = work / self._before, self._growth
            at_end = _log_at_end(work, self._growth, earlier, last + 1, self.stages)
            if last + 1 >= KNOWN_GROWTH and at_end > math.log(self._most_work):
                return False
        self._before = work
        return True

    def _report(self, states: int) -> None:
        """Report how many markings there are at least."""
        if self._progress is not None:
            with suppress(DiagramMemoryError):
                found = DiagramCounts(self.diagram, states).vectors()
                self._progress(replace(self.diagram.progress, at_least=found))

    def _closed_under(self, states: int, last: int) -> int | None:
        """Return a set closed under the events of all stages up to one.

        Components of late stages are near the top, where closures cost the least. So the set is closed under
        the latest stages, in turn, before earlier ones take part.
        """
        idle: set[int] = set()  # the set is closed under these
        for first in [*range(last, 0, -ADDED_STAGES), 0]:
            stages = range(first, last + 1)
            while not idle.issuperset(stages):
                for stage in stages:
                    if stage not in idle:
                        found = self._closed(states, stage)
                        if found is None:
                            return None
                        idle = idle | {stage} if found == states else {stage}
                        states = found
        return states

    def _closed(self, states: int, stage: int) -> int | None:
        """Return a set closed under the events of one stage."""
        diagram, relations = self.diagram, self._relations[stage]
        top, control, frame = diagram.top, diagram.control, diagram.frame
        with_events = np.flatnonzero(np.diff(relations.event_start))
        if with_events.size == 0:
            return states
        if diagram.nodes > self._room:
            diagram.collect([states])
            self._room = max(FIRST_GARBAGE, GARBAGE * diagram.nodes)
        frame[:] = 0
        frame[top, machine.PHASE] = machine.CLOSING
        frame[top, machine.NODE] = states
        diagram.work[int(diagram.base[top]) :] = 0
        control[store.FIRED_KEY] = (stage + 1) * diagram.most_relations
        control[store.CLOSED_KEY] = FIRST_CLOSED_KEY - 1 - stage
        control[store.LOWEST] = int(with_events[0])
        control[store.STACK], control[store.HAVE] = top, 0
        if not diagram.drive(top, relations, self._progress, self._left):
            return None
        return int(control[store.RESULT])
