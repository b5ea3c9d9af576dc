"""Shortest ways through a graph of state classes, over edges that are allowed."""

from __future__ import annotations

import numpy as np

from dineros.analysis.timed.graph import WAITING, Flags, TimedGraph


def shortest_way(graph: TimedGraph, allowed: Flags, goals: Flags) -> list[int] | None:
    """Return the edges of a shortest way from the initial class over allowed edges that ends with a goal.

    Parameters
    ----------
    graph
        The classes.
    allowed, goals
        By edge. A goal that is not allowed counts for nothing.

    Returns
    -------
    list of int or None
        Edges in their order; None if no goal can be reached.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import breadth_first_order

    usable = np.flatnonzero(allowed & (graph.label != WAITING))
    source, target = graph.source[usable], graph.target[usable]
    size = graph.classes
    matrix = csr_array((np.ones(len(usable), dtype=np.int8), (source, target)), shape=(size, size))
    order, before = breadth_first_order(matrix, 0, return_predecessors=True)
    rank = np.full(size, size, dtype=np.int64)
    rank[order] = np.arange(len(order))
    ends = usable[goals[usable]]
    ends = ends[rank[graph.source[ends]] < size]
    if not len(ends):
        return None
    last = int(ends[rank[graph.source[ends]].argmin()])
    way, here = [last], int(graph.source[last])
    while here != 0:
        previous = int(before[here])
        edge = usable[np.flatnonzero((source == previous) & (target == here))[0]]
        way.append(int(edge))
        here = previous
    return way[::-1]
