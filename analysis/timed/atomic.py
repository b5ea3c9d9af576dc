"""Atomic state classes: strong classes, cut until all states of a class have the same futures.

In an atomic class, each state has a successor in each class that an edge leads to. So all states of a class
satisfy the same formulas of branching time. The cuts start from the largest strong classes, and a class is
cut by the bounds of the states that lead into the next one. Classes with the same states are one class.

References
----------
B. Berthomieu, F. Vernadat, *State class constructions for branching analysis of time Petri nets*, TACAS
2003, LNCS 2619. R. Paige, R. E. Tarjan, *Three partition refinement algorithms*, SIAM J. Comput. 16(6), 1987.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.explicit.lazy_arrays import lazy_zeros
from dineros.analysis.nets.compiled import Int64Array
from dineros.analysis.nets.memory import mappable_memory
from dineros.analysis.timed.classes import ClassGraph
from dineros.analysis.timed.kernels import refinement as kernels
from dineros.analysis.timed.kernels.edges import (
    ALIVE,
    CELLS,
    CLASSES,
    CONTROL_SIZE,
    EDGES,
    FREE,
    INITIAL,
    LIVING_EDGES,
    NONE,
    STABLE,
)
from dineros.analysis.timed.kernels.markings import MARKINGS, MOST_CLOCKS
from dineros.analysis.timed.kernels.partitions import find_again
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.search import MAPPED_SHARE, ClassSearch, limit_hit, next_slice
from dineros.analysis.timed.tables import Atoms, CuttingRoom

FIRST_TABLE = 1 << 12
FIRST_SLICE, LARGEST_SLICE = 1 << 4, 1 << 20


class AtomicSearch:
    """The atomic classes of a net; `run` finds them.

    Parameters
    ----------
    budget : Budget
        Limits; a share of the free memory unless one is given.
    """

    def __init__(self, net: TimedNet, budget: Budget = UNLIMITED) -> None:
        self.net = net
        self._strong = ClassSearch(net, "E", budget)
        self._budget = self._strong.budget
        self.reason: str | None = None
        self._atoms: Atoms | None = None

    def run(self) -> None:
        """Find the strong classes, and cut them; `reason` is the limit that ended it, if any did."""
        self._strong.run()
        self.reason = self._strong.reason
        if self.reason is not None:
            return
        try:
            self._begin()
            self._cut()
        except KeyboardInterrupt:
            self.reason = "time" if self._budget.is_over else "interrupted"  # it was asked to end
        except MemoryError:
            self.reason = "memory"

    def _begin(self) -> None:
        """Map the tables, which take memory as they fill, and take over the strong classes."""
        strong, final = self._strong, self._strong.kept()
        size = int(strong.known.control[MOST_CLOCKS]) + 1
        mapped = min(self._budget.memory, int(mappable_memory() * MAPPED_SHARE) // 16)
        classes, edges = max(mapped // 64, 1 << 16), max(mapped // 32, 1 << 16)

        def numbers(length: int) -> Any:
            return lazy_zeros(length // 2 + 1).view(np.int32)[:length]

        def square() -> Any:
            return np.zeros((size, size), dtype=np.int64)

        self._atoms = atoms = Atoms(
            control=np.zeros(CONTROL_SIZE, dtype=np.int64),
            top=np.array([strong.top], dtype=np.int64),
            marking=numbers(classes),
            is_alive=numbers(classes),
            is_queued=numbers(classes),
            cell=lazy_zeros(classes),
            code=lazy_zeros(classes),
            next_class=numbers(classes),
            first_out=numbers(classes),
            first_in=numbers(classes),
            table=np.full(self._table_size(len(final)), NONE, dtype=np.int32),
            bounds=lazy_zeros(max(mapped // 8, 1 << 16)).view(strong.number_type),
            source=numbers(edges),
            at=numbers(edges),
            target=numbers(edges),
            next_out=numbers(edges),
            last_out=numbers(edges),
            next_in=numbers(edges),
            last_in=numbers(edges),
            state=numbers(edges),
            queue=numbers(classes),
        )
        atoms.control[FREE] = NONE
        self._room = CuttingRoom(
            matrix=square(),
            before=square(),
            room=square(),
            other=square(),
            lead=square(),
            facets=np.zeros((size * size, 2), dtype=np.int64),
            pieces=np.zeros(size * size, dtype=np.int64),
            numbers=np.zeros(len(final), dtype=np.int64),
            edges=lazy_zeros(edges),
            incoming=lazy_zeros(edges),
        )
        kernels.begin(strong.known, atoms, self._room, final, strong.bits, strong.top)

    @staticmethod
    def _table_size(classes: int) -> int:
        size = FIRST_TABLE
        while size < 2 * classes:
            size *= 2
        return size

    def _cut(self) -> None:
        self._budget.stage("atomic classes")
        strong, size = self._strong, FIRST_SLICE
        while self.reason is None:
            assert self._atoms is not None
            began = time.perf_counter()
            status = kernels.refine(strong.tables, strong.known, self._atoms, self._room, size)
            if status == kernels.REFINED:
                return
            if status == kernels.GOES_ON:
                size = next_slice(size, began, LARGEST_SLICE)
            elif status == kernels.WANTS_TABLE:
                self.enlarge_table()
            elif status == kernels.WANTS_ROOM:
                self.reason = "memory"
            self.reason = self.reason or limit_hit(self._budget, self.classes, self.memory_bytes)

    def enlarge_table(self) -> None:
        """Give the classes a larger table."""
        assert self._atoms is not None
        table = np.full(self._table_size(2 * int(self._atoms.control[CLASSES])), NONE, dtype=np.int32)
        self._atoms = self._atoms._replace(table=table)
        find_again(self._atoms)

    @property
    def classes(self) -> int:
        """Number of classes so far."""
        return self._strong.classes if self._atoms is None else int(self._atoms.control[ALIVE])

    @property
    def edges(self) -> int:
        """Number of edges so far."""
        return self._strong.edges if self._atoms is None else int(self._atoms.control[LIVING_EDGES])

    @property
    def memory_bytes(self) -> int:
        """Bytes of the tables that are filled."""
        if self._atoms is None:
            return self._strong.memory_bytes
        control = self._atoms.control
        filled: int = (
            int(control[CLASSES]) * 44
            + int(control[CELLS]) * self._atoms.bounds.itemsize
            + int(control[EDGES]) * 32
            + self._atoms.table.nbytes
        )
        return self._strong.memory_bytes + filled

    def markings(self) -> Int64Array:
        """Return the markings found, one a row, places in the order of the net."""
        return self._strong.markings()

    def arrays(self) -> tuple[Int64Array, Int64Array, Int64Array, Int64Array]:
        """Return the graph, which must be complete; class 0 holds the initial state.

        Returns
        -------
        marking_of : int64 array, shape (classes,)
            By class its marking.
        source, target, label : int64 arrays, shape (edges,)
            By edge, sources ascending: its classes and its transition.
        """
        atoms = self._atoms
        assert atoms is not None and self.reason is None, "the graph must be complete"
        alive = np.flatnonzero(atoms.is_alive[: atoms.control[CLASSES]])
        initial = int(atoms.control[INITIAL])
        order = np.concatenate([[initial], alive[alive != initial]])
        number = np.zeros(int(atoms.control[CLASSES]), dtype=np.int64)
        number[order] = np.arange(len(order))
        edges = np.flatnonzero(atoms.state[: atoms.control[EDGES]] == STABLE)
        edges = edges[np.argsort(number[atoms.source[edges]], kind="stable")]
        known, source = self._strong.known, atoms.source[edges]
        return (
            atoms.marking[order].astype(np.int64),
            number[source],
            number[atoms.target[edges]],
            known.enabled[atoms.at[edges]].astype(np.int64),
        )

    def graph(self) -> ClassGraph:
        """Return the figures of the search."""
        markings = int(self._strong.known.control[MARKINGS])
        if self._atoms is None:
            return ClassGraph("A", self.classes, 0, markings, 0, False, self.reason, self.memory_bytes)
        atoms = self._atoms
        classes = int(atoms.control[CLASSES])
        dead = (atoms.is_alive[:classes] != 0) & (atoms.first_out[:classes] == NONE)
        return ClassGraph(
            "A",
            self.classes,
            int(atoms.control[LIVING_EDGES]),
            markings,
            int(dead.sum()),
            self.reason is None,
            self.reason,
            self.memory_bytes,
        )
