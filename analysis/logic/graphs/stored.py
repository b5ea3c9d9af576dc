"""Stored reachability graphs: the states of a net with their successors, for questions about all states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import ClassVar, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.answers.budget import Budget
from dineros.analysis.explicit.layout import Layout
from dineros.analysis.logic.automata.automaton import Automaton, Edge
from dineros.analysis.logic.graphs.product import Product
from dineros.analysis.logic.kernels import stored as kernels
from dineros.analysis.logic.kernels.product import BITS
from dineros.analysis.logic.kernels.stored import ARCS_FULL, COMPLETE, OVERFLOW, PAUSED, STORE_FULL
from dineros.analysis.logic.language.atoms import Condition
from dineros.analysis.logic.language.syntax import Atom
from dineros.analysis.nets.compiled import CompiledNet

Int32Array = NDArray[np.int32]
Int64Array = NDArray[np.int64]
StateSet = NDArray[np.bool_]
Number = TypeVar("Number", bound=np.generic)


class Arcs(NamedTuple):
    """The arcs between states that are numbered from 0 on, and the same reversed.

    Attributes
    ----------
    pointer : int64 array, shape (states + 1,)
    targets : int32 array
        The successors of state s are ``targets[pointer[s]:pointer[s + 1]]``.
    back_pointer, sources : int64 array, int32 array
        The same for predecessors.
    """

    pointer: Int64Array
    targets: Int32Array
    back_pointer: Int64Array
    sources: Int32Array

    @classmethod
    def of(cls, pointer: Int64Array, targets: Int32Array) -> Arcs:
        """Reverse arcs."""
        arcs = cls(pointer, targets, np.zeros_like(pointer), np.empty_like(targets))
        kernels.predecessors(*arcs)
        return arcs

    def tails(self) -> Int32Array:
        """Return the source state of each arc."""
        return np.repeat(np.arange(self.pointer.size - 1, dtype=np.int32), np.diff(self.pointer))

    def some_next(self, states: StateSet) -> StateSet:
        """EX: return the states with a successor in a set."""
        result = np.zeros_like(states)
        kernels.some_successor(self.pointer, self.targets, states, result)
        return result

    def some_until(self, stay: StateSet, goal: StateSet) -> StateSet:
        """EU: return the states from which some run stays in one set until it is in the other."""
        result = goal.copy()
        queue = np.empty(result.size, dtype=np.int32)
        kernels.some_until(self.back_pointer, self.sources, stay, result, queue)
        return result

    def some_globally(self, states: StateSet) -> StateSet:
        """EG: return the states from which some run never leaves a set."""
        result = states.copy()
        kernels.some_globally(*self, result, np.empty(result.size, dtype=np.int32))
        return result

    def path(self, start: int, allowed: StateSet, goal: StateSet) -> list[int]:
        """Return the states of a shortest non-empty path over allowed states to a goal, or []."""
        parents = np.full(allowed.size, -1, dtype=np.int32)
        queue = np.empty(allowed.size, dtype=np.int32)
        state, end = kernels.path_states(self.pointer, self.targets, start, allowed, goal, parents, queue)
        if end < 0:
            return []
        found = [end]
        while state != start:
            found.append(state)
            state = int(parents[state])
        return [int(state) for state in (*found, start)][::-1]


class Exploration:
    """Markings of a net, breadth first, with their successors; a deadlock is its own successor.

    Parameters
    ----------
    atoms : mapping of Atom to Condition
        Conditions that may be evaluated in each state.

    Attributes
    ----------
    expanded : int
        Number of states, from the first on, whose successors are stored.
    """

    #: Number of states expanded between checks of the clock.
    visits: ClassVar[int] = 100_000
    #: Number of tables of arcs that exist at the same time at the end.
    copies: ClassVar[int] = 1

    def __init__(
        self, net: CompiledNet, atoms: Mapping[Atom, Condition], budget: Budget, cells: Layout | None = None
    ) -> None:
        self.net, self.budget = net, budget
        # The product with an automaton that reads every word is the reachability graph.
        everything = Automaton(tuple(atoms), 0, 0, ((Edge(0, 0, 0, 0),),))
        self.product = Product(net, everything, list(atoms.values()), (), (), budget, cells)
        self.pointer: Int64Array = np.zeros(len(self.product.store.words) + 1, dtype=np.int64)
        self.targets: Int32Array = np.empty(1 << 14 | 2 * self.product.room, dtype=np.int32)
        self.expanded = 0

    def expand(self) -> None:
        """Find all states.

        Raises
        ------
        BudgetExceededError
            A limit was exceeded before.
        """
        product = self.product
        labels = np.empty(product.room, dtype=np.int32)
        status = PAUSED
        while status != COMPLETE:
            status, self.expanded = kernels.build(
                *product.parts, self.pointer, self.targets, labels, self.expanded, self.visits
            )
            arcs = self.copies * self.targets.nbytes
            others = self.pointer.nbytes + arcs
            if status in (PAUSED, STORE_FULL):
                self.budget.report(product.progress(product.memory_bytes + others))
            if status == STORE_FULL:
                product.grow(others)
                self.pointer = _lengthened(self.pointer, len(product.store.words) + 1)
            elif status == ARCS_FULL:
                self.budget.check_memory(product.memory_bytes + others + 2 * arcs)
                self.targets = _lengthened(self.targets, 2 * self.targets.size)
            elif status == OVERFLOW:
                product.widen(others)


class StateGraph(Exploration):
    """All reachable markings of a net, each with its successors.

    Parameters
    ----------
    net : CompiledNet
    atoms : mapping of Atom to Condition
        Conditions evaluated in every state.
    budget : Budget

    Attributes
    ----------
    arcs : Arcs
        Available after the exploration.
    """

    arcs: Arcs

    def explore(self) -> None:
        """Find all states, and evaluate the atoms.

        Raises
        ------
        BudgetExceededError
            A limit was exceeded before the graph was complete.
        """
        self.expand()
        size, arcs = self.size, int(self.pointer[self.size])
        # Predecessors, letters, and memory for the sets of a few subformulas.
        words = self.product.scratch.letter.size
        self.budget.check_memory(self.memory_bytes + 4 * arcs + (32 + 8 * words) * size)
        self.arcs = Arcs.of(self.pointer[: size + 1], self.targets[:arcs])
        self.letters: Int64Array = np.empty((size, words), dtype=np.int64)
        steps, conditions, _, store, scratch = self.product.parts
        kernels.letters(steps, conditions, store, scratch, self.letters)

    @property
    def size(self) -> int:
        """Number of states."""
        return self.product.states

    @property
    def memory_bytes(self) -> int:
        """Size of the tables in bytes."""
        return self.product.memory_bytes + self.pointer.nbytes + self.targets.nbytes

    def where(self, atom: Atom) -> StateSet:
        """Return the states in which an atom is true."""
        word, bit = divmod(self.product.automaton.atoms.index(atom), BITS)
        result: StateSet = (self.letters[:, word] & (1 << bit)) != 0
        return result

    def transitions(self, states: Sequence[int]) -> tuple[int, ...]:
        """Return the transitions along a path of states; staying in a deadlock is not a transition."""
        found = []
        for source, target in pairwise(states):
            here, there = self.product.marking(source), list(self.product.marking(target))
            for t in range(len(self.net.transitions)):
                if self.net.is_enabled(t, here) and self.net.fire(t, here) == there:
                    found.append(t)
                    break
            else:
                assert source == target, "states of a path are successors"
        return tuple(found)


def _lengthened(array: NDArray[Number], size: int) -> NDArray[Number]:
    longer = np.zeros(size, dtype=array.dtype)
    longer[: array.size] = array
    return longer
