"""Search for a good order of the levels of a decision diagram, for each net.

The size of a diagram, and even more the effort of saturation, depend on the order of its levels. The first
orders are made from the structure of the net (module `level_starts`) and are cheap; many nets need no others.
FORCE makes further candidates from random starts, and local moves improve them. The cost of a candidate is
measured, not estimated: saturation runs on an instance of the same structure with all large markings and
weights scaled down. Such a run takes milliseconds and stops when it exceeds the lowest effort so far.

Local moves end in a local optimum that depends on the start. A long search therefore consists of several
climbs from different starts. Their orders are compared on an instance that is scaled down less: it is closer
to the net itself, but measuring every candidate on it would cost too much.
"""

from __future__ import annotations

import random
from dataclasses import replace
from functools import cached_property

import numpy as np

from dineros.analysis.answers.budget import ProgressCallback
from dineros.analysis.nets.compiled import ArcTable, CompiledNet
from dineros.analysis.symbolic.level_starts import first_start, force_order, span, starts, wide_on_top
from dineros.analysis.symbolic.levels import Encoding, encode_like
from dineros.analysis.symbolic.relations import EventTables
from dineros.analysis.symbolic.saturation import Diagram

TRIAL_MEMORY = 1 << 28
LEAST_TRIAL_MEMORY = 1 << 24
TRIAL_CACHE = 1 << 16
TRIAL_BUCKETS = 1 << 14
#: Share of the first search of a climb that is spent on starts, not on improving the best; and its minimum.
START_SHARE = 0.25
START_WORK = 75_000
#: Lowest effort of an instance that can distinguish good orders from bad ones.
LEAST_EFFORT = 300
#: Cost of making and setting up a candidate, in cache misses of saturation.
TRIAL_WORK = 1_000
#: Effort allowed to the first starts, and number of starts that are tried before the effort is doubled.
FIRST_EFFORT = 2_000
STARTS_PER_LIMIT = 12
#: Effort allowed to each of the orders made from the structure: at first, and at most.
FIRST_RACE, LAST_RACE = 500, 128_000
#: Number of orders made from the structure that are tried on the net itself: those of the shortest spans.
SHORTEST = 4
#: Effort below which no other order is expected to be much better: a part for each entry of the tables of
#: the events, and a constant part.
GOOD_EFFORT = 8
LEAST_GOOD_EFFORT = 50_000
#: A net with more than this many times the local states of its smallest instance is first tried on that one.
WIDE = 4
#: Exception: if levels have few local states on average, misses are cheap, and the first order is tried with
#: the effort of a race.
NARROW = 20
RACE_EFFORT = 16_000
#: Work of a climb after which the next one begins, number of climbs, and factor by which the largest
#: marking is larger in the instance that decides between them.
CLIMB_WORK = 8_000_000
CLIMBS = 4
DECIDING_FACTOR = 4
#: Largest assumed ratio between the effort on the net itself and on that instance.
LARGEST_GROWTH = 8


def scaled_down(net: CompiledNet, largest: int) -> CompiledNet:
    """Return the same net with every marking and weight above `largest` reduced to `largest`."""

    def scale(arcs: ArcTable) -> ArcTable:
        return replace(arcs, weight=np.minimum(arcs.weight, largest))

    return CompiledNet(
        net.places,
        net.transitions,
        np.minimum(net.initial, largest),
        scale(net.pre),
        scale(net.post),
        scale(net.inhibitor),
    )


class OrderSearch:
    """Resumable search for a good order.

    Parameters
    ----------
    seed
        Seed of the random moves: the same seed and work give the same order.
    memory
        Memory limit of a trial, in bytes.
    progress
        Called regularly; an exception raised in it ends the search.

    Attributes
    ----------
    order : list of int
        Best order so far, bottom first; `first_start` until a candidate is finished.
    work : int
        Cost of the search so far, in cache misses of saturation.
    """

    def __init__(
        self,
        encoding: Encoding,
        events: EventTables,
        seed: int = 1,
        memory: int = TRIAL_MEMORY,
        progress: ProgressCallback | None = None,
    ) -> None:
        self._progress = progress
        self._encoding = encoding
        self._events = events
        self._seed = seed
        self._memory = min(max(memory, LEAST_TRIAL_MEMORY), TRIAL_MEMORY)
        self._climbs: list[_Climb] = []
        self._best: _Climb | None = None
        self._least: int | None = None
        self.order = first_start(encoding, events)
        self.work = 0
        self._effort: int | None = None

    @property
    def good_effort(self) -> int | None:
        """Effort at which the first order is accepted without trying others; None: first try it small."""
        levels, events = self._encoding.levels, self._events
        states = sum(len(level.states) for level in levels)
        if states > WIDE * sum(len(level.places) + 1 for level in levels):
            return RACE_EFFORT if states <= NARROW * len(levels) else None
        entries = int(np.diff(events.pair_start)[events.event_table].sum())
        return LEAST_GOOD_EFFORT + GOOD_EFFORT * entries

    def race(self) -> None:
        """Choose the best of the orders made from the structure, measured on the trials' instance.

        All orders get the same effort, which grows until one of them finishes. If none does, the one that has
        finished the most levels is chosen, and of several the one with the fewest nodes.
        """
        if len(self.order) < 3:
            return
        orders, limit = list(starts(self._encoding, self._events)), FIRST_RACE
        trial = self._scaled[1]
        while self._effort is None and limit <= LAST_RACE:
            reached: list[tuple[int, int]] = []
            for order in orders:
                trial.restart(order)
                if trial.run(self._progress, limit if self._effort is None else self._effort):
                    self._effort, self.order = trial.effort, order
                self.work += trial.effort + TRIAL_WORK
                reached.append((-trial.saturated, trial.peak_nodes))
            limit *= 4
        if self._effort is None:
            self.order = orders[reached.index(min(reached))]

    @cached_property
    def shortest(self) -> list[list[int]]:
        """The orders made from the structure whose events have the shortest spans."""
        found = sorted(starts(self._encoding, self._events), key=lambda order: span(self._events, order))
        return found[:SHORTEST]

    @property
    def wide_on_top(self) -> list[int] | None:
        """The order with wide levels at the top, if levels differ much in width."""
        return wide_on_top(self._encoding, self._events)

    @property
    def is_blind(self) -> bool:
        """Whether no order has finished on the trials' instance yet, so that orders cannot be compared."""
        return self._effort is None and all(climb.effort is None for climb in self._climbs)

    def improve(self, work: int) -> None:
        """Continue the search for about `work` cache misses of saturation; it does not depend on time."""
        if work == 0 or len(self.order) < 3:
            return
        climb = self._next_climb()
        before = climb.work
        climb.improve(work)
        self.work += climb.work - before
        if len(self._climbs) == 1:
            self.order = climb.order
        else:
            self._decide(climb)

    def is_promising(self, work: int) -> bool:
        """Return whether the best order may need at most `work` cache misses on the net itself.

        An order that needs more than its share of them on the deciding instance is not run.
        """
        largest, most = DECIDING_FACTOR * self._scaled[0], self._largest_marking
        if most <= largest:
            return True
        self._deciding.restart(self.order)
        finished = self._deciding.run(self._progress, int(work / min((most / largest) ** 2, LARGEST_GROWTH)))
        self.work += self._deciding.effort
        return finished

    def _next_climb(self) -> _Climb:
        """Return the last climb if it is short, otherwise a new one; if there are enough, the best one."""
        if self._climbs and self._climbs[-1].work < CLIMB_WORK:
            return self._climbs[-1]
        if len(self._climbs) == CLIMBS and self._best is not None:
            return self._best
        seed, effort = self._seed + len(self._climbs), None if self._climbs else self._effort
        self._climbs.append(_Climb(self._scaled[1], self._events, self.order, effort, seed, self._progress))
        return self._climbs[-1]

    def _decide(self, latest: _Climb) -> None:
        """Choose between the climbs on the deciding instance."""
        for climb in self._climbs if self._best is None else [latest]:
            if climb.effort is None:
                continue
            self._deciding.restart(climb.order)
            finished = self._deciding.run(self._progress, self._least)
            self.work += self._deciding.effort
            if finished:
                self._best, self._least, self.order = climb, self._deciding.effort, climb.order

    @cached_property
    def _scaled(self) -> tuple[int, Diagram]:
        """Largest marking of the trials' instance, and the instance.

        It is the smallest instance that distinguishes orders: at very low efforts, the result is random.
        """
        largest = 1
        while True:
            small = _scaled_down(self._encoding, largest)
            trial = Diagram(small, range(len(small.levels)), self._memory, TRIAL_CACHE, TRIAL_BUCKETS)
            trial.restart(self.order)
            is_easy = trial.run(self._progress, LEAST_EFFORT)
            self.work += trial.effort + TRIAL_WORK
            if not is_easy or largest >= self._largest_marking:
                return largest, trial
            largest *= 2

    @cached_property
    def _deciding(self) -> Diagram:
        small = _scaled_down(self._encoding, DECIDING_FACTOR * self._scaled[0])
        return Diagram(small, range(len(small.levels)), self._memory)

    @property
    def _largest_marking(self) -> int:
        net = self._encoding.boxes.net
        return max(int(part.max(initial=1)) for part in (net.initial, net.pre.weight, net.post.weight))


def _scaled_down(encoding: Encoding, largest: int) -> Encoding:
    """Return the encoding of the scaled-down net, or of the net itself if the levels do not match."""
    try:
        return encode_like(encoding, scaled_down(encoding.boxes.net, largest))
    except ValueError:
        return encoding


class _Climb:
    """Local moves from one start to a local optimum.

    Attributes
    ----------
    effort : int or None
        Effort of the order on the scaled-down instance; None until a candidate is finished.
    work : int
    """

    def __init__(
        self,
        trial: Diagram,
        events: EventTables,
        order: list[int],
        effort: int | None,
        seed: int,
        progress: ProgressCallback | None,
    ) -> None:
        self._progress = progress
        self._trial = trial
        self._events = events
        self._random = random.Random(seed)
        self._limit = FIRST_EFFORT
        self._start, self._tried = order, 0
        self._start_work: int | None = None
        self.order = order
        self.effort = effort
        self.work = 0

    @cached_property
    def _spans_of(self) -> list[list[list[int]]]:
        """By level: the levels of each event that touches it."""
        spans_of: list[list[list[int]]] = [[] for _ in self.order]
        for touched in self._events.levels_of_events:
            for level in touched:
                spans_of[level].append(touched)
        return spans_of

    def improve(self, work: int) -> None:
        """Continue the search for about `work` cache misses of saturation; it does not depend on time."""
        limit = self.work + work
        if self._start_work is None:
            self._start_work = max(int(work * START_SHARE), START_WORK)
        self._find_start(min(self._start_work, limit), limit)
        while self.work < limit:
            self._try(self._neighbour())

    def _find_start(self, share: int, limit: int) -> None:
        """Try random starts under a small limit of effort, which doubles until a start stays within it."""
        while self.work < (share if self.effort is not None else limit):
            self._try(self._start)
            self._try(self._start[::-1])
            self._start = list(range(len(self.order)))
            self._random.shuffle(self._start)
            self._start = force_order(self._events, self._start)
            self._tried += 1
            if self._tried % STARTS_PER_LIMIT == 0:
                self._limit *= 2

    def _try(self, order: list[int]) -> None:
        limit = self._limit if self.effort is None else self.effort + 1
        self._trial.restart(order)
        finished = self._trial.run(self._progress, limit)
        if self._progress is not None:  # many short runs may take as long as one long one
            self._progress(self._trial.progress)
        self.work += self._trial.effort + TRIAL_WORK
        if finished and (self.effort is None or self._trial.effort <= self.effort):
            self.effort, self.order = self._trial.effort, list(order)

    def _neighbour(self) -> list[int]:
        """Return a copy of the best order with one level or block moved, or with a block reversed."""
        dice, order = self._random, list(self.order)
        size = len(order)
        kind = dice.random()
        if kind < 0.6:
            level = order.pop(dice.randrange(size))
            spans = self._spans_of[level]
            partner = dice.choice(dice.choice(spans)) if spans else dice.choice(order)
            at = order.index(partner) + dice.randint(0, 1) if partner != level else dice.randrange(size)
            order.insert(at, level)
            return order
        start, length = dice.randrange(size), dice.randint(2, 8)
        block = order[start : start + length]
        if kind < 0.85:
            del order[start : start + length]
            if dice.random() < 0.5:
                block.reverse()
            at = dice.randint(0, len(order))
            order[at:at] = block
        else:
            order[start : start + length] = block[::-1]
        return order
