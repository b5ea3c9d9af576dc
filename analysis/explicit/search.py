"""A search by the explicit engine: workers, rounds, pauses, goals."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.answers.budget import Budget, Progress
from dineros.analysis.answers.stages import Share
from dineros.analysis.explicit.agenda import AgendaPart, Rows, by_cost, closure, sets_by_cost
from dineros.analysis.explicit.figures import largest_tokens, members, tokens_of
from dineros.analysis.explicit.goals import Goal, goal_tables, normalized
from dineros.analysis.explicit.guidance import Guidance
from dineros.analysis.explicit.kernels.descent import descend
from dineros.analysis.explicit.kernels.expansion import STRIDE, expand
from dineros.analysis.explicit.kernels.markings import (
    ARCS,
    BATCH,
    CHUNK_END,
    CONTROL_SIZE,
    COUNT,
    DEADLOCK_ROW,
    DEADLOCKS,
    DEPTH,
    EXPANDED,
    HAS_OVERFLOW,
    NEXT,
    check_goals,
    rebuild,
    repack,
)
from dineros.analysis.explicit.layout import Layout, layout
from dineros.analysis.explicit.lazy_arrays import lazy_zeros, zeros_apart
from dineros.analysis.explicit.paths import path, pumping, steps
from dineros.analysis.explicit.storage import Storage
from dineros.analysis.explicit.tables import (
    SET_BITS,
    Int64Array,
    Notes,
    net_tables,
    stubborn_tables,
    transition_order,
    transition_set,
)
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.coverability import Pumping, coverability

#: Number of rows per call of a kernel at first; a later call expands this part of all rows so far. Seconds do
#: not count, so that a search stops at the same marking on any machine.
FIRST_SLICE, LARGEST_SLICE, PART_OF_SLICE = 1 << 11, 1 << 24, 1 / 32
PROGRESS_SECONDS = 0.5
#: Frontiers of fewer rows are not worth a thread.
LEAST_FOR_THREADS = 1 << 13
#: Number of markings before several threads search for goals. Which of them stores a marking first is chance,
#: so traces that are equally short may differ from run to run from there on.
LEAST_WITH_GOALS = 1 << 20
EVERYTHING = 1 << 60
#: Words per marking for which kernels are compiled apart: 5 to 12 % faster; with more words, 2 to 8 %.
LARGEST_SPECIAL_WIDTH = 2
#: Rows unpacked at once.
_ROWS_AT_ONCE = 1 << 16
#: Nodes of the coverability tree that may be made to explain why a search did not end, and part of the time.
COVERABILITY_NODES, COVERABILITY = 2_000, Share(time=0.2)


@dataclass
class Search:
    """A search; `run` performs it.

    Attributes
    ----------
    net, goals, budget
        The net, the goals and the budget of the search; the clock of the budget runs.
    workers : int
        Number of threads; one for depth-first search, or for a net with unbounded places.
    reduction : bool
        Whether to fire stubborn sets only.
    most_if_unbounded : int
        Number of markings at which a search ends if the net is known to be unbounded.
    guidance : Guidance, optional
        Guides the search for its only goal, if it is breadth first and all places are bounded: the result
        then has the least cost.
    most_cost : int, optional
        The largest cost of a trace, if guided.
    """

    net: CompiledNet
    goals: Sequence[Goal]
    budget: Budget
    workers: int = 1
    is_depth_first: bool = False
    reduction: bool = False
    most_if_unbounded: int = 0
    guidance: Guidance | None = None
    most_cost: int | None = None
    layout: Layout = field(init=False)
    reason: str | None = field(init=False, default=None)
    pumping: Pumping | None = field(init=False, default=None)
    found: dict[int, int] = field(init=False, default_factory=dict)  #: goal -> row

    def __post_init__(self) -> None:
        self._started = time.perf_counter()
        self._told = self._started
        self.budget.stage("the layout of markings")
        self.layout = self.net.once(layout)
        self._is_guarded = not self.layout.is_bounded
        if self._is_guarded or self.is_depth_first:
            self.workers = 1
        self._keeps_parents = bool(self.goals) or self._is_guarded
        self._order = transition_order(self.net, self.layout)
        self._position = {t: i for i, t in enumerate(self._order)}
        rows = [normalized(goal) for goal in self.goals]
        self._conjunctions = [conjunction for row in rows for conjunction in row]
        self._owner = [g for g, row in enumerate(rows) for _ in row]
        self._prepare()
        self._next_look = 0
        self._pool = ThreadPoolExecutor(self.workers - 1) if self.workers > 1 else None
        sets = len(self._net_tables.fired)
        self._storage = Storage(
            self.budget.memory,
            self.workers,
            self.layout.words,
            len(self._order),
            self._keeps_parents,
            8 * (1 + sets) if self.is_depth_first else 0,
        )
        self._crew = [self._new_notes() for _ in range(self.workers)]
        self._frontier = zeros_apart(STRIDE * self.workers)
        self._agenda = self._parts()
        self._goes_on = True
        if self.is_depth_first:
            rows_at_most = self._storage.markings.rows
            self._stack = lazy_zeros(rows_at_most), lazy_zeros(rows_at_most, sets)
        self._place_initial()

    # tables

    def _prepare(self) -> None:
        """Create the tables that depend on the layout."""
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
        # For a tuple, the compiler knows the number of iterations of a loop.
        self._shape = (0,) * words if words <= LARGEST_SPECIAL_WIDTH else np.zeros(words, dtype=np.int64)
        box_rows = BATCH + len(self._order) + 1
        self._boxes = [
            (lazy_zeros(box_rows, words), zeros_apart(box_rows), zeros_apart(box_rows))
            for _ in range(self.workers)
        ]

    def _new_notes(self) -> Notes:
        sets = len(self._net_tables.fired)
        notes = Notes(
            control=zeros_apart(CONTROL_SIZE),
            ever=zeros_apart(sets),
            wanted=zeros_apart(sets),
            transition_row=zeros_apart(SET_BITS * sets),
            goal_row=zeros_apart(len(self._conjunctions)),
        )
        wanted = [self._position[t] for goal in self.goals for t in goal.transitions]
        notes.wanted[:] = transition_set(wanted, len(self._order))
        notes.transition_row[:] = -1
        notes.goal_row[:] = -1
        notes.control[DEADLOCK_ROW] = -1 if any(goal.is_deadlock for goal in self.goals) else 0
        return notes

    def _place_initial(self) -> None:
        markings, notes = self._storage.markings, self._crew[0]
        markings.store[0] = self.layout.pack(self.net.initial.tolist())
        if self._keeps_parents:
            markings.parents[0] = -1
        rebuild(self._shape, markings.store, markings.table, 0, 1)
        notes.control[COUNT] = 1
        check_goals(self._net_tables, self._goal_tables, markings.store, notes, 0)

    # rounds

    def run(self) -> None:
        """Search until all markings are visited, all goals are found or a limit is exceeded."""
        self.budget.stage("explicit search")
        try:
            self._run()
        except KeyboardInterrupt:  # a supervisor of the time also ends a search by an interrupt
            self.reason = "time" if self.budget.is_over else "interrupted"
        except MemoryError:  # less memory than expected; the results so far are kept
            self.reason = "memory"
        finally:
            if self._pool is not None:
                self._pool.shutdown(wait=True)
        if self.reason in ("memory", "states", "time") and self._is_guarded and self.pumping is None:
            self.budget.stage("coverability")
            share = COVERABILITY.share(self.budget)
            self.pumping = coverability(self.net, COVERABILITY_NODES, share, only_boundedness=True).pumping
        if self.pumping is not None and self.reason not in (None, "goal"):
            self.reason = "unbounded"

    def _run(self) -> None:
        self._note_goals()
        controls = [notes.control for notes in self._crew]
        while self.reason is None:
            left = self._left()
            if left == 0:
                return
            # Chunks are not handed over: the worker that began one ends it.
            has_begun = any(notes.control[NEXT] < notes.control[CHUNK_END] for notes in self._crew[1:])
            is_worth_it = left >= LEAST_FOR_THREADS and (not self.goals or self.markings >= LEAST_WITH_GOALS)
            active = self.workers if is_worth_it or has_begun else 1
            if not self._storage.make_room(controls, active, self._shape, self._together):
                self.reason = "memory"
                return
            self._round(active)
            if controls[0][HAS_OVERFLOW]:
                self._widen()
            self._note_goals()
            self._pause()

    def _left(self) -> int:
        """Number of markings to expand: of the level, then of the next one; depth first, of the stack."""
        if self.is_depth_first:
            return self.markings if self.expanded == 0 else int(self._crew[0].control[DEPTH])
        left = 0
        for me, notes in enumerate(self._crew):
            left += int(notes.control[CHUNK_END] - notes.control[NEXT])
            left += max(0, int(self._frontier[me * STRIDE + 1] - self._frontier[me * STRIDE]))
        part = next(self._agenda, None) if left == 0 else None
        if part is None:
            return left
        for me, (start, end) in enumerate(zip(part.starts, part.ends, strict=True)):
            self._frontier[me * STRIDE : me * STRIDE + 2] = start, end
        self._goes_on = part.goes_on
        self._net_tables = self._net_tables._replace(fired=part.transitions)
        return sum(part.ends) - sum(part.starts)

    def _parts(self) -> Iterator[AgendaPart]:
        """Yield the next rows to expand, unless the search is depth first."""
        rows = self._storage.markings.rows
        starts = [me * rows for me in range(self.workers)]

        def ends() -> Rows:
            return [
                start + int(notes.control[COUNT]) for start, notes in zip(starts, self._crew, strict=True)
            ]

        def done() -> Rows:
            return [int(row) for row in self._frontier[1::STRIDE]]

        if self.guidance is None:
            return closure(self._net_tables.fired, starts, ends, done)
        wanted = [self._position[t] for goal in self.goals for t in goal.transitions]
        costs = [self.guidance.costs[t] for t in self._order]
        return by_cost(sets_by_cost(costs, wanted), starts, ends, done, self.most_cost)

    def _round(self, active: int) -> None:
        rows = min(LARGEST_SLICE, max(FIRST_SLICE, int(PART_OF_SLICE * self.expanded)))
        if self.budget.states is not None:
            rows = min(rows, max(1, self.budget.states - self.markings))
        net, goals, stubborn = self._net_tables, self._goal_tables, self._stubborn
        markings = self._storage.markings
        if self.is_depth_first:
            descend(self._shape, net, goals, stubborn, markings, self._crew[0], *self._stack, rows)
            return
        # In a large level, the other workers get their share.
        alone = EVERYTHING if self.workers == 1 else LEAST_FOR_THREADS
        if active > 1 or not self._goes_on:
            alone = 0

        def work(me: int) -> None:
            tables = net, goals, stubborn, markings, self._crew[me], self._frontier
            expand(self._shape, me, *tables, *self._boxes[me], rows, alone)

        if active > 1:
            self._together(work)
        else:
            work(0)

    def _together(self, work: Callable[[int], None]) -> None:
        """Run all workers, the first one in this thread, and wait for all."""
        tasks = [] if self._pool is None else [self._pool.submit(work, me) for me in range(1, self.workers)]
        try:
            work(0)
        finally:
            # Threads cannot be stopped; but a call is short.
            wait(tasks)
        for task in tasks:
            task.result()

    def _pause(self) -> None:
        now = time.perf_counter()
        budget = self.budget
        if budget.progress is not None and now - self._told > PROGRESS_SECONDS:
            self._told = now
            rate = self.markings / (now - self._started)
            budget.progress(Progress("markings", self.markings, self.memory, rate))
        if self.reason is not None:
            return
        if budget.is_over:
            self.reason = "time"
        elif budget.states is not None and self.markings > budget.states:
            self.reason = "states"
        elif self._is_guarded and self.pumping is None and self.markings >= self._next_look:
            # Traces take time: they are examined whenever the number of markings has doubled.
            self._next_look = 2 * self.markings
            newest = path(self.layout, self._storage.markings, self.markings - 1)
            self.pumping = pumping(self.net, newest)
        if self.reason is None and self.pumping is not None and self.markings >= self.most_if_unbounded:
            self.reason = "unbounded"

    # goals

    def _note_goals(self) -> None:
        """Record the goals that are fulfilled, and stop searching for them."""
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
        for notes in self._crew:
            notes.wanted[:] = transition_set(still, len(self._order))
        if not open_goals:
            self.reason = "goal"

    def _hits(self, g: int, goal: Goal) -> Iterator[int]:
        for notes in self._crew:
            if goal.is_deadlock and notes.control[DEADLOCK_ROW] >= 0:
                yield int(notes.control[DEADLOCK_ROW])
            for t in goal.transitions:
                if notes.transition_row[self._position[t]] >= 0:
                    yield int(notes.transition_row[self._position[t]])
            for conjunction, owner in enumerate(self._owner):
                if owner == g and notes.goal_row[conjunction] >= 0:
                    yield int(notes.goal_row[conjunction])

    def trace(self, row: int) -> tuple[int, ...]:
        """Return the transitions that lead to a stored marking."""
        return steps(self.net, path(self.layout, self._storage.markings, row))

    # places without a bound

    def _widen(self) -> None:
        """Use more bits for places that overflow, and write all markings again."""
        control = self._crew[0].control
        row = self._stack[0][control[DEPTH] - 1] if self.is_depth_first else control[NEXT]
        before = self.layout.unpack(self._storage.markings.store[row])
        store, old, tables = self._storage.markings.store, self.layout, self._net_tables
        self.layout = old.widened(old.overflowing(self.net, before))
        self._prepare()
        new = self._net_tables

        def write(target: Int64Array) -> None:
            count = int(control[COUNT])
            repack(store, target, count, tables.word, tables.shift, tables.mask, new.word, new.shift)

        if self._storage.exchange(self.layout.words, [control], self._shape, write):
            control[HAS_OVERFLOW] = 0
        else:
            self.reason, self.layout = "memory", old
            self._prepare()

    # figures

    def _sum(self, entry: int) -> int:
        return sum(int(notes.control[entry]) for notes in self._crew)

    @property
    def markings(self) -> int:
        """Number of visited markings."""
        return self._sum(COUNT)

    @property
    def expanded(self) -> int:
        """Number of markings whose successors were computed."""
        return self._sum(EXPANDED)

    @property
    def arcs(self) -> int:
        """Number of firings."""
        return self._sum(ARCS)

    @property
    def deadlocks(self) -> int:
        """Number of visited deadlocks."""
        return self._sum(DEADLOCKS)

    @property
    def memory(self) -> int:
        """Bytes touched by markings and tables."""
        return self.markings * self._storage.row_bytes + self._storage.table_bytes

    def enabled_somewhere(self) -> NDArray[np.bool_]:
        """For each transition, whether it was enabled in some marking."""
        return members(self._order, [notes.ever for notes in self._crew])

    def count_marked(self, place: int) -> int:
        """Return the number of markings in which a place has tokens."""
        return sum(len(rows) for rows in self.marked(place, []))

    def marked(self, place: int, wanted: Sequence[int]) -> Iterator[Int64Array]:
        """Yield the tokens of some places in the markings in which a place is marked, one marking per row."""
        store, rows = self._storage.markings.store, self._storage.markings.rows
        for me, notes in enumerate(self._crew):
            first, last = me * rows, me * rows + int(notes.control[COUNT])
            for start in range(first, last, _ROWS_AT_ONCE):
                part = store[start : min(last, start + _ROWS_AT_ONCE)]
                part = part[tokens_of(self.layout, part, place) > 0]
                columns = [tokens_of(self.layout, part, each) for each in wanted]
                yield np.array(columns, dtype=np.int64).reshape(len(wanted), len(part)).T

    def largest(self) -> tuple[tuple[int, ...], int]:
        """Return the largest number of tokens of each place, and of all places together, so far."""
        markings = self._storage.markings
        parts = [(me * markings.rows, int(notes.control[COUNT])) for me, notes in enumerate(self._crew)]
        return largest_tokens(self.layout, self._net_tables, markings.store, parts)
