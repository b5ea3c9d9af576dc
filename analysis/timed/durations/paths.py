"""Shortest ways through a graph of state classes, over edges that are allowed."""

from __future__ import annotations

import numpy as np

from dineros.analysis.logic.graphs.predicates import Flags
from dineros.analysis.timed.graph import WAITING, EdgePaths, TimedGraph


def shortest_way(graph: TimedGraph, allowed: Flags, goals: Flags) -> list[int] | None:
    """Return the edges of a shortest way from the initial class over allowed edges that ends with a goal.

    Parameters
    ----------
    allowed, goals
        By edge. A goal that is not allowed counts for nothing.

    Returns
    -------
    list of int or None
        Edges in their order; None if no goal can be reached.
    """
    usable = np.flatnonzero(allowed & (graph.label != WAITING))
    source = graph.source[usable]
    last = np.flatnonzero(goals[usable])
    is_last = np.zeros(graph.classes, dtype=np.bool_)
    is_last[source[last]] = True
    way = EdgePaths(graph.classes, source, graph.target[usable]).to(is_last, 0, np.ones_like(is_last))
    if way is None:
        return None
    edges, end = way
    edges.append(int(last[np.flatnonzero(source[last] == end)[0]]))
    return [int(usable[edge]) for edge in edges]
