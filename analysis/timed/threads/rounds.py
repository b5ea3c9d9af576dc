"""Rounds of the search through state classes: several threads expand many classes together.

Numbers of classes, edges and markings are those that one thread gives; `kernels.rounds` describes how.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from typing import NamedTuple

import numpy as np

from dineros.analysis.timed.kernels import rounds as kernels
from dineros.analysis.timed.kernels.markings import CLASSES, NEXT
from dineros.analysis.timed.kernels.successors import DONE, LOAD, has_room
from dineros.analysis.timed.tables import Batch, Known, NetTables, Work, batch_for

PART, PARTS = 256, 32
"""Classes of a part, which a thread expands at a time, and parts of a round."""
LEAST = 4 * PART
"""Classes of a round at least: one thread expands fewer as quickly."""
FIRST_SEEN = 1 << 12
FIRST_ITEMS, FIRST_WORDS = 1 << 10, 1 << 15
"""Room of a part for records and their elements. More room lies in more pages of memory, which cost time."""


class How(NamedTuple):
    """How classes are expanded: see `ClassSearch`."""

    is_strong: bool
    bits: int
    top: int


class Rounds:
    """Expands many classes in threads, with the same result as one thread.

    Parameters
    ----------
    workers : int
        Number of threads, the one that calls included.
    least : int
        Number of classes from which on threads work together.
    net, how
        The net, and how its classes are expanded.
    enlarge : callable
        Gives all tables more room; returns what is known.
    matrices : callable
        Returns room for matrices of so many clocks.
    """

    def __init__(
        self,
        workers: int,
        least: int,
        net: NetTables,
        how: How,
        enlarge: Callable[[], Known],
        matrices: Callable[[int], Work],
    ) -> None:
        self._workers, self._least, self._net, self._how = workers, least, net, how
        self._enlarge, self._matrices = enlarge, matrices
        self._pool: ThreadPoolExecutor | None = None
        self._batches: Batch | None = None
        self._items, self._words = FIRST_ITEMS, FIRST_WORDS
        self._most = FIRST_ITEMS, FIRST_WORDS
        self._works: list[Work] = []
        self._seen = [np.zeros(FIRST_SEEN, dtype=np.int64) for _ in range(workers)]
        self._turn = np.zeros(1, dtype=np.int64)
        self._counts = np.zeros((workers, PARTS, kernels.COUNTS), dtype=np.int64)
        self._room = np.zeros((PARTS, kernels.COUNTS), dtype=np.int64)
        self._total = np.zeros(kernels.COUNTS, dtype=np.int64)
        self._number = 0

    def explore(self, known: Known, work: Work, batch: Batch, most: int, seconds: float) -> bool:
        """Expand at most so many classes, for about so long; return whether any were expanded.

        If none were, one thread has to continue: there are few classes, or a table lacks room.

        Parameters
        ----------
        known, work, batch
            What is known, and the room that one thread uses; each thread gets as much.
        """
        if known.control[CLASSES] < self._least:
            return False
        self._most = batch.fired.size, batch.record.size
        if not self._works or self._works[0] is not work:
            clocks = len(work.low) - 1
            self._works = [work, *(self._matrices(clocks) for _ in range(1, self._workers))]
        ends, left = time.perf_counter() + seconds, most
        while left > 0 and time.perf_counter() < ends:
            done, known = self._round(known, self._room_for_parts(), left)
            if done == 0:
                break
            left -= done
        return left < most

    def _room_for_parts(self) -> Batch:
        """Return the batches of all parts, larger ones after a part has lacked room."""
        sizes = min(self._items, self._most[0]), min(self._words, self._most[1])
        if self._batches is None or (self._batches.fired.shape[1], self._batches.record.shape[1]) != sizes:
            self._batches = batch_for(PART, *sizes, PARTS)
        return self._batches

    def _round(self, known: Known, batches: Batch, most: int) -> tuple[int, Known]:
        """Expand at most so many classes; return how many, and what is known."""
        net, how, works, turn = self._net, self._how, self._works, self._turn
        count = min(int(known.control[CLASSES] - known.control[NEXT]), most, PART * PARTS)
        if count < min(LEAST, max(self._least, 1)):
            return 0, known
        wanted = count

        def expand(me: int, is_second: bool) -> None:
            kernels.expand_parts(net, known, works[me], batches, turn, count, is_second, *how)

        self._together(lambda me: expand(me, False))
        count = int(kernels.fire_pending(net, known, works[0], batches, count))
        self._together(lambda me: expand(me, True))
        count, items = (int(n) for n in kernels.expanded(batches, count))
        if count < wanted and self._items < self._most[0]:
            self._items, self._words = 2 * self._items, 2 * self._words
        if count == 0:
            return 0, known
        known = self._with_room(known, items)
        if has_room(net, known, works[0], items) != DONE:
            return 0, known
        self._store(known, batches, count)
        return count, known

    def _with_room(self, known: Known, items: int) -> Known:
        """Give so many records room in the table of classes, and in those of the threads."""
        while int(known.control[CLASSES]) + items > LOAD * known.class_table.size:
            known = self._enlarge()
        while len(self._seen[0]) < 2 * items:
            self._seen = [np.zeros(2 * len(seen), dtype=np.int64) for seen in self._seen]
        return known

    def _store(self, known: Known, batches: Batch, count: int) -> None:
        """Store what follows so many classes."""
        self._number += 1
        number, workers, seen, turn = self._number, self._workers, self._seen, self._turn
        counts, room, total = self._counts, self._room, self._total
        self._together(lambda me: kernels.find_first(batches, seen[me], number, me, workers, count, counts))
        kernels.give_room(known, counts, -(-count // batches.first_item.shape[1]), room, total)
        self._together(lambda _: kernels.store_parts(known, batches, room, turn, count))
        if known.edge_target.size:
            self._together(lambda _: kernels.link_parts(known, batches, room, turn, count))
        kernels.end_round(known, total, count)

    def _together(self, work: Callable[[int], None]) -> None:
        """Run all threads, the first one in this thread, and wait for all."""
        if self._pool is None:
            self._pool = ThreadPoolExecutor(self._workers - 1)
        self._turn[0] = 0
        tasks = [self._pool.submit(work, me) for me in range(1, self._workers)]
        try:
            work(0)
        finally:
            wait(tasks)  # threads cannot be stopped; but a call is short
        for task in tasks:
            task.result()

    def close(self) -> None:
        """Let the threads end; the next round starts others."""
        if self._pool is not None:
            self._pool.shutdown(wait=True)
            self._pool = None
