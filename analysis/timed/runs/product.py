"""The product of a graph of state classes and an automaton, and its accepted runs."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.automata.automaton import Automaton
from dineros.analysis.logic.graphs.predicates import Flags
from dineros.analysis.logic.language.atoms import BoundAtoms, SomeFired
from dineros.analysis.logic.verdicts.verdict import ReplayError
from dineros.analysis.nets.compiled import Int64Array
from dineros.analysis.nets.graph_parts import numbered_parts
from dineros.analysis.timed.graph import WAITING, EdgePaths, TimedGraph


@dataclass(frozen=True)
class LassoRun:
    """Edges of the graph: those of the stem, and those of the loop."""

    stem_edges: tuple[int, ...]
    loop_edges: tuple[int, ...]


class ClassProduct:
    """The product of a graph and an automaton: states are class * states + state of the automaton.

    A run that waits forever never fires again. So waiting leads to a copy of the class, which is never left:
    else *next*, and ``fired(t)``, could distinguish a run that waits for a while from one that does not.

    Parameters
    ----------
    unread
        Transitions of an observer. The automaton does not read their firings, and stays where it is.
    """

    def __init__(
        self,
        graph: TimedGraph,
        automaton: Automaton,
        atoms: BoundAtoms,
        budget: Budget,
        unread: Collection[int] = (),
    ) -> None:
        self._graph, self._automaton, self._budget = graph, automaton, budget
        self._states = len(automaton.edges)
        letters = np.zeros(len(graph.source), dtype=np.int64)
        for bit, atom in enumerate(automaton.atoms):
            condition = atoms.conditions[atom]
            if isinstance(condition, SomeFired):
                held = graph.fired(condition)
            else:
                held = graph.where(condition)[graph.source]
            letters |= held.astype(np.int64) << bit
        waiting = np.flatnonzero(graph.label == WAITING)
        copies = graph.classes + np.arange(len(waiting))
        target = graph.target.copy()
        target[waiting] = copies
        self._classes = graph.classes + len(waiting)
        self._original = np.concatenate([np.arange(len(graph.source)), waiting])
        self._is_read = ~np.isin(graph.label[self._original], list(unread))
        self._join(
            np.concatenate([graph.source, copies]),
            np.concatenate([target, copies]),
            letters[self._original],
        )

    def _join(self, source: Int64Array, target: Int64Array, letters: Int64Array) -> None:
        """Make the edges of the product."""
        states, is_read = self._states, self._is_read
        parts: list[tuple[Int64Array, Int64Array, Int64Array, Int64Array]] = []
        total = 0

        def add(chosen: Int64Array, state: int, after: int, marks: int) -> None:
            nonlocal total
            total += len(chosen)
            self._budget.check_memory(4 * 8 * total)
            self._budget.check_time()
            parts.append(
                (
                    source[chosen] * states + state,
                    target[chosen] * states + after,
                    self._original[chosen],
                    np.full(len(chosen), marks),
                )
            )

        for state, edges in enumerate(self._automaton.edges):
            for edge in edges:
                reads = (letters & edge.positive == edge.positive) & (letters & edge.negative == 0)
                add(np.flatnonzero(reads & is_read), state, edge.target, edge.marks)
            if not is_read.all():
                add(np.flatnonzero(~is_read), state, state, 0)
        self.source, self.target, self.edge, self.marks = (
            np.concatenate(column) if parts else np.zeros(0, dtype=np.int64)
            for column in (zip(*parts, strict=True) if parts else [[]] * 4)
        )
        self._paths = EdgePaths(self._classes * states, self.source, self.target)

    def accepted(self, needed: Sequence[Flags] = (), allowed: Flags | None = None) -> LassoRun | None:
        """Return an accepted run, or None if there is none.

        Parameters
        ----------
        needed
            By edge of the graph; the loop of the run has an edge of each of these.
        allowed
            By edge of the graph; the loop of the run has only these. By default all.
        """
        accepting, component, inside, marks, all_marks = self._accepting(needed, allowed)
        every = np.ones(len(component), dtype=np.bool_)
        way = self._paths.to(accepting[component], self._automaton.initial, every)
        if way is None:
            return None
        stem, start = way
        edges = np.flatnonzero(inside & (component[self.source] == component[start]))
        loop = edges[self._loop(start, edges, marks[edges], all_marks)]
        return LassoRun(tuple(self.edge[stem].tolist()), tuple(self.edge[loop].tolist()))

    def accepting_parts(self) -> tuple[Int64Array, Int64Array]:
        """Return the edges of the graph in accepting components, and of each the number of its component."""
        accepting, component, inside, _, _ = self._accepting((), None)
        chosen = np.flatnonzero(inside & accepting[component[self.source]])
        _, numbers = np.unique(component[self.source[chosen]], return_inverse=True)
        return self.edge[chosen], numbers

    def _accepting(
        self, needed: Sequence[Flags], allowed: Flags | None
    ) -> tuple[Flags, NDArray[np.int32], Flags, Int64Array, int]:
        """Return by component whether it accepts, by state its component, and of edges what decides that.

        These are by edge whether it is inside of a component, and its marks; the last one is all marks.
        """
        marks, all_marks = self.marks, self._automaton.all_marks
        for bit, flags in enumerate(needed, start=self._automaton.marks):
            marks = marks | flags[self.edge].astype(np.int64) << bit
            all_marks |= 1 << bit
        kept = np.ones(len(self.edge), dtype=np.bool_) if allowed is None else allowed[self.edge]
        source, target = (ends[kept].astype(np.int32) for ends in (self.source, self.target))
        _, component = numbered_parts(self._classes * self._states, source, target)
        inside = kept & (component[self.source] == component[self.target])
        found = np.zeros(int(component.max(initial=0)) + 1, dtype=np.int64)
        has_edge = np.zeros(len(found), dtype=np.bool_)
        np.bitwise_or.at(found, component[self.source[inside]], marks[inside])
        has_edge[component[self.source[inside]]] = True
        return has_edge & (found == all_marks), component, inside, marks, all_marks

    def _loop(self, start: int, edges: Int64Array, marks: Int64Array, missing: int) -> list[int]:
        """Return edges, by their number among some, from a state of their component back to it.

        They carry all marks that are missing.
        """
        source, target = self.source[edges], self.target[edges]
        paths, size = EdgePaths(self._classes * self._states, source, target), self._classes * self._states

        def path(goals: int | Int64Array, at: int) -> tuple[list[int], int]:
            is_goal = np.zeros(size, dtype=np.bool_)
            is_goal[goals] = True
            found = paths.to(is_goal, at, np.ones(size, dtype=np.bool_))
            if found is None:
                raise ReplayError("a goal that can be reached is not reached")
            return found

        chosen: list[int] = []
        at = start
        while missing or not chosen:
            # A shortest path to an edge with a mark that is missing, and over it.
            wanted = np.flatnonzero(marks & missing) if missing else np.arange(len(edges))
            way, at = path(source[wanted], at)
            over = int(next(edge for edge in wanted if source[edge] == at))
            chosen += [*way, over]
            missing &= ~int(marks[over])
            at = int(target[over])
        return chosen + path(start, at)[0]
