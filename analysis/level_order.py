"""Orders of the levels of a decision diagram, searched for per net.

The size of a diagram, and even more the effort of saturation, hang on the order of its levels. Candidates
are made by the FORCE heuristic from random starts, then improved by local moves. What a candidate costs is
not estimated but measured: saturation itself runs on an instance of the same structure with all large
markings and weights scaled down, which takes milliseconds and stops as soon as it exceeds the best effort
so far.

References
----------
F. A. Aloul, I. L. Markov, K. A. Sakallah, *FORCE: a fast and easy-to-implement variable-ordering heuristic*,
GLSVLSI 2003.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from dineros.analysis.compiled import ArcTable, CompiledNet
from dineros.analysis.levels import Encoding, encode_like
from dineros.analysis.order_kernels import force
from dineros.analysis.saturation import Diagram

FORCE_ROUNDS = 60
TRIAL_MEMORY = 1 << 28
LEAST_TRIAL_MEMORY = 1 << 24
TRIAL_CACHE = 1 << 16
TRIAL_BUCKETS = 1 << 14
#: Share of the first search spent on making starts rather than on improving the best.
START_SHARE = 0.25
#: What making a candidate and setting it up costs, in cache misses of saturation.
TRIAL_WORK = 1_000
#: Effort allowed to the first starts, and how many starts are tried before it is doubled.
FIRST_EFFORT = 2_000
STARTS_PER_LIMIT = 12


def scaled_down(net: CompiledNet, largest: int = 1) -> CompiledNet:
    """The same net with every marking and weight above `largest` lowered to it."""

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
    """A search for a good order that can be continued.

    Parameters
    ----------
    encoding
        Levels and events of the net.
    seed
        Of the random moves: the same seed and work give the same order.
    memory
        Bytes that a trial may take.

    Attributes
    ----------
    order : list of int
        Best order so far, bottom first.
    effort : int or None
        Its effort on the scaled-down instance; None while no candidate was finished.
    work : int
        What the search has cost so far, in cache misses of saturation.
    """

    def __init__(self, encoding: Encoding, seed: int = 1, memory: int = TRIAL_MEMORY) -> None:
        try:
            small = encode_like(encoding, scaled_down(encoding.boxes.net))
        except ValueError:
            small = encoding
        memory = min(max(memory, LEAST_TRIAL_MEMORY), TRIAL_MEMORY)
        self._trial = Diagram(small, range(len(small.levels)), memory, TRIAL_CACHE, TRIAL_BUCKETS)
        self._spans_of: list[list[list[int]]] = [[] for _ in encoding.levels]
        for span in self._trial.events.levels_of_events:
            for level in span:
                self._spans_of[level].append(span)
        self._random = random.Random(seed)
        self._limit = FIRST_EFFORT
        self.order = self._force(range(len(encoding.levels)))
        self.effort: int | None = None
        self.work = 0

    def improve(self, work: int, patience: int | None = None) -> None:
        """Search on, for about so many cache misses of saturation; no clock decides.

        With `patience`, stop when the search has cost so many times what its best order costs.
        """
        if len(self.order) < 3:
            return
        limit = self.work + work
        if self.effort is None:
            self._find_start(self.work + int(work * START_SHARE), limit)
        while self.work < limit:
            if patience is not None and self.effort is not None:
                limit = min(limit, patience * (self.effort + TRIAL_WORK))
            self._try(self._neighbour())

    def _find_start(self, share: int, limit: int) -> None:
        """Random starts under a small limit of effort that doubles until one of them stays within it."""
        order = self.order
        while self.work < (share if self.effort is not None else limit):
            for _ in range(STARTS_PER_LIMIT):
                self._try(order)
                self._try(order[::-1])
                order = list(range(len(self.order)))
                self._random.shuffle(order)
                order = self._force(order)
            self._limit *= 2

    def _try(self, order: list[int]) -> None:
        limit = self._limit if self.effort is None else self.effort + 1
        self._trial.restart(order)
        finished = self._trial.run(effort_limit=limit)
        self.work += self._trial.effort + TRIAL_WORK
        if finished and (self.effort is None or self._trial.effort <= self.effort):
            self.effort, self.order = self._trial.effort, list(order)

    def _neighbour(self) -> list[int]:
        """Return the best order with one level moved to a neighbour by events, or a block moved or turned."""
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

    def _force(self, start: Sequence[int]) -> list[int]:
        order = np.array(start, dtype=np.int64)
        force(order, self._trial.events.event_start, self._trial.events.event_level, FORCE_ROUNDS)
        return [int(level) for level in order]
