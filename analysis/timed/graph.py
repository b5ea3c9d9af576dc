"""Graphs of state classes as arrays, for questions about runs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from dineros.analysis.answers.budget import RAN_OUT, UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.logic.graphs.predicates import Flags, MarkingMatrix, any_enabled, holds
from dineros.analysis.logic.graphs.stored import Arcs
from dineros.analysis.logic.language.atoms import Condition, Linear, NoneEnabled, SomeEnabled, SomeFired
from dineros.analysis.nets.compiled import Int64Array
from dineros.analysis.timed.atomic import AtomicSearch
from dineros.analysis.timed.classes import ClassGraph, Kind
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.search import ClassSearch

WAITING = -1
"""Label of an edge that fires nothing: time passes forever."""


@dataclass(frozen=True)
class TimedGraph:
    """Classes, numbered from 0, the initial one, and edges.

    Attributes
    ----------
    marking_of : int64 array, shape (classes,)
        By class its marking, a row of `markings`.
    markings : int64 array, shape (markings, places)
    source, target, label : int64 arrays, shape (edges,)
        The edges, sources ascending; the label is the transition, or `WAITING` where a run may stay in a
        class forever: then nothing that is enabled has a latest bound.
    """

    net: TimedNet
    marking_of: Int64Array
    markings: Int64Array
    source: Int64Array
    target: Int64Array
    label: Int64Array

    @property
    def classes(self) -> int:
        """Number of classes."""
        return len(self.marking_of)

    def where(self, condition: Condition) -> Flags:
        """Return by class whether its marking has a property.

        ``deadlock`` is a class in which nothing can fire any more, however long one waits.
        """
        if isinstance(condition, NoneEnabled):
            fires = np.zeros(self.classes, dtype=np.bool_)
            fires[self.source[self.label != WAITING]] = True
            return ~fires
        if isinstance(condition, Linear | SomeEnabled):
            return holds(MarkingMatrix(self.net.untimed, self.markings), condition)[self.marking_of]
        raise TypeError(f"no property of a marking: {condition}")

    def fired(self, condition: SomeFired) -> Flags:
        """Return by edge whether it fires one of some transitions."""
        return np.isin(self.label, list(condition.transitions))


class EdgePaths:
    """Shortest paths in a graph of numbered nodes, as edges."""

    def __init__(self, size: int, source: Int64Array, target: Int64Array) -> None:
        self._edges = np.argsort(source, kind="stable")
        pointer = np.searchsorted(source[self._edges], np.arange(size + 1))
        self._arcs = Arcs.of(pointer, target[self._edges].astype(np.int32))

    def to(self, goals: Flags, start: int, allowed: Flags) -> tuple[list[int], int] | None:
        """Return the edges of a shortest path over allowed nodes to a goal, and the goal, or None."""
        if goals[start]:
            return [], start
        nodes = self._arcs.path(start, allowed, goals)
        return ([self._edge(*pair) for pair in pairwise(nodes)], nodes[-1]) if nodes else None

    def _edge(self, source: int, target: int) -> int:
        first, end = self._arcs.pointer[source : source + 2]
        return int(self._edges[first + np.flatnonzero(self._arcs.targets[first:end] == target)[0]])


def class_graph(net: TimedNet, kind: Kind = "W", budget: Budget = UNLIMITED) -> ClassGraph:
    """Build the graph of all state classes.

    Parameters
    ----------
    net
        The net. W and M do not know priorities.
    kind
        Which classes; see `dineros.analysis.timed.classes`.
    budget
        Limits; a share of the free memory unless one is given.

    Raises
    ------
    DinerosError
        The net has priorities and the classes are linear, or a bound is too large.
    """
    search = AtomicSearch(net, budget) if kind == "A" else ClassSearch(net, kind, budget)
    search.run()
    return search.graph()


def timed_graph(net: TimedNet, kind: Kind, budget: Budget) -> TimedGraph:
    """Build the graph of all state classes: W, S or A.

    Raises
    ------
    BudgetExceededError
        A limit was hit before it is complete.
    """
    return first_classes(net, kind, budget, None)[0]


def first_classes(net: TimedNet, kind: Kind, budget: Budget, most: int | None) -> tuple[TimedGraph, bool]:
    """Build the graph of the state classes that are found first: W, S or A.

    Parameters
    ----------
    most
        Classes with which the search ends, about; None: all of them, as A needs.

    Returns
    -------
    graph : TimedGraph
        Of these. A class that was not looked into has no edge.
    is_complete : bool
        Whether these are all.

    Raises
    ------
    BudgetExceededError
        A limit was hit before.
    """
    share = budget if most is None else replace(budget, states=most)
    search = AtomicSearch(net, share) if kind == "A" else ClassSearch(net, kind, share, keeps_edges=True)
    search.run()
    is_complete = search.reason is None
    if not is_complete and (most is None or search.reason != "states"):
        reason = str(search.reason)
        raise BudgetExceededError(RAN_OUT.get(reason, reason))
    budget.check_memory(search.memory_bytes + 6 * 8 * search.edges)
    marking_of, source, target, label = search.arrays()
    markings = search.markings()
    limited = [t for t, interval in enumerate(net.intervals) if interval.latest is not None]
    waits = ~any_enabled(MarkingMatrix(net.untimed, markings), limited)
    waiting = np.flatnonzero(waits[marking_of])
    source = np.concatenate([source, waiting])
    target = np.concatenate([target, waiting])
    label = np.concatenate([label, np.full(len(waiting), WAITING)])
    order = np.argsort(source, kind="stable")
    made = TimedGraph(net, marking_of, markings, source[order], target[order], label[order])
    return made, is_complete
