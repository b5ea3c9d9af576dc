"""Memory for markings: the store, the table, and their growth within a budget."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from dineros.analysis.explicit.kernels.markings import BATCH, COUNT, LIMIT, rebuild
from dineros.analysis.explicit.lazy_arrays import HUGE_PAGE, lazy_zeros
from dineros.analysis.explicit.tables import Int64Array, Markings
from dineros.analysis.nets.memory import mappable_memory

#: Share of the slots of a table that are taken before it grows, and when it may not grow any more.
USUAL_LOAD, HIGHEST_LOAD = 0.7, 0.93
FIRST_TABLE = 1 << 12
#: Tables up to here grow fourfold.
SMALL_TABLE = 1 << 20
#: Budget from which the rest of a huge page can be spared for every array and worker.
LEAST_FOR_HUGE_PAGES = 1 << 26
#: Share of the address space left that markings may map; tables, threads, and a second store while markings
#: are written again, need the rest.
MAPPED_SHARE = 0.4
#: Bytes of the address space that a table leaves to threads and kernels that are loaded later.
SPARE_ADDRESSES = 1 << 25

#: Calls a function of a worker for every worker, side by side.
Run = Callable[[Callable[[int], None]], None]


class Storage:
    """Markings of all workers, within a budget.

    Attributes
    ----------
    row_bytes : int
        Size of a marking in bytes, without its share of the table.
    """

    def __init__(
        self, budget: int, workers: int, words: int, reserve: int, keeps_parents: bool, stack_bytes: int
    ) -> None:
        self._workers = workers
        self._keeps_parents = keeps_parents
        self._stack_bytes = stack_bytes
        self._reserve = reserve + BATCH
        self._is_huge = budget >= LEAST_FOR_HUGE_PAGES
        self._budget = budget - (HUGE_PAGE * (2 * workers + 1) if self._is_huge else 0)
        self._slots = FIRST_TABLE
        while self._slots * USUAL_LOAD < workers * self._reserve:
            self._slots *= 2
        self._least = self._slots
        self._allocate(words)

    def _allocate(self, words: int) -> None:
        self.row_bytes = 8 * words + 8 * self._keeps_parents + self._stack_bytes
        # One table and a few rows are always made: less would not even hold the first step.
        mapped = int(mappable_memory() * MAPPED_SHARE) // self._workers
        rows = max(min(self._budget, mapped) // self.row_bytes, self._slots)
        every = rows * self._workers
        self.markings = Markings(
            lazy_zeros(every, words, self._is_huge),
            lazy_zeros(every if self._keeps_parents else 0, None, self._is_huge),
            lazy_zeros(self._slots, None, self._is_huge),
            rows,
        )

    @property
    def table_bytes(self) -> int:
        """Size of the table in bytes."""
        return int(self.markings.table.nbytes)

    def make_room(self, controls: Sequence[Int64Array], active: int, shape: object, run: Run) -> bool:
        """Give each worker rows to fill, and grow the table when needed; False: no memory.

        Parameters
        ----------
        controls
            Control arrays of all workers.
        active
            Number of workers that will work: the first one, or all.
        shape
            Shape of markings, for kernels.
        run
            Runs all workers, to fill the larger table.
        """
        total = sum(int(control[COUNT]) for control in controls)
        needed = total + active * self._reserve
        limit = self._limit(USUAL_LOAD)
        if limit - needed < limit // 16 and self._grow(controls, needed, shape, run):
            limit = self._limit(USUAL_LOAD)
        if limit < needed:
            limit = self._limit(HIGHEST_LOAD)
        for control in controls:
            room = (limit - total) // active
            control[LIMIT] = min(int(control[COUNT]) + room, self.markings.rows)
        return needed <= limit

    def _limit(self, load: float) -> int:
        slots = self.markings.table.size
        limit = min(int(slots * load), (self._budget - 8 * slots) // self.row_bytes, self.markings.rows)
        return int(max(limit, self._workers * self._reserve) if slots == self._least else limit)

    def _grow(self, controls: Sequence[Int64Array], needed: int, shape: object, run: Run) -> bool:
        slots = self.markings.table.size
        while slots * USUAL_LOAD < needed + needed // 8:
            slots *= 4 if slots < SMALL_TABLE else 2
        rows = (self._budget - 8 * slots) // self.row_bytes
        if slots == self.markings.table.size or rows <= needed + needed // 16:
            return False
        # With a limit of the address space, if a larger table is impossible, the current one is kept.
        if 8 * slots - self.table_bytes > mappable_memory() - SPARE_ADDRESSES:
            return False
        self._fill_anew(slots, controls, shape, run)
        return True

    def _fill_anew(self, slots: int, controls: Sequence[Int64Array], shape: object, run: Run) -> None:
        # The old table is freed before the new one is allocated.
        self.markings = self.markings._replace(table=np.zeros(1, dtype=np.int64))
        table = lazy_zeros(slots, None, self._is_huge)
        markings = self.markings = self.markings._replace(table=table)

        def fill(me: int) -> None:
            rebuild(shape, markings.store, table, me * markings.rows, int(controls[me][COUNT]))

        run(fill)

    def exchange(
        self, words: int, controls: Sequence[Int64Array], shape: object, write: Callable[[Int64Array], None]
    ) -> bool:
        """Write all markings of a single worker again, with another number of words; False: no memory.

        Parameters
        ----------
        words
            New number of words of a marking.
        write
            Fills the new store.
        """
        old, count = self.markings, int(controls[0][COUNT])
        extra = count * 8 * (old.store.shape[1] + words)
        if extra + old.parents[:count].nbytes + 2 * old.table.nbytes > self._budget:
            return False
        self._slots = old.table.size
        self._allocate(words)
        write(self.markings.store)
        self.markings.parents[:count] = old.parents[:count]
        self._fill_anew(self._slots, controls, shape, lambda fill: fill(0))
        return True
