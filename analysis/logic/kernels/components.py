"""Kernel: strongly connected components of a graph with numbered nodes.

References
----------
R. Tarjan, *Depth-first search and linear graph algorithms*, SIAM Journal on Computing 1(2), 1972.
"""

from __future__ import annotations

import numpy as np

from dineros.analysis.nets.kernel_cache import kernel


@kernel()
def strong_components(sources, targets, part):  # type: ignore[no-untyped-def]
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
