"""Strongly connected components of directed graphs.

NetworkX and SciPy have these, too, but take longer to import than the analysis of a small net. The components
of large graphs are found by compiled code.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence
from functools import cache
from itertools import count
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.nets.kernel_cache import kernel

Node = TypeVar("Node", bound=Hashable)

#: Number of nodes and arcs up to which a numbered graph is not worth loading compiled code.
FEW_ARCS = 4_000


def strongly_connected_parts(successors: Mapping[Node, Collection[Node]]) -> list[list[Node]]:
    """Return the strongly connected components of a graph, each after those to which it leads (Tarjan 1972).

    Examples
    --------
    >>> strongly_connected_parts({"a": ["b"], "b": ["c"], "c": ["b"]})
    [['c', 'b'], ['a']]
    """
    parts: list[list[Node]] = []
    number: dict[Node, int] = {}  # in the order of discovery
    lowest: dict[Node, int] = {}  # the least number reachable from it, of nodes without a component so far
    is_apart: set[Node] = set()
    open_nodes: list[Node] = []
    numbers = count()
    for root in successors:
        if root in number:
            continue
        way = [(root, iter(successors[root]))]
        number[root] = lowest[root] = next(numbers)
        open_nodes.append(root)
        while way:
            node, others = way[-1]
            for other in others:
                if other not in number:
                    number[other] = lowest[other] = next(numbers)
                    open_nodes.append(other)
                    way.append((other, iter(successors[other])))
                    break
                if other not in is_apart:
                    lowest[node] = min(lowest[node], number[other])
            else:
                way.pop()
                if way:
                    lowest[way[-1][0]] = min(lowest[way[-1][0]], lowest[node])
                if lowest[node] == number[node]:
                    part = [open_nodes.pop()]
                    while part[-1] != node:
                        part.append(open_nodes.pop())
                    parts.append(part)
                    is_apart.update(part)
    return parts


def ends(successors: Mapping[Node, Collection[Node]]) -> list[set[Node]]:
    """Return the strongly connected components without outgoing arcs."""
    parts = [set(part) for part in strongly_connected_parts(successors)]
    return [part for part in parts if all(part.issuperset(successors[node]) for node in part)]


def has_cycle(successors: Mapping[Node, Collection[Node]]) -> bool:
    """Whether a graph has a cycle."""
    return any(
        len(part) > 1 or part[0] in successors[part[0]] for part in strongly_connected_parts(successors)
    )


def representatives(nodes: Iterable[Node], links: Iterable[Sequence[Node]]) -> dict[Node, Node]:
    """Return by node a representative of its group: all nodes of a link are in one group."""
    leader = {node: node for node in nodes}

    def find(node: Node) -> Node:
        while leader[node] != node:
            leader[node] = node = leader[leader[node]]
        return node

    for link in links:
        for node in link:
            leader[find(node)] = find(link[0])
    return {node: find(node) for node in leader}


def shortest_path(successors: Mapping[Node, Collection[Node]], source: Node, target: Node) -> list[Node]:
    """Return the nodes of a shortest path, including both ends; there must be one."""
    before = {target: target} if source == target else {source: source}
    ahead = deque(before)
    while target not in before:
        node = ahead.popleft()
        for other in successors[node]:
            if other not in before:
                before[other] = node
                ahead.append(other)
    path = [target]
    while path[-1] != source:
        path.append(before[path[-1]])
    return path[::-1]


def numbered_parts(size: int, sources: NDArray[Any], targets: NDArray[Any]) -> tuple[int, NDArray[np.int32]]:
    """Return the number of strongly connected components of a graph with numbered nodes, and each node's."""
    if size + sources.size > FEW_ARCS:
        part = np.empty(size, dtype=np.int32)
        number = _compiled()(sources.astype(np.int32), targets.astype(np.int32), part)
        return int(number), part
    successors: dict[int, list[int]] = {node: [] for node in range(size)}
    for source, target in zip(sources.tolist(), targets.tolist(), strict=True):
        successors[source].append(target)
    parts = strongly_connected_parts(successors)
    part = np.empty(size, dtype=np.int32)
    for number, nodes in enumerate(parts):
        part[nodes] = number
    return len(parts), part


@cache
def _compiled() -> Callable[[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]], int]:
    """Return the kernel, which is made when it is needed: most questions do without Numba."""
    made: Callable[[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]], int] = kernel()(
        _strong_components
    )
    return made


def _strong_components(sources, targets, part):  # type: ignore[no-untyped-def]
    """Write each node's component, and return how many there are; each follows those to which it leads.

    The nodes are the positions of `part`.
    """
    size = part.size
    pointer = np.zeros(size + 1, dtype=np.int64)
    for k in range(sources.size):
        pointer[sources[k] + 1] += 1
    for node in range(size):
        pointer[node + 1] += pointer[node]
    at = pointer[:-1].copy()
    ordered = np.empty(targets.size, dtype=np.int32)
    for k in range(sources.size):
        ordered[at[sources[k]]] = targets[k]
        at[sources[k]] += 1
    at[:] = pointer[:-1]  # now the next arc of each node that is followed
    # 0: not visited; above `size`: its component is known.
    number = np.zeros(size, dtype=np.int64)
    lowest = np.empty(size, dtype=np.int64)
    path = np.empty(size, dtype=np.int32)
    live = np.empty(size, dtype=np.int32)
    visited = living = parts = 0
    for root in range(size):
        if number[root] != 0:
            continue
        path[0], depth = root, 1
        while depth > 0:
            node = path[depth - 1]
            if number[node] == 0:
                visited += 1
                number[node] = lowest[node] = visited
                live[living] = node
                living += 1
            if at[node] < pointer[node + 1]:
                other = ordered[at[node]]
                at[node] += 1
                if number[other] == 0:
                    path[depth] = other
                    depth += 1
                else:
                    # A node of a known component changes nothing.
                    lowest[node] = min(lowest[node], number[other])
                continue
            depth -= 1
            if depth > 0:
                lowest[path[depth - 1]] = min(lowest[path[depth - 1]], lowest[node])
            if lowest[node] == number[node]:
                while True:
                    living -= 1
                    part[live[living]] = parts
                    number[live[living]] = size + 1
                    if live[living] == node:
                        break
                parts += 1
    return parts
