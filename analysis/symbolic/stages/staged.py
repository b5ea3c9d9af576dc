"""State spaces in stages: at first one component moves, then two of them, at last all.

Saturation makes fixed points from the bottom up, and the events that touch a high level come last. If all
components share a few variables, such as those of a mutual exclusion protocol, these must be at the top, as
the diagram of all markings is small then. But nearly all events touch them, so saturation of the top level
explores all components at once. The intermediate sets record the order of the processes, so they are far
larger than the set of all markings.

Here the events belong to stages. Stage n has the events of component n. When those of a stage are added, the
set is closed under the events of each stage so far, the latest ones first, until none adds a marking. The set
after each stage is the state space of a smaller net of the same kind, and the sets between are hardly larger.

The closure under the events of one stage is a saturation run (see `kernels.saturation`), with a key of its
own in the cache.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from dineros.analysis.answers.budget import ProgressCallback
from dineros.analysis.symbolic.counting import DiagramCounts
from dineros.analysis.symbolic.kernels import diagrams as store
from dineros.analysis.symbolic.kernels import saturation as machine
from dineros.analysis.symbolic.level_starts import first_start
from dineros.analysis.symbolic.levels import Encoding, LocalEvent, changes
from dineros.analysis.symbolic.relations import EventTables, Relations
from dineros.analysis.symbolic.saturation import FIRST_CLOSED_KEY, Diagram, DiagramMemoryError
from dineros.analysis.symbolic.stages.contraction import contracted
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
#: Orders after which trials end if one of these is expected to need at most this work for all stages.
FIRST_ORDERS, EASY_WORK = 2, 1_000_000
#: Orders that are tried with one stage more, at most; part of the expected work of all stages for that.
MOST_KEPT, TRIALS_OF_STAGE = 3, 1 / 4
#: Part of the work allowed for all stages that trials may take, and work by that of the best trial up to
#: which a trial goes on.
TRIAL_PART, WORTH_TRYING = 1 / 4, 3
#: Bytes of a trial.
TRIAL_MEMORY = 1 << 28


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
    contraction = contracted(parts.encoding)
    if contraction is not None:
        parts = replace(parts, encoding=contraction.encoding)
    stages = _Stages(parts)
    order, work = _best_order(stages, memory, most_work, progress)
    if order is None:
        return None, work
    run = _StagedRun(stages, order, memory, progress, contraction.weights() if contraction else None)
    if not run.reaches_end(most_work):
        return None, work + run.work
    work += run.work
    if contraction is None:
        return run.diagram, work
    try:
        return contraction.expanded(run.diagram), work
    except DiagramMemoryError:
        return None, work


def _best_order(
    parts: _Stages, memory: int, most_work: int, progress: ProgressCallback | None
) -> tuple[list[int] | None, int]:
    """Return the order whose first stages cost the least, None if all cost too much, and the work of trials.

    What the first stages cost predicts the order of what all stages cost, the better the more there are.
    """
    orders, work, memory = _orders(parts.parts), 0, min(memory, TRIAL_MEMORY)
    for stages in range(KNOWN_GROWTH, len(parts.parts.components)):
        limit = min(FIRST_WORK << (stages - KNOWN_GROWTH), most_work)
        trials: list[tuple[_Expected, int]] = []
        for number, order in enumerate(orders):
            if work > most_work * TRIAL_PART:
                break
            if number == FIRST_ORDERS and trials and min(trials)[0].at_end < EASY_WORK:
                break
            run = _StagedRun(parts, order, memory, progress)
            expected = run.tried(stages, limit)
            if expected is not None:
                trials.append((expected, number))
                limit = min(limit, run.work * WORTH_TRYING)
            work += run.work
        trials.sort()
        if trials:
            best = trials[0][0]
            kept = min(MOST_KEPT, int(best.at_end * TRIALS_OF_STAGE / best.next_stage))
            if best.at_end < EASY_WORK:
                kept = 1
            orders = [orders[number] for _, number in trials[: max(1, kept)]]
        elif stages == KNOWN_GROWTH:
            return None, work
        if len(orders) == 1 or not trials:
            break
    return orders[0], work


def _orders(parts: Joined) -> list[list[int]]:
    """Return orders to begin with, bottom first: components, with others above and below them.

    If processes pass shared variables one after the other, those that they pass first should be near them.
    Whether the last ones should be above or below them is not known before.
    """
    start = first_start(parts.encoding, EventTables.of(parts.encoding))
    inside = set(parts.components)
    lower = [level for level in start if level in inside]
    upper = [level for level in start if level not in inside]
    size = len(upper)
    parted = sorted({0, size // 2, (size + 1) // 2, max(size - 1, 0), size})
    found = (
        [*others[:below], *middle, *others[below:]]
        for below in parted
        for middle in (lower, lower[::-1])
        for others in (upper, upper[::-1])
    )
    return list(map(list, dict.fromkeys(map(tuple, found))))


def _serve(groups: list[tuple[int, ...]], encoding: Encoding) -> bool:
    """Return whether groups of levels may be worth stages."""
    several = sum(len(group) > 1 for group in groups)
    return FEWEST <= several <= MOST and len(groups) <= SOME_LEFT * len(encoding.levels)


@dataclass(order=True, frozen=True)
class _Expected:
    """Expected work of all stages, and of all up to the next one."""

    at_end: float
    next_stage: float


class _Stages:
    """Joined levels, and the events of each stage, by the order of the components.

    The events of a stage change its component, and none of a later stage. An event that changes no component
    belongs to the last that it touches.
    """

    def __init__(self, parts: Joined) -> None:
        self.parts = parts
        self._made: dict[tuple[int, ...], list[EventTables]] = {}

    def events(self, order: Sequence[int]) -> list[EventTables]:
        """Return the events of each stage for an order of the levels, bottom first."""
        inside, encoding = set(self.parts.components), self.parts.encoding
        ordered = tuple(k for k in order if k in inside)
        if ordered in self._made:
            return self._made[ordered]
        stage_of = {level: number for number, level in enumerate(ordered)}
        stages: defaultdict[int, list[LocalEvent]] = defaultdict(list)
        for event in encoding.events:
            moved = {stage_of[k] for k, table in event.tables.items() if k in stage_of and changes(table)}
            if not moved and not event.is_change:
                continue
            moved = moved or {stage_of[k] for k in event.tables if k in stage_of}
            stages[max(moved, default=0)].append(event)
        made = [EventTables.of(replace(encoding, events=tuple(stages[number]))) for number in sorted(stages)]
        self._made[ordered] = made
        return made


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
    stages, order
        Joined levels and their order, bottom first.
    weights
        By level and local state: how many local states it stands for; one each by default.
    """

    def __init__(
        self,
        stages: _Stages,
        order: list[int],
        memory: int,
        progress: ProgressCallback | None,
        weights: list[list[int]] | None = None,
    ) -> None:
        encoding = stages.parts.encoding
        self.diagram = diagram = Diagram(encoding, order, memory, most_cache=MOST_CACHE)
        self._progress, self._weights = progress, weights
        self._relations = [Relations.under(tables, diagram.position) for tables in stages.events(order)]
        self._left = 0
        self._room = FIRST_GARBAGE
        self._states = 0  # the set so far; 0: not made yet

    @property
    def stages(self) -> int:
        """Number of stages."""
        return len(self._relations)

    @property
    def work(self) -> int:
        """Work so far, in cache misses."""
        return self.diagram.effort

    def tried(self, stages: int, limit: int) -> _Expected | None:
        """Run up to a number of stages, and return what is expected then.

        The result is None if they cost more than a limit. Nothing is reported.
        """
        self._left, before = limit, 1
        stages = min(stages, self.stages)
        try:
            for stage in range(stages):
                before = max(1, self.work)
                if not self._closes(stage):
                    return None
        except DiagramMemoryError:
            return None
        growth = max(1, self.work) / before
        return _Expected(self.work * growth ** (self.stages - stages), self.work * growth)

    def reaches_end(self, most_work: int) -> bool:
        """Run all stages; False if they cost too much, also if that is only expected by their growth."""
        before, growth = 0, math.inf
        try:
            for stage in range(self.stages):
                self._left = most_work if stage >= KNOWN_GROWTH else min(FIRST_WORK, most_work)
                if not self._closes(stage):
                    return False
                self._report()
                if before:
                    growth, earlier = self.work / before, growth
                    at_end = _log_at_end(self.work, growth, earlier, stage + 1, self.stages)
                    if stage + 1 >= KNOWN_GROWTH and at_end > math.log(most_work):
                        return False
                before = self.work
        except DiagramMemoryError:
            return False
        self.diagram.finish(self._states)
        return True

    def _closes(self, last: int) -> bool:
        """Close the set under one more stage; False if that costs too much."""
        found = self._closed_under(self._states or self._initial(), last)
        if found is None:
            return False
        self._states = found
        return True

    def _initial(self) -> int:
        """Return the set with the initial marking only."""
        diagram, states = self.diagram, 1
        for level in range(1, diagram.top + 1):
            children = [0] * int(diagram.width[level])
            children[diagram.encoding.levels[diagram.order[level - 1]].initial] = states
            states = diagram.node(level, children)
        return states

    def _report(self) -> None:
        """Report how many markings there are at least."""
        if self._progress is not None:
            with suppress(DiagramMemoryError):
                counts = DiagramCounts(self.diagram, self._states)
                found = counts.vectors() if self._weights is None else counts.weighted(self._weights)
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
