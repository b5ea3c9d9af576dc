"""Breadth-first search by the explicit engine: workers, memory, pauses, goals."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.compiled import CompiledNet
from dineros.analysis.coverability import Pumping, coverability
from dineros.analysis.explicit_figures import largest_tokens, members
from dineros.analysis.explicit_goals import Goal, goal_tables, normalized
from dineros.analysis.explicit_kernels import (
    ARCS,
    BATCH,
    CONTROL_SIZE,
    COUNT,
    DEADLOCK_ROW,
    DEADLOCKS,
    HAS_OVERFLOW,
    IS_FULL,
    LIMIT,
    NEXT,
    check_goals,
    expand,
    insert_all,
    owner_of,
    rebuild,
    receive,
    repack,
)
from dineros.analysis.explicit_layout import Layout, layout
from dineros.analysis.explicit_memory import lazy_zeros, new_boxes
from dineros.analysis.explicit_paths import path, pumping, steps
from dineros.analysis.explicit_tables import (
    SET_BITS,
    Worker,
    net_tables,
    stubborn_tables,
    transition_order,
    transition_set,
)

Progress = Callable[[int, float, int], None]

#: Share of the slots of a table that are taken before it grows, and when it may not grow any more.
USUAL_LOAD, HIGHEST_LOAD = 0.7, 0.93
FIRST_TABLE = 1 << 12
#: Tables up to here grow fourfold.
SMALL_TABLE = 1 << 20
#: Rows of a box in which markings wait for another worker.
BOX_ROWS = 1 << 15
#: Rows per call of a kernel at first; later calls take about `CALL_SECONDS`.
FIRST_SLICE, LARGEST_SLICE = 1 << 11, 1 << 24
CALL_SECONDS = 0.1
PROGRESS_SECONDS = 0.5
#: Frontiers of fewer rows are not worth a thread.
LEAST_FOR_THREADS = 1 << 9
#: Markings per word for which kernels are compiled apart.
LARGEST_SPECIAL_WIDTH = 4
#: Nodes of the coverability tree that may be made to explain why a search did not end.
COVERABILITY_NODES = 2_000


@dataclass
class Limits:
    """What a search may take, and whom it tells."""

    memory: int
    states: int | None = None
    seconds: float | None = None
    progress: Progress | None = None


@dataclass
class Search:
    """A breadth-first search; `run` goes through with it.

    Attributes
    ----------
    net, goals, limits
        What is searched, for what, with what.
    workers : int
        Threads; a net with places that nothing bounds is searched by one.
    reduction : bool
        Whether to fire stubborn sets only.
    keeps_parents : bool
        Whether ways back can be told.
    stops_when_unbounded : bool
    """

    net: CompiledNet
    goals: Sequence[Goal]
    limits: Limits
    workers: int = 1
    reduction: bool = False
    keeps_parents: bool = False
    stops_when_unbounded: bool = True
    layout: Layout = field(init=False)
    reason: str | None = field(init=False, default=None)
    pumping: Pumping | None = field(init=False, default=None)
    found: dict[int, tuple[int, int]] = field(init=False, default_factory=dict)  #: goal -> (worker, row)
    seconds: float = field(init=False, default=0.0)

    def __post_init__(self) -> None:
        self._started = time.perf_counter()
        self._told = self._started
        self.layout = layout(self.net)
        self._is_guarded = any(cell.has_guard for cell in self.layout.cells)
        if self._is_guarded:
            self.workers, self.keeps_parents = 1, True
        self._order = transition_order(self.net, self.layout)
        self._position = {t: i for i, t in enumerate(self._order)}
        rows = [normalized(goal) for goal in self.goals]
        self._conjunctions = [conjunction for row in rows for conjunction in row]
        self._owner = [g for g, row in enumerate(rows) for _ in row]
        self._prepare()
        self._slice, self._next_look = FIRST_SLICE, 0
        self._pool = ThreadPoolExecutor(self.workers) if self.workers > 1 else None
        box_rows = BATCH + len(self._order) + 1 + (BOX_ROWS if self.workers > 1 else 0)
        self._boxes = new_boxes(self.workers, box_rows, self.layout.words)
        self._crew = [self._new_worker() for _ in range(self.workers)]
        self._place_initial()

    # tables

    def _prepare(self) -> None:
        """Make the tables that depend on the layout."""
        self._net_tables = net_tables(self.net, self.layout, self._order)
        self._goal_tables = goal_tables(self.layout, self._conjunctions)
        for conjunction, goal in enumerate(self._owner):
            self._goal_tables.is_open[conjunction] = goal not in self.found
        self._stubborn = stubborn_tables(
            self.net,
            self.layout,
            self._order,
            [dict(weights) for conjunction in self._conjunctions for weights, _ in conjunction],
            self.reduction,
            not self.goals or any(goal.is_deadlock for goal in self.goals),
        )
        words = self.layout.words
        # Loops over a tuple have a length that the compiler knows.
        self._shape = (0,) * words if words <= LARGEST_SPECIAL_WIDTH else np.zeros(words, dtype=np.int64)

    def _row_bytes(self) -> int:
        return 8 * self.layout.words + (8 if self.keeps_parents else 0)

    def _share(self) -> int:
        """Bytes for the markings and the table of each worker."""
        boxes = sum(box.nbytes + parents.nbytes for phase in self._boxes for box, parents, _ in phase)
        return (self.limits.memory - boxes) // self.workers

    def _new_worker(self) -> Worker:
        slots = FIRST_TABLE
        while slots * USUAL_LOAD < len(self._order) + 2 * BATCH:
            slots *= 2
        # One table and a few rows are always made: less would not even hold the first step.
        rows = max(self._share() // self._row_bytes(), slots)
        sets = self._net_tables.everything
        wanted = [self._position[t] for goal in self.goals for t in goal.transitions]
        worker = Worker(
            store=lazy_zeros(rows, self.layout.words),
            parents=lazy_zeros(rows if self.keeps_parents else 0),
            table=lazy_zeros(slots),
            control=np.zeros(CONTROL_SIZE, dtype=np.int64),
            ever=np.zeros_like(sets),
            wanted=transition_set(wanted, len(self._order)),
            transition_row=np.full(SET_BITS * len(sets), -1, dtype=np.int64),
            goal_row=np.full(len(self._conjunctions), -1, dtype=np.int64),
        )
        wants_deadlock = any(goal.is_deadlock for goal in self.goals)
        worker.control[DEADLOCK_ROW] = -1 if wants_deadlock else 0
        worker.control[LIMIT] = self._limit(worker, USUAL_LOAD)
        return worker

    def _place_initial(self) -> None:
        box = self.layout.pack(self.net.initial.tolist())[None, :]
        worker = self._crew[int(owner_of(box, 0, self._shape, self.workers))]
        no_parent = np.array([-1], dtype=np.int64)
        insert_all(self._shape, worker, box, no_parent, np.empty(BATCH, dtype=np.int64), 0, 1)
        check_goals(self._net_tables, self._goal_tables, worker)

    def _limit(self, worker: Worker, load: float) -> int:
        by_table = int(worker.table.size * load)
        by_memory = (self._share() - worker.table.nbytes) // self._row_bytes()
        limit = min(by_table, max(by_memory, 0), len(worker.store))
        if worker.table.size == FIRST_TABLE:
            limit = max(limit, len(self._order) + BATCH)
        return int(limit)

    def _make_room(self, me: int, incoming: int) -> bool:
        """Grow a worker's table until it takes `incoming` more markings; False when memory forbids it."""
        worker = self._crew[me]
        needed = int(worker.control[COUNT]) + incoming
        if needed <= worker.control[LIMIT]:
            return True
        slots = worker.table.size
        while slots * USUAL_LOAD < needed + BATCH:
            slots *= 4 if slots < SMALL_TABLE else 2
        if slots > worker.table.size:
            rows = (self._share() - 8 * slots) // self._row_bytes()
            if rows > needed + needed // 16:
                # The old table goes before the new one comes.
                worker = self._crew[me] = worker._replace(table=np.zeros(1, dtype=np.int64))
                worker = self._crew[me] = worker._replace(table=lazy_zeros(slots))
                rebuild(self._shape, worker)
        worker.control[LIMIT] = self._limit(worker, USUAL_LOAD)
        if needed > worker.control[LIMIT]:
            worker.control[LIMIT] = self._limit(worker, HIGHEST_LOAD)
        worker.control[IS_FULL] = 0
        return bool(needed <= worker.control[LIMIT])

    # rounds

    def run(self) -> None:
        """Search until all is seen, all goals are found or a limit is hit."""
        try:
            self._run()
        except KeyboardInterrupt:
            self.reason = "interrupted"
        finally:
            if self._pool is not None:
                self._pool.shutdown(wait=True)
        if self.reason in ("memory", "states", "time") and self._is_guarded and self.pumping is None:
            self.pumping = coverability(self.net, COVERABILITY_NODES).pumping
        if self.pumping is not None and self.reason not in (None, "goal"):
            self.reason = "unbounded"
        self.seconds = time.perf_counter() - self._started

    def _run(self) -> None:
        phase = 0
        self._note_goals()
        ends = [int(worker.control[COUNT]) for worker in self._crew]
        while self.reason is None:
            phase = 1 - phase
            pending = [self._incoming(1 - phase, me) for me in range(self.workers)]
            if self._is_level_done(ends) and not any(pending):
                ends = [int(worker.control[COUNT]) for worker in self._crew]
                if self._is_level_done(ends):
                    return
            reserve = len(self._order) + BATCH
            if not all(self._make_room(me, pending[me] + reserve) for me in range(self.workers)):
                self.reason = "memory"
                return
            started = time.perf_counter()
            self._round(phase, ends)
            seconds = time.perf_counter() - started
            if seconds < CALL_SECONDS / 2:
                self._slice = min(2 * self._slice, LARGEST_SLICE)
            elif seconds > 2 * CALL_SECONDS:
                self._slice = max(FIRST_SLICE, self._slice // 2)
            if any(worker.control[HAS_OVERFLOW] for worker in self._crew):
                self._widen()
            self._note_goals()
            self._pause()

    def _is_level_done(self, ends: Sequence[int]) -> bool:
        return all(worker.control[NEXT] >= end for worker, end in zip(self._crew, ends, strict=True))

    def _round(self, phase: int, ends: Sequence[int]) -> None:
        """Let every worker take what others found for it, and go on with its part of the level."""
        size = self._slice
        if self.limits.states is not None:
            size = min(size, max(1, self.limits.states - self.markings))
        rows = [int(worker.control[NEXT]) + size for worker in self._crew]
        if self.workers > 1:
            rows = [min(row, end) for row, end in zip(rows, ends, strict=True)]
        left = max(row - int(worker.control[NEXT]) for row, worker in zip(rows, self._crew, strict=True))
        if self._pool is None or left < LEAST_FOR_THREADS:
            for me in range(self.workers):
                self._step(phase, me, rows[me])
            return
        tasks = [self._pool.submit(self._step, phase, me, rows[me]) for me in range(self.workers)]
        try:
            wait(tasks)
        except KeyboardInterrupt:
            # Threads cannot be stopped; a step is short.
            wait(tasks)
            raise
        for task in tasks:
            task.result()

    def _step(self, phase: int, me: int, end: int) -> None:
        worker = self._crew[me]
        tables = self._shape, self._net_tables, self._goal_tables
        for sender in range(self.workers):
            box, parents, sizes = self._boxes[1 - phase][sender]
            if sender != me and sizes[me]:
                receive(*tables, worker, box[me], parents[me], int(sizes[me]))
                sizes[me] = 0
        box, parents, sizes = self._boxes[phase][me]
        expand(self._shape, me, *tables[1:], self._stubborn, worker, end, box, parents, sizes)

    def _incoming(self, phase: int, me: int) -> int:
        return sum(int(sizes[me]) for sender, (_, _, sizes) in enumerate(self._boxes[phase]) if sender != me)

    def _pause(self) -> None:
        now = time.perf_counter()
        limits = self.limits
        if limits.progress is not None and now - self._told > PROGRESS_SECONDS:
            self._told = now
            limits.progress(self.markings, self.markings / (now - self._started), self.memory)
        if self.reason is not None:
            return
        if limits.seconds is not None and now - self._started > limits.seconds:
            self.reason = "time"
        elif limits.states is not None and self.markings > limits.states:
            self.reason = "states"
        elif self._is_guarded and self.pumping is None and self.markings >= self._next_look:
            # Ways back take time: looked at whenever there are twice as many markings.
            self._next_look = 2 * self.markings
            newest = path(self.layout, self._crew, 0, self.markings - 1)
            self.pumping = pumping(self.net, newest)
            if self.pumping is not None and self.stops_when_unbounded:
                self.reason = "unbounded"

    # goals

    def _note_goals(self) -> None:
        """Note which goals are met, and stop looking for them."""
        if not self.goals:
            return
        for g, goal in enumerate(self.goals):
            if g in self.found:
                continue
            hit = next(self._hits(g, goal), None)
            if hit is not None:
                self.found[g] = hit
        open_goals = [g for g in range(len(self.goals)) if g not in self.found]
        for conjunction, g in enumerate(self._owner):
            self._goal_tables.is_open[conjunction] = g not in self.found
        still = [self._position[t] for g in open_goals for t in self.goals[g].transitions]
        for worker in self._crew:
            worker.wanted[:] = transition_set(still, len(self._order))
        if not open_goals:
            self.reason = "goal"

    def _hits(self, g: int, goal: Goal) -> Iterator[tuple[int, int]]:
        for me, worker in enumerate(self._crew):
            if goal.is_deadlock and worker.control[DEADLOCK_ROW] >= 0:
                yield me, int(worker.control[DEADLOCK_ROW])
            for t in goal.transitions:
                if worker.transition_row[self._position[t]] >= 0:
                    yield me, int(worker.transition_row[self._position[t]])
            for conjunction, owner in enumerate(self._owner):
                if owner == g and worker.goal_row[conjunction] >= 0:
                    yield me, int(worker.goal_row[conjunction])

    def trace(self, me: int, row: int) -> tuple[int, ...]:
        """Transitions that lead to a stored marking."""
        return steps(self.net, path(self.layout, self._crew, me, row))

    # places without a bound

    def _widen(self) -> None:
        """Give more bits to the places that overflow, and write all markings anew."""
        worker = self._crew[0]
        before = self.layout.unpack(worker.store[worker.control[NEXT]])
        over = self.layout.overflowing(self.net, before)
        old, tables = self.layout, self._net_tables
        self.layout = old.widened(over)
        self._prepare()
        count = int(worker.control[COUNT])
        rows = max(self._share() // self._row_bytes(), worker.table.size)
        if (
            rows < count
            or count * 8 * (old.words + self.layout.words) + worker.parents[:count].nbytes > self._share()
        ):
            self.reason, self.layout = "memory", old
            self._prepare()
            return
        store = lazy_zeros(rows, self.layout.words)
        new = self._net_tables
        repack(worker.store, store, count, tables.word, tables.shift, tables.mask, new.word, new.shift)
        parents = lazy_zeros(rows)
        parents[:count] = worker.parents[:count]
        worker = self._crew[0] = worker._replace(
            store=store, parents=parents, table=lazy_zeros(worker.table.size)
        )
        self._boxes = new_boxes(self.workers, self._boxes[0][0][0].shape[1], self.layout.words)
        rebuild(self._shape, worker)
        worker.control[HAS_OVERFLOW] = 0
        worker.control[LIMIT] = self._limit(worker, USUAL_LOAD)

    # figures

    def _sum(self, entry: int) -> int:
        return sum(int(worker.control[entry]) for worker in self._crew)

    @property
    def markings(self) -> int:
        """Markings seen."""
        return self._sum(COUNT)

    @property
    def expanded(self) -> int:
        """Markings of which all successors were made."""
        return self._sum(NEXT)

    @property
    def arcs(self) -> int:
        """Firings seen."""
        return self._sum(ARCS)

    @property
    def deadlocks(self) -> int:
        """Markings seen in which nothing is enabled."""
        return self._sum(DEADLOCKS)

    @property
    def memory(self) -> int:
        """Bytes touched by markings and tables."""
        tables = sum(int(worker.table.nbytes) for worker in self._crew)
        return self.markings * self._row_bytes() + tables

    def enabled_somewhere(self) -> NDArray[np.bool_]:
        """By transition: whether it was enabled in some marking."""
        return members(self._order, [worker.ever for worker in self._crew])

    def largest(self) -> tuple[tuple[int, ...], int]:
        """Largest tokens of each place, and of all places together, over all markings seen."""
        return largest_tokens(self.layout, self._net_tables, self._crew)
