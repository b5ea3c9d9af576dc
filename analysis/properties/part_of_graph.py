"""CTL on a part of the reachability graph, with three truth values.

The markings first found are stored with their successors; what lies behind the last of them is not known. A
set of states is a pair: those surely in it, and those that may be. Where all markings were stored, both are
the same.

References
----------
G. Bruns, P. Godefroid, *Model checking partial state spaces with 3-valued temporal logics*, CAV 1999, LNCS
1633.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.explicit.layout import Layout
from dineros.analysis.logic.automata.automaton import Automaton, Edge
from dineros.analysis.logic.ctl.state_sets import Run
from dineros.analysis.logic.graphs.product import Product
from dineros.analysis.logic.kernels.stored import (
    ARCS_FULL,
    COMPLETE,
    OVERFLOW,
    PAUSED,
    STORE_FULL,
    build,
    predecessors,
    some_globally,
    some_successor,
    some_until,
)
from dineros.analysis.logic.language.atoms import Condition
from dineros.analysis.logic.language.syntax import Atom, Formula
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.properties.predicates import Flags, Int64Array, any_enabled, holds

VISITS = 20_000
#: Bytes of what is kept of atoms.
MOST_FLAGS = 1 << 28
Number = TypeVar("Number", bound=np.generic)
#: A set of states: surely in it, perhaps in it.
Pair = tuple[Flags, Flags]


class PartOfGraph:
    """Markings of a net, breadth first, with their successors, as far as a budget goes.

    Parameters
    ----------
    net : CompiledNet
    budget : Budget
        Its limits end the search, not the object; its clock runs.
    cells : Layout, optional
        How to write markings, where that is known.

    Attributes
    ----------
    size : int
        Markings stored.
    expanded : int
        Of these, the first so many have their successors; a deadlock is its own.
    is_complete : bool
        Whether that is all.
    layout : Layout
        How markings are written; good for the net from any reachable marking on.

    Raises
    ------
    BudgetExceededError
        When a place may hold more tokens than fit into a word.
    """

    def __init__(self, net: CompiledNet, budget: Budget, cells: Layout | None = None) -> None:
        self.net = net
        everything = Automaton((), 0, 0, ((Edge(0, 0, 0, 0),),))
        self._product = Product(net, everything, [], (), (), budget, cells)
        self.pointer: Int64Array = np.zeros(len(self._product.store.words) + 1, dtype=np.int64)
        self.targets: NDArray[np.int32] = np.empty(1 << 14 | 2 * self._product.room, dtype=np.int32)
        self.expanded = 0
        self.is_complete = False
        with contextlib.suppress(BudgetExceededError, MemoryError):
            self._explore(budget)
        self.size = self._product.states
        self._index()
        self._layout = self._product.layout
        self.layout = self._product.cells
        self._home = {
            p: (k, at) for k, cell in enumerate(self._layout.cells) for at, p in enumerate(cell.places)
        }
        #: By word: of all markings, one after the other, so that a place is read in one go.
        self._words = np.ascontiguousarray(self._product.store.words[: self.size].T)
        del self._product

    def _explore(self, budget: Budget) -> None:
        product, status = self._product, PAUSED
        labels = np.empty(product.room, dtype=np.int32)
        while status != COMPLETE:
            status, self.expanded = build(
                product.tables,
                product.conditions,
                product.edges,
                product.store,
                product.scratch,
                self.pointer,
                self.targets,
                labels,
                self.expanded,
                VISITS,
            )
            others = self.pointer.nbytes + 2 * self.targets.nbytes
            if status in (PAUSED, STORE_FULL):
                budget.report(product.progress(product.memory_bytes + others))
            if status == STORE_FULL:
                product.grow(others)
                self.pointer = _longer(self.pointer, len(product.store.words) + 1)
            elif status == ARCS_FULL:
                budget.check_memory(product.memory_bytes + others + 4 * self.targets.nbytes)
                self.targets = _longer(self.targets, 2 * self.targets.size)
            elif status == OVERFLOW:
                product.widen(others)
        self.is_complete = True

    def _index(self) -> None:
        arcs = int(self.pointer[self.expanded])
        pointer = np.full(self.size + 1, arcs, dtype=np.int64)
        pointer[: self.expanded + 1] = self.pointer[: self.expanded + 1]
        self.pointer, self.targets = pointer, self.targets[:arcs].copy()
        if self.targets.size and int(self.targets.max()) >= self.size:
            raise AssertionError("an arc leads out of the store")
        self.back_pointer: Int64Array = np.zeros(self.size + 1, dtype=np.int64)
        self.sources: NDArray[np.int32] = np.empty(arcs, dtype=np.int32)
        predecessors(self.pointer, self.targets, self.back_pointer, self.sources)
        self.is_known = np.arange(self.size) < self.expanded

    def tokens(self, place: int) -> Int64Array:
        """Return the tokens of a place in each marking."""
        code, table = self._codes(place)
        return code if table is None else table[code]

    def at_least(self, place: int, weight: int) -> Flags:
        """Return in which markings a place holds so many tokens."""
        code, table = self._codes(place)
        flags: Flags = code >= weight if table is None else (table >= weight)[code]
        return flags

    def _codes(self, place: int) -> tuple[Int64Array, Int64Array | None]:
        """The codes of a place's cell in each marking, and the place's tokens by code; None: the codes."""
        k, at = self._home[place]
        cell = self._layout.cells[k]
        shifted = self._words[self._layout.word[k]] >> self._layout.shift[k]
        code: Int64Array = shifted & ((1 << cell.bits) - 1)
        return code, None if cell.values is None else cell.values[:, at]

    def deadlocks(self) -> Flags:
        """Return in which markings no transition is enabled."""
        states = np.arange(self.size)
        degree = np.diff(self.pointer)
        # A deadlock has itself as its only successor, but so has a marking that only loops leave.
        alone = degree == 1
        alone[alone] = self.targets[self.pointer[:-1][alone]] == states[alone]
        some = np.flatnonzero(alone | ~self.is_known)
        result = np.zeros(self.size, dtype=np.bool_)
        result[some] = ~any_enabled(_Selected(self, some), range(len(self.net.transitions)))
        return result

    def with_loops(self) -> tuple[Int64Array, NDArray[np.int32], Int64Array, NDArray[np.int32]]:
        """Return arcs and reversed arcs where states without known successors are their own."""
        if self.is_complete:
            return self.pointer, self.targets, self.back_pointer, self.sources
        rest = np.arange(self.expanded, self.size, dtype=np.int32)
        arcs = self.targets.size
        pointer = self.pointer.copy()
        pointer[self.expanded :] = arcs + np.arange(self.size - self.expanded + 1)
        targets = np.concatenate([self.targets, rest])
        back_pointer = np.zeros(self.size + 1, dtype=np.int64)
        sources = np.empty(targets.size, dtype=np.int32)
        predecessors(pointer, targets, back_pointer, sources)
        return pointer, targets, back_pointer, sources


class _Selected:
    """Some markings of a part of a graph."""

    def __init__(self, graph: PartOfGraph, states: NDArray[np.int64]) -> None:
        self.net, self.size, self._graph, self._states = graph.net, len(states), graph, states

    def tokens(self, place: int) -> Int64Array:
        """Return the tokens of a place in each marking."""
        return self._graph.tokens(place)[self._states]

    def at_least(self, place: int, weight: int) -> Flags:
        """Return in which markings a place holds so many tokens."""
        return self._graph.at_least(place, weight)[self._states]

    def deadlocks(self) -> Flags:
        """Return in which markings no transition is enabled."""
        return self._graph.deadlocks()[self._states]


class PartialSets:
    """The `StateSets` of a part of a graph; see the module.

    Parameters
    ----------
    graph : PartOfGraph
    conditions : mapping
        What atoms ask.
    tell : callable
        Called before each operation; an exception raised in it ends the work.
    """

    def __init__(
        self, graph: PartOfGraph, conditions: Mapping[Atom, Condition], tell: Callable[[], None]
    ) -> None:
        self.graph, self.conditions, self._tell = graph, conditions, tell
        self._loops = graph.with_loops()
        self._atoms: dict[Atom, Pair] = {}

    def constant(self, value: bool) -> Pair:
        """Return all states or none."""
        return self._exact(np.full(self.graph.size, value))

    def atom(self, atom: Atom) -> Pair:
        """Return the states in which an atom is true."""
        if atom not in self._atoms:
            self._tell()
            if len(self._atoms) * self.graph.size > MOST_FLAGS:
                self._atoms.clear()
            self._atoms[atom] = self._exact(holds(self.graph, self.conditions[atom]))
        return self._atoms[atom]

    def complement(self, states: Pair) -> Pair:
        """Return the other states."""
        sure, possible = states
        return self._exact(~sure) if sure is possible else (~possible, ~sure)

    def intersection(self, left: Pair, right: Pair) -> Pair:
        """Return the states in both sets."""
        return left[0] & right[0], left[1] & right[1]

    def union(self, left: Pair, right: Pair) -> Pair:
        """Return the states in one of the sets."""
        return left[0] | right[0], left[1] | right[1]

    def some_next(self, states: Pair) -> Pair:
        """EX."""
        self._tell()
        return self._next(states[0]), self._next(states[1]) | ~self.graph.is_known

    def some_until(self, stay: Pair, goal: Pair) -> Pair:
        """EU."""
        self._tell()
        outside = ~self.graph.is_known & stay[1]
        return self._until(stay[0], goal[0]), self._until(stay[1], goal[1] | outside)

    def some_globally(self, states: Pair) -> Pair:
        """EG."""
        self._tell()
        graph = self.graph
        sure = states[0] & graph.is_known
        possible = states[1].copy()
        queue = np.empty(graph.size, dtype=np.int32)
        some_globally(graph.pointer, graph.targets, graph.back_pointer, graph.sources, sure, queue)
        some_globally(*self._loops, possible, queue)
        return sure, possible

    def initially(self, states: Pair) -> bool:
        """Whether the initial state is surely in a set."""
        return bool(states[0][0])

    def value(self, states: Pair) -> bool | None:
        """Whether the initial state is in a set; None where that is not known."""
        return True if states[0][0] else None if states[1][0] else False

    def path(self, path: Formula, found: Mapping[Formula, Pair]) -> Run:
        """Runs are not asked for."""
        raise NotImplementedError

    def _exact(self, flags: Flags) -> Pair:
        return flags, flags

    def _next(self, inside: Flags) -> Flags:
        result = np.zeros_like(inside)
        some_successor(self.graph.pointer, self.graph.targets, inside, result)
        return result

    def _until(self, stay: Flags, goal: Flags) -> Flags:
        result = goal.copy()
        queue = np.empty(result.size, dtype=np.int32)
        some_until(self.graph.back_pointer, self.graph.sources, stay, result, queue)
        return result


def _longer(array: NDArray[Number], size: int) -> NDArray[Number]:
    longer = np.zeros(size, dtype=array.dtype)
    longer[: array.size] = array
    return longer
