"""Circles in relations that must not have any, such as references and priorities."""

from __future__ import annotations

from collections.abc import Callable
from graphlib import CycleError, TopologicalSorter
from typing import TypeVar

from dineros.metamodel import pn
from dineros.metamodel.constraints.index import Index

N = TypeVar("N", bound=pn.Element)


def circles(index: Index, kind: type[N], follow: Callable[[N], list[N]]) -> dict[N, str]:
    """Return a circle such as ``a -> b -> a`` for each knot of elements that reach each other.

    The key is the first element of the knot in model order.
    """
    return index.once((circles, follow), lambda: circles_of(_edges(index.all(kind), follow)))


def _edges(nodes: list[N], follow: Callable[[N], list[N]]) -> dict[N, list[N]]:
    return {node: targets for node in nodes if (targets := follow(node))}


def circles_of(edges: dict[N, list[N]]) -> dict[N, str]:
    """Return what `circles` returns, for a relation given as a table."""
    try:
        TopologicalSorter(edges).prepare()
    except CycleError:
        return _knots(edges)
    return {}


def _knots(edges: dict[N, list[N]]) -> dict[N, str]:
    import networkx  # takes a while to import, and hardly a model needs it

    pairs = ((source, target) for source, targets in edges.items() for target in targets)
    graph: networkx.DiGraph[N] = networkx.DiGraph(pairs)
    order = {node: position for position, node in enumerate(edges)}
    found = {}
    for knot in networkx.strongly_connected_components(graph):
        first = min(knot, key=lambda node: order.get(node, len(order)))
        if len(knot) > 1 or graph.has_edge(first, first):
            path = [source for source, _ in networkx.find_cycle(graph.subgraph(knot), source=first)]
            found[first] = " -> ".join(str(node.id) for node in [*path, path[0]])
    return found
