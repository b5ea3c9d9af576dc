"""Stored reachability graphs: the states of a net and their successors, for questions about all of them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.automata.automaton import Automaton, Edge
from dineros.analysis.logic.graphs.product import Product
from dineros.analysis.logic.kernels.product import BITS
from dineros.analysis.logic.kernels.stored import (
    ARCS_FULL,
    COMPLETE,
    OVERFLOW,
    PAUSED,
    STORE_FULL,
    build,
    letters,
    path_states,
    predecessors,
)
from dineros.analysis.logic.language.atoms import Condition
from dineros.analysis.logic.language.syntax import Atom
from dineros.analysis.nets.compiled import CompiledNet

Int32Array = NDArray[np.int32]
Int64Array = NDArray[np.int64]
StateSet = NDArray[np.bool_]
Number = TypeVar("Number", bound=np.generic)

VISITS = 100_000
"""States expanded between looks at the clock."""


class StateGraph:
    """All reachable markings of a net, and for each its successors; a deadlock is its own successor.

    Parameters
    ----------
    net : CompiledNet
    atoms : sequence of (Atom, Condition)
        Conditions evaluated in every state.
    budget : Budget

    Attributes
    ----------
    pointer : int64 array, shape (states + 1,)
    targets : int32 array
        The successors of state s are ``targets[pointer[s]:pointer[s + 1]]``.
    back_pointer, sources : int64 array, int32 array
        The same for predecessors.

    Raises
    ------
    BudgetExceededError
        When a limit is hit before the graph is complete.
    """

    def __init__(self, net: CompiledNet, atoms: Sequence[tuple[Atom, Condition]], budget: Budget) -> None:
        self.net, self.budget = net, budget
        self.atoms = {atom: i for i, (atom, _) in enumerate(atoms)}
        # An automaton that reads everything: its product with the net is the reachability graph.
        everything = Automaton(tuple(self.atoms), 0, 0, ((Edge(0, 0, 0, 0),),))
        self.product = Product(net, everything, [condition for _, condition in atoms], (), (), budget)
        self.pointer: Int64Array = np.zeros(len(self.product.store.words) + 1, dtype=np.int64)
        self.targets: Int32Array = np.empty(1 << 14 | 2 * self.product.room, dtype=np.int32)

    def explore(self) -> None:
        """Find all states."""
        product = self.product
        labels = np.empty(product.room, dtype=np.int32)
        state, status = 0, PAUSED
        while status != COMPLETE:
            status, state = build(
                product.tables,
                product.conditions,
                product.edges,
                product.store,
                product.scratch,
                self.pointer,
                self.targets,
                labels,
                state,
                VISITS,
            )
            if status in (PAUSED, STORE_FULL):
                self.budget.report(self.product.progress(self.memory_bytes))
            if status == STORE_FULL:
                product.grow(self.pointer.nbytes + self.targets.nbytes)
                self.pointer = _lengthened(self.pointer, len(product.store.words) + 1)
            elif status == ARCS_FULL:
                self.budget.check_memory(self.memory_bytes + 2 * self.targets.nbytes)
                self.targets = _lengthened(self.targets, 2 * self.targets.size)
            elif status == OVERFLOW:
                product.widen(self.pointer.nbytes + self.targets.nbytes)
        self._index()

    def _index(self) -> None:
        size, arcs = self.size, int(self.pointer[self.size])
        # Predecessors, letters, and room for the sets of a few subformulas.
        words = self.product.scratch.letter.size
        self.budget.check_memory(self.memory_bytes + 4 * arcs + (32 + 8 * words) * size)
        self.pointer, self.targets = self.pointer[: size + 1], self.targets[:arcs]
        self.back_pointer: Int64Array = np.zeros(size + 1, dtype=np.int64)
        self.sources: Int32Array = np.empty(arcs, dtype=np.int32)
        predecessors(self.pointer, self.targets, self.back_pointer, self.sources)
        self.letters: Int64Array = np.empty((size, words), dtype=np.int64)
        product = self.product
        letters(product.tables, product.conditions, product.store, product.scratch, self.letters)

    @property
    def size(self) -> int:
        """Number of states."""
        return self.product.states

    @property
    def memory_bytes(self) -> int:
        """Bytes of the tables."""
        return self.product.memory_bytes + self.pointer.nbytes + self.targets.nbytes

    def where(self, atom: Atom) -> StateSet:
        """Return the states in which an atom is true."""
        word, bit = divmod(self.atoms[atom], BITS)
        result: StateSet = (self.letters[:, word] & (1 << bit)) != 0
        return result

    def path(self, start: int, allowed: StateSet, goal: StateSet) -> list[int]:
        """Return the states of a shortest path of at least one edge over allowed states to a goal, or []."""
        parents = np.full(self.size, -1, dtype=np.int32)
        queue = np.empty(self.size, dtype=np.int32)
        state, end = path_states(self.pointer, self.targets, start, allowed, goal, parents, queue)
        if end < 0:
            return []
        found = [end]
        while state != start:
            found.append(state)
            state = int(parents[state])
        return [int(state) for state in (*found, start)][::-1]

    def transitions(self, states: Sequence[int]) -> tuple[int, ...]:
        """Return transitions that lead along a path of states; staying in a deadlock is none."""
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
