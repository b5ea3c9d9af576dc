"""The search through the state classes of a time Petri net: tables, rounds, limits."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.answers.budget import UNLIMITED, Budget, Progress
from dineros.analysis.explicit.lazy_arrays import lazy_zeros
from dineros.analysis.nets.compiled import Int64Array
from dineros.analysis.nets.memory import DEFAULT_SHARE, free_memory, mappable_memory
from dineros.analysis.timed.classes import ClassGraph, Kind
from dineros.analysis.timed.kernels import exploration as kernels
from dineros.analysis.timed.kernels.markings import (
    CLASSES,
    CONTROL_SIZE,
    DEADLOCKS,
    EDGES,
    MARKINGS,
    MOST_CLOCKS,
    find_markings_again,
)
from dineros.analysis.timed.kernels.records import decode, find_classes_again
from dineros.analysis.timed.kernels.successors import (
    DONE,
    GOES_ON,
    TOO_MANY_TOKENS,
    WANTS_BATCH,
    WANTS_CLOCKS,
    WANTS_ROOM,
    WANTS_TABLE,
)
from dineros.analysis.timed.nets import UNBOUNDED, TimedNet
from dineros.analysis.timed.tables import Known, Work, batch_for, net_tables, work_for
from dineros.analysis.timed.threads.rounds import How, Rounds
from dineros.metamodel.errors import DinerosError

FIRST_TABLE = 1 << 16
"""Entries of the tables that find markings and classes again."""
FIRST_SLICE, LARGEST_SLICE = 1 << 8, 1 << 22
CALL_SECONDS = 0.1
LEAST_FOR_THREADS = 20_000
ALONE = 1 << 10
"""Classes that one thread expands before several are tried again."""
FIRST_CLOCKS = 16
FIRST_ITEMS, FIRST_WORDS = 1 << 13, 1 << 18
"""Room for what follows a batch of classes: records, and their elements. It takes memory as it fills."""
MAPPED_SHARE = 0.4
"""Share of the address space left that all tables together may map."""


def next_slice(size: int, began: float, largest: int) -> int:
    """Return how much the next call of a kernel does, so that it takes about `CALL_SECONDS`."""
    factor = CALL_SECONDS / max(time.perf_counter() - began, 1e-6)
    return int(max(1, min(largest, size * min(4.0, max(0.25, factor)))))


def limit_hit(budget: Budget, classes: int, memory_bytes: int) -> str | None:
    """Report the progress of a search; return the limit that it has hit."""
    if budget.progress is not None:
        budget.progress(Progress("states", classes, memory_bytes))
    if budget.is_over:
        return "time"
    if memory_bytes > budget.memory:
        return "memory"
    return "states" if budget.states is not None and classes >= budget.states else None


class ClassSearch:
    """A search through the state classes of a net; `run` goes through with it.

    Parameters
    ----------
    net, kind, budget
        The net, which classes, and limits; a share of the free memory unless one is given.
    keeps_edges : bool
        Whether edges are kept, not only counted.
    keeps_parents : bool
        Whether each class remembers from where it was first reached.
    is_breadth_first : bool
        Whether classes are expanded in the order in which they are found, so that the ways to them are short.
        By equality it is always so; by inclusion the other order replaces fewer classes.
    workers : int or None
        Number of threads that expand classes compared by equality; None: one for each processor. What is
        found does not depend on it.
    least_for_threads : int
        Number of classes from which on they work together.

    Attributes
    ----------
    tables, known
        The net, and all that was found, as kernels read them.
    bits, top, number_type
        How bounds are stored: bits of an element, the element that stands for no bound, the type.
    """

    def __init__(
        self,
        net: TimedNet,
        kind: Kind = "W",
        budget: Budget = UNLIMITED,
        *,
        keeps_edges: bool = False,
        keeps_parents: bool = False,
        is_breadth_first: bool = False,
        workers: int | None = None,
        least_for_threads: int = LEAST_FOR_THREADS,
    ) -> None:
        self.is_strong, self.by_inclusion = kind in "SE", kind in "ME"
        if net.has_priorities and not self.is_strong:
            raise DinerosError(
                f"classes {kind} do not support priorities, which the net has", hint="S and E support them"
            )
        self.net, self.kind = net, kind
        self.reason: str | None = None
        self.is_done = False
        self._has_begun = self._is_cut_short = False
        if budget.memory_bytes is None:
            budget = budget.share(most_bytes=int(free_memory() * DEFAULT_SHARE))
        self.budget = budget.begun()
        self._keeps_edges = keeps_edges or self.by_inclusion
        self._is_stack = self.by_inclusion and not is_breadth_first
        self.tables = net_tables(net)
        largest = int(
            max((abs(b) for b in (*self.tables.lower, *self.tables.upper) if b != UNBOUNDED), default=1)
        )
        self.number_type, self.bits = next(
            (kind_of, bits) for kind_of, bits in ((np.int32, 31), (np.int64, 62)) if largest + 1 < 1 << bits
        )
        self.top = (1 << self.bits) - 1
        self.known = self._room(keeps_parents)
        self._items, self._words = FIRST_ITEMS, FIRST_WORDS
        self._batch = batch_for(kernels.BATCH, self._items, self._words)
        self._work = self._matrices(FIRST_CLOCKS)
        self._rounds: Rounds | None = None
        self._least_for_threads = least_for_threads
        workers = self.budget.workers if workers is None else workers
        if workers > 1 and not self.by_inclusion:  # by inclusion, a class may replace those before it
            how = How(self.is_strong, self.bits, self.top)
            self._rounds = Rounds(
                workers, least_for_threads, self.tables, how, self._with_larger_tables, self._matrices
            )

    def _room(self, keeps_parents: bool) -> Known:
        """Map the tables; they take memory as they fill."""
        places, transitions = len(self.net.untimed.places), len(self.net.untimed.transitions)
        mapped = min(self.budget.memory, int(mappable_memory() * MAPPED_SHARE) // 16)
        rows = max(mapped // 8, 1 << 12)
        classes = max(mapped // (8 * 4), 1 << 12)
        edges = rows if self._keeps_edges else 0
        linked = classes if self.by_inclusion else 0
        marking_rows = max(mapped // (4 * max(places, 1)), 1 << 10)
        return Known(
            control=np.zeros(CONTROL_SIZE, dtype=np.int64),
            markings=lazy_zeros(marking_rows * places // 2 + 1)
            .view(np.int32)[: marking_rows * places]
            .reshape(marking_rows, places),
            marking_table=np.zeros(FIRST_TABLE, dtype=np.int64),
            enabled_start=lazy_zeros(min(marking_rows, classes) + 1),
            clocks=lazy_zeros(min(marking_rows, classes) + 1),
            enabled=lazy_zeros(rows + transitions),
            next_marking=lazy_zeros(rows + transitions),
            kept_start=lazy_zeros(rows + transitions),
            kept=lazy_zeros(rows // 2 + transitions).view(np.int32),
            class_marking=lazy_zeros(classes),
            record_start=lazy_zeros(classes + 1),
            codes=lazy_zeros(rows).view(self.number_type),
            class_table=np.zeros(FIRST_TABLE, dtype=np.int64),
            parent=lazy_zeros(classes if keeps_parents else 0),
            via=lazy_zeros(classes if keeps_parents else 0),
            edge_target=lazy_zeros(edges),
            edge_label=lazy_zeros(edges),
            edge_first=lazy_zeros(classes if self._keeps_edges else 0),
            edge_last=lazy_zeros(classes if self._keeps_edges else 0),
            first_class=lazy_zeros(min(marking_rows, classes) + 1),
            next_class=lazy_zeros(linked),
            replaced_by=lazy_zeros(linked),
            todo=lazy_zeros(linked),
        )

    def _matrices(self, clocks: int) -> Work:
        """Make room for matrices with this number of clocks."""
        uppers = self.tables.upper[self.tables.has_clock]
        depth = min(clocks, int((uppers == UNBOUNDED).sum())) if self.is_strong else 0
        return work_for(self.net.untimed.initial, clocks, depth)

    def allow(self, seconds: Budget) -> bool:
        """Give a search whose time ran out more of it; return whether `run` can continue it."""
        if self.reason != "time" or self._is_cut_short:
            return False
        self.budget = replace(seconds.begun(), memory_bytes=self.budget.memory_bytes)
        self.reason = None
        return True

    def run(self, is_met: Callable[[], bool] | None = None) -> None:
        """Search until all is seen, a goal is met, or a limit is hit.

        Parameters
        ----------
        is_met
            Called now and then; the search ends, without a reason, once it returns true.
        """
        self.budget.stage("state classes")
        size = FIRST_SLICE
        try:
            while self.reason is None:
                if not self._has_begun:
                    status = self._begin()
                    self._has_begun = status == DONE
                    self.known.control[EDGES] = 0  # no edge leads to the initial class
                else:
                    began = time.perf_counter()
                    status = self._explore(self._slice(size))
                    if status == DONE:
                        self.is_done = not self._has_too_many()
                        self.reason = None if self.is_done else "states"
                        return
                    if status == GOES_ON:
                        size = next_slice(size, began, LARGEST_SLICE)
                limit = self._answer(status)
                self.reason = limit or limit_hit(self.budget, self.classes, self.memory_bytes)
                if is_met is not None and is_met():
                    return
        except KeyboardInterrupt:  # who watches over the time asks a search to end in this way, too
            self.reason = "time" if self.budget.is_over else "interrupted"
            self._is_cut_short = True  # its tables may be half-written
        except MemoryError:
            self.reason = "memory"
        finally:
            if self._rounds is not None:
                self._rounds.close()

    def _begin(self) -> int:
        """Store the initial class; what is lacking."""
        tables, known, work, batch = self.tables, self.known, self._work, self._batch
        how = (self.is_strong, self.by_inclusion, self.bits, self.top)
        return int(kernels.begin(tables, known, work, batch, *how))

    def _explore(self, most: int) -> int:
        """Expand a limited number of classes; return why the expansion ended."""
        room = (self.tables, self.known, self._work, self._batch, self.is_strong)
        how = (self.bits, self.top, most)
        if self.by_inclusion:
            return int(kernels.explore_by_inclusion(*room, self._is_stack, *how))
        if self._rounds is not None and self.classes >= self._least_for_threads:
            if self._rounds.explore(self.known, self._work, self._batch, most, CALL_SECONDS):
                return GOES_ON
            how = (self.bits, self.top, min(most, ALONE))
        return int(kernels.explore(*room, self._keeps_edges, *how))

    def _with_larger_tables(self) -> Known:
        self.enlarge_tables(always=True)
        return self.known

    def _answer(self, status: int) -> str | None:
        """Give a kernel what it lacks; return why the search ends if that is not possible."""
        if status == WANTS_TABLE:
            self.enlarge_tables()
        elif status == WANTS_BATCH:
            self._items, self._words = 2 * self._items, 2 * self._words
            self._batch = batch_for(kernels.BATCH, self._items, self._words)
        elif status == WANTS_CLOCKS:
            most = int(self.known.control[MOST_CLOCKS])
            self._work = self._matrices(max(most, 2 * (len(self._work.low) - 1)))
        return {WANTS_ROOM: "memory", TOO_MANY_TOKENS: "tokens"}.get(status)

    def _has_too_many(self) -> bool:
        return self.budget.states is not None and self.classes > self.budget.states

    def _slice(self, size: int) -> int:
        """Return how many classes are expanded in one call: no more than there may be."""
        left = size if self.budget.states is None else self.budget.states - self.classes
        return max(1, min(size, left))

    def enlarge_tables(self, always: bool = False) -> None:
        """Give markings and classes larger tables where theirs fill up, or always."""
        known = self.known
        markings, classes = (
            int(known.control[what]) + len(self.net.untimed.transitions) for what in (MARKINGS, CLASSES)
        )
        if always or 2 * markings > known.marking_table.size:
            known = known._replace(marking_table=lazy_zeros(2 * known.marking_table.size))
            find_markings_again(known)
        if always or 2 * classes > known.class_table.size:
            known = known._replace(
                class_table=lazy_zeros((8 if classes < 1 << 22 else 2) * known.class_table.size)
            )
            find_classes_again(known)
        self.known = known

    @property
    def memory_bytes(self) -> int:
        """Bytes of the tables that are filled."""
        known, control = self.known, self.known.control
        markings, enabled, kept, classes, codes, edges = (int(n) for n in control[: EDGES + 1])
        size: int = (
            markings * (4 * known.markings.shape[1] + 24)
            + enabled * 24
            + kept * 4
            + classes * (16 + 16 * bool(known.parent.size) + 16 * self._keeps_edges + 24 * self.by_inclusion)
            + codes * known.codes.itemsize
            + edges * 16 * self._keeps_edges
            + known.marking_table.nbytes
            + known.class_table.nbytes
        )
        return size

    def markings(self, first: int = 0, end: int | None = None) -> Int64Array:
        """Return the markings found, from a row on, up to another one, places in the order of the net."""
        end = int(self.known.control[MARKINGS]) if end is None else end
        found: Int64Array = self.known.markings[first:end].astype(np.int64)
        return found

    def dead(self) -> NDArray[np.bool_]:
        """Return by class whether nothing can fire there, if edges are kept."""
        known = self.known
        nothing: NDArray[np.bool_] = known.edge_first[: self.classes] == known.edge_last[: self.classes]
        if self.by_inclusion:
            nothing &= known.replaced_by[: self.classes] == kernels.ALIVE
        return nothing

    @property
    def edges(self) -> int:
        """Number of edges found."""
        return int(self.known.control[EDGES])

    @property
    def classes(self) -> int:
        """Number of classes found, those that were replaced by larger ones included."""
        return int(self.known.control[CLASSES])

    @property
    def marking_of(self) -> Int64Array:
        """By class its marking; a view that ends with the classes found so far."""
        found: Int64Array = self.known.class_marking[: self.classes]
        return found

    def trace(self, number: int) -> tuple[int, ...]:
        """Return the firings by which a class was first reached, if parents are kept."""
        found: list[int] = []
        while self.known.parent[number] >= 0:
            found.append(int(self.known.via[number]))
            number = int(self.known.parent[number])
        return tuple(reversed(found))

    def domain(self, number: int) -> tuple[list[int], Int64Array]:
        """Return the transitions whose clocks run in a class, and its matrix of bounds, in normal form.

        Row and column 0 of the matrix stand for zero; the others follow the transitions.
        """
        known, row = self.known, int(self.marking_of[number])
        clocks, first = int(known.clocks[row]), int(known.enabled_start[row])
        matrix = np.full((clocks + 1, clocks + 1), UNBOUNDED, dtype=np.int64)
        decode(known.codes, known.record_start[number], clocks, matrix, self.bits, self.top)
        return known.enabled[first : first + clocks].tolist(), matrix

    def first_edge(self, transitions: Sequence[int]) -> tuple[int, int] | None:
        """Return the class and the transition of the first edge that fires one of some transitions."""
        known = self.known
        edges = np.flatnonzero(np.isin(known.edge_label[: self.edges], transitions))
        if not len(edges):
            return None
        edge, classes = int(edges[0]), self.classes
        holds = (known.edge_first[:classes] <= edge) & (edge < known.edge_last[:classes])
        return int(np.flatnonzero(holds)[0]), int(known.edge_label[edge])

    def first_sources(self) -> dict[int, int]:
        """Return by transition that fires the class in which it was first seen to fire, if edges are kept."""
        known = self.known
        labels, edges = np.unique(known.edge_label[: self.edges], return_index=True)
        classes = np.flatnonzero(known.edge_last[: self.classes] > known.edge_first[: self.classes])
        classes = classes[np.argsort(known.edge_first[classes], kind="stable")]
        at = np.searchsorted(known.edge_first[classes], edges, side="right") - 1
        return dict(zip(labels.tolist(), classes[at].tolist(), strict=True))

    def arrays(self) -> tuple[Int64Array, Int64Array, Int64Array, Int64Array]:
        """Return the graph, if edges are kept and classes are compared by equality; class 0 is initial.

        Returns
        -------
        marking_of : int64 array, shape (classes,)
            By class its marking.
        source, target, label : int64 arrays, shape (edges,)
            By edge, sources ascending: its classes and its transition.
        """
        known, classes = self.known, self.classes
        leaving = known.edge_last[:classes] - known.edge_first[:classes]
        return (
            known.class_marking[:classes].copy(),
            np.repeat(np.arange(classes), leaving),
            known.edge_target[: self.edges].copy(),
            known.edge_label[: self.edges].copy(),
        )

    def graph(self) -> ClassGraph:
        """Return what was found."""
        control = self.known.control
        classes, edges, deadlocks = int(control[CLASSES]), int(control[EDGES]), int(control[DEADLOCKS])
        markings = int(control[MARKINGS])
        if self.by_inclusion:
            classes, edges, deadlocks = self._alive()
        return ClassGraph(
            self.kind,
            classes,
            edges,
            markings,
            deadlocks,
            self.reason is None,
            self.reason,
            self.memory_bytes,
        )

    def kept(self) -> Int64Array:
        """Return by class the one that holds it, if they are compared by inclusion: itself if it is kept."""
        final: Int64Array = self.known.replaced_by[: self.classes].copy()
        alive = final == kernels.ALIVE
        final[alive] = np.flatnonzero(alive)
        while not alive[final].all():
            final = final[final]
        return final

    def _alive(self) -> tuple[int, int, int]:
        known, final = self.known, self.kept()
        alive = final == np.arange(len(final))
        edges = deadlocks = 0
        transitions = len(self.net.untimed.transitions)
        for number in np.flatnonzero(alive):
            part = slice(int(known.edge_first[number]), int(known.edge_last[number]))
            keys = final[known.edge_target[part]] * transitions + known.edge_label[part]
            edges += len(np.unique(keys))
            deadlocks += part.start == part.stop
        return int(alive.sum()), edges, deadlocks
