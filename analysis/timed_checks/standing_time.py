"""Loops of firings in which time stands still, or can.

A transition with the interval ``[0,0]`` fires before time continues. A loop of such transitions never lets
time continue. A loop with other transitions may: each of them is enabled again in each round, and waits then.

Priorities change that. A transition that has to fire waits as long as one with priority over it can fire. If
that goes on forever, time ends at the latest bound of the one that waits.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Sequence
from functools import cached_property
from itertools import pairwise

import numpy as np

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.stages import Share
from dineros.analysis.logic.graphs.predicates import MarkingMatrix, enabled
from dineros.analysis.nets.compiled import Int64Array
from dineros.analysis.nets.graph_parts import numbered_parts, shortest_path
from dineros.analysis.timed.exploring import Explored, Trace
from dineros.analysis.timed.graph import EdgePaths, TimedGraph, timed_graph
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.runs.infinite_time import keeps_clock

GRAPH = Share(time=0.3)
"""Part of the time for the graph of strong classes, which only nets with priorities need here."""

Loop = tuple[Trace, Trace]
"""A firing sequence to a loop, and the loop."""
Edges = tuple[Int64Array, Int64Array, Int64Array]
"""Sources, targets and transitions."""


class StandingTime:
    """Looks for loops in which time stands still.

    Parameters
    ----------
    explored : Explored
        The markings of the net.
    budget : Budget
        Limits; nets with priorities need more classes.
    """

    def __init__(self, explored: Explored, budget: Budget) -> None:
        self._explored, self._net = explored, explored.net
        self._budget = budget
        self._hasty = [
            t
            for t, interval in enumerate(explored.net.intervals)
            if interval.earliest == 0 and not interval.is_open_below
        ]

    def at_once(self) -> Loop | None:
        """Return a loop of transitions that fire as soon as they are enabled: their interval is ``[0,0]``.

        Raises
        ------
        BudgetExceededError
            The net has priorities, and too many classes.
        """
        immediate = [t for t, interval in enumerate(self._net.intervals) if interval.latest == 0]
        growth = self._explored.growth
        if growth is not None and set(growth.suffix) <= set(immediate):
            return growth.prefix, growth.suffix
        if not immediate or not self._net.has_priorities:
            return self._loop_of_markings(immediate)
        return self._loop_of_classes(np.flatnonzero(np.isin(self._graph.label, immediate)))

    def that_may_wait(self) -> Loop | None:
        """Return a loop of transitions with latest bounds that may fire at once; none with priorities."""
        may = [t for t in self._hasty if self._net.intervals[t].latest is not None]
        return None if self._net.has_priorities else self._loop_of_markings(may)

    def that_holds(self) -> tuple[Loop, int] | None:
        """Return a loop that never ends and keeps a transition that has to fire from firing, and that one.

        The clock of that transition continues through the loop. So the loop takes no more time than its
        latest bound.

        Raises
        ------
        BudgetExceededError
            There are too many classes.
        """
        waiting = self._may_be_held()
        if not waiting:
            return None
        graph = self._graph
        _, part = numbered_parts(graph.classes, graph.source, graph.target)
        is_last = np.ones(graph.classes, dtype=np.bool_)  # by part: nothing leads out of it
        is_last[part[graph.source[part[graph.source] != part[graph.target]]]] = False
        edges = np.flatnonzero(is_last[part[graph.source]])
        own = part[graph.source[edges]]
        for t in waiting:
            holds = is_last.copy()
            holds[own[~keeps_clock(graph, edges, t)]] = False
            loop = self._loop_of_classes(edges[holds[own]])
            if loop is not None:
                return loop, t
        return None

    def _may_be_held(self) -> list[int]:
        """Return transitions that have to fire, if markings enable them in a loop with one that goes before.

        At the latest bound of what waits, all firings of the loop take no time. If there are no such
        transitions, no graph of classes has to be built.
        """
        net, markings = self._net, self._explored.markings
        below = [
            t for t, interval in enumerate(net.intervals) if interval.latest is not None and net.above[t]
        ]
        if not below:
            return []
        source, target, label = _moves(net, markings, self._hasty)
        found = []
        for t in below:
            waits = np.zeros(len(markings), dtype=np.bool_)
            waits[self._explored.enabled_at(t)] = True
            kept = np.flatnonzero(waits[source] & waits[target] & (label != t))
            _, part = numbered_parts(len(markings), source[kept], target[kept])
            inside = part[source[kept]] == part[target[kept]]
            if np.isin(label[kept[inside]], net.above[t]).any():
                found.append(t)
        return found

    @cached_property
    def _graph(self) -> TimedGraph:
        return timed_graph(self._net, "S", GRAPH.share(self._budget))

    def _loop_of_markings(self, transitions: Collection[int]) -> Loop | None:
        """Return a loop of transitions that can fire in each state of a marking, and the way to it."""
        if not transitions:
            return None
        markings = self._explored.markings
        loop = _circle(len(markings), _moves(self._net, markings, transitions))
        return None if loop is None else (self._explored.way_to(loop[0]), loop[1])

    def _loop_of_classes(self, edges: Int64Array) -> Loop | None:
        """Return a loop of some edges between strong classes, and the way to it."""
        graph = self._graph
        loop = _circle(graph.classes, (graph.source[edges], graph.target[edges], graph.label[edges]))
        if loop is None:
            return None
        goals, everywhere = np.zeros(graph.classes, dtype=np.bool_), np.ones(graph.classes, dtype=np.bool_)
        goals[loop[0]] = True
        way = EdgePaths(graph.classes, graph.source, graph.target).to(goals, 0, everywhere)
        assert way is not None, "each class can be reached"
        return tuple(graph.label[way[0]].tolist()), loop[1]


def _moves(net: TimedNet, markings: Int64Array, transitions: Iterable[int]) -> Edges:
    """Return the firings of some transitions, without times, from marking to marking."""
    row_of = {row.tobytes(): number for number, row in enumerate(np.ascontiguousarray(markings))}
    sources: list[int] = []
    targets: list[int] = []
    labels: list[int] = []
    for t in transitions:
        change = np.zeros(markings.shape[1], dtype=np.int64)
        for place, tokens in net.untimed.delta[t].items():
            change[place] = tokens
        for row in np.flatnonzero(enabled(MarkingMatrix(net.untimed, markings), t)).tolist():
            target = row_of.get((markings[row] + change).tobytes())
            if target is not None:  # of a search that ended early, not all are known
                sources.append(row)
                targets.append(target)
                labels.append(t)
    made = (np.array(column, dtype=np.int64) for column in (sources, targets, labels))
    return next(made), next(made), next(made)


def _circle(size: int, edges: Edges) -> tuple[int, Trace] | None:
    """Return a node of a circle, and the labels of the shortest circle from it; None if there is none."""
    source, target, label = edges
    if not len(source):
        return None
    _, part = numbered_parts(size, source, target)
    inside = np.flatnonzero(part[source] == part[target])
    if not len(inside):
        return None
    start = int(source[inside].min())
    return start, tuple(_round(start, source[inside], target[inside], label[inside]))


def _round(start: int, source: Int64Array, target: Int64Array, label: Int64Array) -> Sequence[int]:
    """Return the labels of a shortest way from a node of a circle back to it."""
    end = -1  # the node itself, as the end of the way
    labels: dict[tuple[int, int], int] = {}
    after: defaultdict[int, list[int]] = defaultdict(list)
    for a, b, t in zip(source.tolist(), target.tolist(), label.tolist(), strict=True):
        there = end if b == start else b
        if (a, there) not in labels:
            labels[a, there] = t
            after[a].append(there)
    return [labels[step] for step in pairwise(shortest_path(after, start, end))]
