"""A short accepting run through a component: breadth-first stem, and a loop that collects the marks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.logic.graphs.product import Product
from dineros.analysis.logic.kernels.paths import shortest_path
from dineros.analysis.logic.kernels.product import MAY_ADD, expand
from dineros.analysis.logic.ltl.fairness import States


@dataclass(frozen=True)
class ProductRun:
    """A run of a net accepted by an automaton, as transitions.

    Attributes
    ----------
    loop : tuple of int
        Transitions fired repeatedly; empty if the run ends in a deadlock.
    """

    stem: tuple[int, ...]
    loop: tuple[int, ...]


def find_run(product: Product, component: States) -> ProductRun:
    """Return an accepting run whose loop stays in a component.

    The stem is a shortest one over the states found so far. The loop goes to the nearest state or edge with a
    missing mark, until no mark is missing, and back.
    """
    finder = _Finder(product)
    members = np.zeros(len(product.store.words), dtype=np.bool_)
    members[component] = True
    everything = np.ones(len(product.store.words), dtype=np.bool_)
    nothing = np.zeros_like(product.conditions.required)
    stem, entry = ([], 0) if members[0] else finder.path(0, everything, members, nothing)
    missing = finder.marks_to_collect(component) & ~finder.state_marks(entry)
    nowhere = np.zeros_like(everything)
    loop: list[int] = []
    state = entry
    while missing.any():
        steps, state = finder.path(state, members, nowhere, missing)
        for label in steps:
            missing &= ~finder.edge_marks(label)
        for passed in finder.passed:
            missing &= ~finder.state_marks(passed)
        loop += steps
    if state != entry or not loop:
        home = nowhere.copy()
        home[entry] = True
        loop += finder.path(state, members, home, nothing)[0]
    return ProductRun(finder.transitions(stem), finder.transitions(loop))


class _Finder:
    """Breadth-first searches over the stored states of a product."""

    def __init__(self, product: Product) -> None:
        self.product = product
        size = len(product.store.words)
        self.parents = np.empty(size, dtype=np.int32)
        self.labels = np.empty(size, dtype=np.int32)
        self.queue = np.empty(size, dtype=np.int32)
        self.targets = np.empty(product.room, dtype=np.int32)
        self.new_labels = np.empty(product.room + 2, dtype=np.int32)
        self.passed: list[int] = []

    def path(
        self,
        start: int,
        allowed: NDArray[np.bool_],
        goal: NDArray[np.bool_],
        wanted: NDArray[np.int64],
    ) -> tuple[list[int], int]:
        """Return the labels of a shortest path of at least one edge to a goal, and its last state."""
        self.parents.fill(-1)
        tables = self.parents, self.labels, self.queue, self.targets, self.new_labels
        source = int(shortest_path(*self.product.parts, start, allowed, goal, wanted, *tables))
        assert source >= 0, "the states of a component reach each other"
        end, last = int(self.new_labels[-2]), int(self.new_labels[-1])
        self.passed = [end]
        steps, state = [last], source
        while state != start:
            self.passed.append(state)
            steps.append(int(self.labels[state]))
            state = int(self.parents[state])
        return steps[::-1], end

    def state_marks(self, state: int) -> NDArray[np.int64]:
        """Return the marks of weakly fair transitions disabled in a state."""
        self._expand(state)
        return self.product.scratch.weak_seen.copy()

    def edge_marks(self, label: int) -> NDArray[np.int64]:
        """Return the marks of an edge."""
        transition, edge = divmod(label, self.product.edges.target.size)
        conditions = self.product.conditions
        marks: NDArray[np.int64] = conditions.weak_marks[transition] | conditions.strong_marks[transition]
        marks |= self.product.edges.marks[edge]
        return marks

    def marks_to_collect(self, component: States) -> NDArray[np.int64]:
        """Return the required marks and those of the strongly fair transitions enabled in a component."""
        wanted = self.product.conditions.required.copy()
        if self.product.strong:
            for state in component.tolist():
                self._expand(state)
                wanted |= self.product.scratch.strong_seen
        return wanted

    def transitions(self, labels: list[int]) -> tuple[int, ...]:
        """Return the transitions of labels; staying in a deadlock is not a transition."""
        width = self.product.edges.target.size
        found = (label // width for label in labels)
        return tuple(t for t in found if t < len(self.product.net.transitions))

    def _expand(self, state: int) -> None:
        product = self.product
        product.store.counters[MAY_ADD] = 0
        expand(*product.parts, state, self.targets, self.new_labels, 0)
