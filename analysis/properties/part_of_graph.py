"""CTL on a part of the reachability graph, with three truth values.

The markings found first are stored with their successors; the successors of the last ones are unknown. A set
of states is a pair: states that are certainly in it, and states that may be in it. If all markings are
stored, both are equal.

References
----------
G. Bruns, P. Godefroid, *Model checking partial state spaces with 3-valued temporal logics*, CAV 1999, LNCS
1633.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.explicit.layout import Layout
from dineros.analysis.logic.ctl.state_sets import Run
from dineros.analysis.logic.graphs.predicates import Flags, Int64Array, any_enabled, holds
from dineros.analysis.logic.graphs.stored import Arcs, Exploration
from dineros.analysis.logic.language.atoms import Condition
from dineros.analysis.logic.language.syntax import Atom, Formula
from dineros.analysis.nets.compiled import CompiledNet

#: Maximum size of stored values of atoms, in bytes.
MOST_FLAGS = 1 << 28
#: A set of states: certainly in it, possibly in it.
Pair = tuple[Flags, Flags]


class PartOfGraph(Exploration):
    """Markings of a net with their successors, breadth first, as far as the budget allows.

    Parameters
    ----------
    budget : Budget
        Its limits end the search without an error; its clock runs.

    Attributes
    ----------
    expanded : int
        Number of first markings whose successors are stored; a deadlock is its own successor.
    layout : Layout
        The layout of markings, valid for the net from any reachable marking.

    Raises
    ------
    BudgetExceededError
        A place may have more tokens than fit into a word.
    """

    visits: ClassVar[int] = 20_000
    copies: ClassVar[int] = 2

    def __init__(self, net: CompiledNet, budget: Budget, cells: Layout | None = None) -> None:
        super().__init__(net, {}, budget, cells)
        self.is_complete = False
        with contextlib.suppress(BudgetExceededError, MemoryError):
            self.expand()
            self.is_complete = True
        self.size = self.product.states
        self.arcs = self._known_arcs()
        self.is_known = np.arange(self.size) < self.expanded
        self._layout = self.product.layout
        self.layout = self.product.cells
        self._home = {
            p: (k, at) for k, cell in enumerate(self._layout.cells) for at, p in enumerate(cell.places)
        }
        #: By word: of all markings, one after the other, so that a place is read in one go.
        self._words = np.ascontiguousarray(self.product.store.words[: self.size].T)
        del self.product, self.pointer, self.targets

    def _known_arcs(self) -> Arcs:
        known = int(self.pointer[self.expanded])
        pointer = np.full(self.size + 1, known, dtype=np.int64)
        pointer[: self.expanded + 1] = self.pointer[: self.expanded + 1]
        targets = self.targets[:known].copy()
        if targets.size and int(targets.max()) >= self.size:
            raise AssertionError("an arc leads out of the store")
        return Arcs.of(pointer, targets)

    def tokens(self, place: int) -> Int64Array:
        """Return the tokens of a place in each marking."""
        code, table = self._codes(place)
        return code if table is None else table[code]

    def at_least(self, place: int, weight: int) -> Flags:
        """Return the markings in which a place has at least this number of tokens."""
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
        """Return the markings in which no transition is enabled."""
        pointer, targets, *_ = self.arcs
        # A deadlock is its own only successor; so is a marking with only self-loops.
        alone = np.diff(pointer) == 1
        alone[alone] = targets[pointer[:-1][alone]] == np.flatnonzero(alone)
        some = np.flatnonzero(alone | ~self.is_known)
        result = np.zeros(self.size, dtype=np.bool_)
        result[some] = ~any_enabled(_Selected(self, some), range(len(self.net.transitions)))
        return result

    def with_loops(self) -> Arcs:
        """Return the arcs, with self-loops at states without known successors."""
        if self.is_complete:
            return self.arcs
        rest = np.arange(self.expanded, self.size, dtype=np.int32)
        pointer = self.arcs.pointer.copy()
        pointer[self.expanded :] = self.arcs.targets.size + np.arange(self.size - self.expanded + 1)
        return Arcs.of(pointer, np.concatenate([self.arcs.targets, rest]))


class _Selected:
    """Some markings of a part of a graph."""

    def __init__(self, graph: PartOfGraph, states: NDArray[np.int64]) -> None:
        self.net, self.size, self._graph, self._states = graph.net, len(states), graph, states

    def tokens(self, place: int) -> Int64Array:
        """Return the tokens of a place in each marking."""
        return self._graph.tokens(place)[self._states]

    def at_least(self, place: int, weight: int) -> Flags:
        """Return the markings in which a place has at least this number of tokens."""
        return self._graph.at_least(place, weight)[self._states]

    def deadlocks(self) -> Flags:
        """Return the markings in which no transition is enabled."""
        return self._graph.deadlocks()[self._states]


class PartialSets:
    """The `StateSets` of a part of a graph; see the module.

    Parameters
    ----------
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
        """Return the states in at least one of the sets."""
        return left[0] | right[0], left[1] | right[1]

    def some_next(self, states: Pair) -> Pair:
        """EX."""
        self._tell()
        arcs = self.graph.arcs
        return arcs.some_next(states[0]), arcs.some_next(states[1]) | ~self.graph.is_known

    def some_until(self, stay: Pair, goal: Pair) -> Pair:
        """EU."""
        self._tell()
        arcs, outside = self.graph.arcs, ~self.graph.is_known & stay[1]
        return arcs.some_until(stay[0], goal[0]), arcs.some_until(stay[1], goal[1] | outside)

    def some_globally(self, states: Pair) -> Pair:
        """EG."""
        self._tell()
        sure = self.graph.arcs.some_globally(states[0] & self.graph.is_known)
        return sure, self._loops.some_globally(states[1])

    def initially(self, states: Pair) -> bool:
        """Whether the initial state is certainly in a set."""
        return bool(states[0][0])

    def value(self, states: Pair) -> bool | None:
        """Whether the initial state is in a set; None: this is not known."""
        return True if states[0][0] else None if states[1][0] else False

    def path(self, path: Formula, found: Mapping[Formula, Pair]) -> Run:
        """Not supported: runs are not requested."""
        raise NotImplementedError

    def _exact(self, flags: Flags) -> Pair:
        return flags, flags
