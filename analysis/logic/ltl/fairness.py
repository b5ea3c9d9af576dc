"""Accepting runs inside a component when some transitions are strongly fair: emptiness of Streett automata.

In a strongly connected set of states in which a strongly fair transition is enabled somewhere but fired
nowhere, a fair run must avoid the states that enable it. These states are removed, and the remaining
components are examined again.

References
----------
E. A. Emerson, C.-L. Lei, *Modalities for model checking: branching time logic strikes back*, Science of
Computer Programming 8(3), 1987. A. Duret-Lutz, D. Poitrenaud, J.-M. Couvreur, *On-the-fly emptiness check of
transition-based Streett automata*, ATVA 2009, LNCS 5799.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.logic.graphs.product import Product
from dineros.analysis.logic.kernels.paths import inner_edges
from dineros.analysis.nets.graph_parts import numbered_parts

Int32Array = NDArray[np.int32]
Int64Array = NDArray[np.int64]
States = NDArray[np.int32]


@dataclass(frozen=True)
class InnerGraph:
    """The edges of a product between some of its states.

    Attributes
    ----------
    sources, targets : int32 arrays
        Ends of the edges, as positions in `states`.
    edge_marks : int64 array, shape (edges, words)
    disabled : int64 array, shape (states, words)
        Marks of weakly fair transitions that are disabled in a state.
    asked : int64 array, shape (states, words)
        Marks of strongly fair transitions that are enabled in a state.
    """

    states: States
    sources: Int32Array
    targets: Int32Array
    edge_marks: Int64Array
    disabled: Int64Array
    asked: Int64Array

    @classmethod
    def of(cls, product: Product, states: States) -> InnerGraph:
        """Return the graph of some states, all of which must have been expanded."""
        number = np.full(len(product.store.words), -1, dtype=np.int32)
        number[states] = np.arange(states.size, dtype=np.int32)
        words = product.conditions.required.size
        disabled = np.zeros((states.size, words), dtype=np.int64)
        asked = np.zeros((states.size, words), dtype=np.int64)
        size = product.room + min(1 << 16, states.size * product.room)
        sources, targets, labels = (np.zeros(size, dtype=np.int32) for _ in range(3))
        parts: list[list[Int32Array]] = []
        position = 0
        while position < states.size:
            product.budget.check_memory(
                product.memory_bytes + sum(array.nbytes for part in parts for array in part)
            )
            position, count = inner_edges(
                *product.parts,
                states,
                position,
                number,
                sources,
                targets,
                labels,
                disabled,
                asked,
            )
            parts.append([buffer[:count].copy() for buffer in (sources, targets, labels)])
        sources, targets, labels = (np.concatenate(column) for column in zip(*parts, strict=True))
        edge_marks = product.marks_of(labels)
        return cls(states, sources, targets, edge_marks, disabled, asked)

    def part(self, kept: NDArray[np.bool_]) -> InnerGraph:
        """Return the graph restricted to the kept states."""
        number = np.cumsum(kept, dtype=np.int32) - 1
        edges = kept[self.sources] & kept[self.targets]
        return InnerGraph(
            self.states[kept],
            number[self.sources[edges]],
            number[self.targets[edges]],
            self.edge_marks[edges],
            self.disabled[kept],
            self.asked[kept],
        )

    def components(self, required: Int64Array) -> Iterator[InnerGraph]:
        """Yield the strongly connected components with an edge and all required marks, in order of states."""
        if not self.sources.size or self._marks_missing(required):
            return
        size = self.states.size
        count, component = numbered_parts(size, self.sources, self.targets)
        inside = np.flatnonzero(component[self.sources] == component[self.targets])
        home = component[self.sources[inside]]
        marks = np.zeros((count, required.size), dtype=np.int64)
        np.bitwise_or.at(marks, home, self.edge_marks[inside])
        np.bitwise_or.at(marks, component, self.disabled)
        # Sorted by component, each component is a slice.
        by_state, by_edge = np.argsort(component, kind="stable"), inside[np.argsort(home, kind="stable")]
        state_start = np.concatenate([[0], np.cumsum(np.bincount(component, minlength=count))])
        edge_start = np.concatenate([[0], np.cumsum(np.bincount(home, minlength=count))])
        position = np.empty(size, dtype=np.int32)
        position[by_state] = np.arange(size) - state_start[component[by_state]]
        chosen = np.flatnonzero((np.diff(edge_start) > 0) & ~np.any(required & ~marks, axis=1))
        for c in chosen[np.argsort(by_state[state_start[chosen]])].tolist():
            states = by_state[state_start[c] : state_start[c + 1]]
            edges = by_edge[edge_start[c] : edge_start[c + 1]]
            yield InnerGraph(
                self.states[states],
                position[self.sources[edges]],
                position[self.targets[edges]],
                self.edge_marks[edges],
                self.disabled[states],
                self.asked[states],
            )

    def _marks_missing(self, required: Int64Array) -> bool:
        found = np.bitwise_or.reduce(self.edge_marks, axis=0) | np.bitwise_or.reduce(self.disabled, axis=0)
        return bool((required & ~found).any())

    def accepting_part(self, required: Int64Array) -> States | None:
        """Return a strongly connected set of states; a run through all of them is accepting and fair.

        The graph is a strongly connected component with all required marks.
        """
        todo: list[Iterator[InnerGraph]] = [iter((self,))]
        while todo:
            graph = next(todo[-1], None)
            if graph is None:
                todo.pop()
                continue
            marks = np.bitwise_or.reduce(graph.edge_marks, axis=0)
            unfair = np.bitwise_or.reduce(graph.asked, axis=0) & ~marks
            if not unfair.any():
                return graph.states
            kept = ~np.any(graph.asked & unfair, axis=1)
            if kept.any():
                todo.append(graph.part(kept).components(required))
        return None
