"""The reference search every engine is compared with: breadth first, plain Python, as short as it can be."""

from __future__ import annotations

from typing import NamedTuple

import networkx as nx

from dineros.analysis.nets.compiled import CompiledNet

REFERENCE_LIMIT = 2_000
"""Markings of generated nets that a plain search goes through."""


class ReferenceCounts(NamedTuple):
    """Exact counts of a reachability graph."""

    markings: int
    arcs: int
    deadlocks: int
    largest_place: tuple[int, ...]
    largest_total: int


def reference_search(net: CompiledNet, limit: int = 1_000_000) -> ReferenceCounts | None:
    """Counts by breadth-first search, or None when more than `limit` markings are found."""
    start = tuple(net.initial.tolist())
    seen, frontier, arcs, deadlocks = {start}, [start], 0, 0
    for marking in frontier:
        enabled = [t for t in range(len(net.transitions)) if net.is_enabled(t, marking)]
        arcs += len(enabled)
        deadlocks += not enabled
        for transition in enabled:
            successor = tuple(net.fire(transition, marking))
            if successor not in seen:
                seen.add(successor)
                frontier.append(successor)
        if len(seen) > limit:
            return None
    largest = tuple(max(column) for column in zip(*seen, strict=True))
    return ReferenceCounts(len(seen), arcs, deadlocks, largest, max(map(sum, seen)))


def distances(net: CompiledNet) -> dict[tuple[int, ...], int]:
    """Reachable markings with their distances, or nothing if there are too many."""
    start = tuple(net.initial.tolist())
    distance, frontier = {start: 0}, [start]
    for marking in frontier:
        for t in range(len(net.transitions)):
            if net.is_enabled(t, marking):
                successor = tuple(net.fire(t, marking))
                if successor not in distance:
                    distance[successor] = distance[marking] + 1
                    frontier.append(successor)
        if len(distance) > REFERENCE_LIMIT:
            return {}
    return distance


def reachability_graph(net: CompiledNet) -> nx.MultiDiGraph[tuple[int, ...]]:
    """Return the markings of a bounded net, and an edge, keyed by its transition, for each firing."""
    graph: nx.MultiDiGraph[tuple[int, ...]] = nx.MultiDiGraph()
    start = tuple(net.initial.tolist())
    graph.add_node(start)
    todo = [start]
    for marking in todo:
        for t in range(len(net.transitions)):
            if net.is_enabled(t, marking):
                after = tuple(net.fire(t, marking))
                if after not in graph:
                    todo.append(after)
                graph.add_edge(marking, after, t)
    return graph
