"""The FORCE heuristic: a kernel that measures spans, and rounds that sort the levels by its results."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.nets.kernel_cache import kernel


def force(
    order: NDArray[np.int64], span_start: NDArray[np.int64], span_level: NDArray[np.int64], rounds: int
) -> None:
    """Improve `order` in place by moving levels to the mean centre of their spans; keep the best order.

    Span s holds the levels ``span_level[span_start[s]:span_start[s + 1]]``.
    """
    current, best = order.copy(), -1
    goal, uses = np.empty(order.size), np.empty(order.size, dtype=np.int64)
    for _ in range(rounds):
        cost = centre(current, span_start, span_level, goal, uses)
        if best < 0 or cost < best:
            best = cost
            order[:] = current
        # NumPy sorts here instead of the kernel: compiling a sort takes longer than all rounds.
        current = np.argsort(goal)


@kernel()
def centre(order, span_start, span_level, goal, uses):  # type: ignore[no-untyped-def]
    """Write the target of each level, the mean centre of its spans; return the total length of the spans."""
    size = order.size
    position = np.empty(size, dtype=np.int64)
    for i in range(size):
        position[order[i]] = i
        goal[i] = 0.0
        uses[i] = 0
    cost = 0
    for s in range(span_start.size - 1):
        first, last = span_start[s], span_start[s + 1]
        if last == first:
            continue
        low, high, total = size, 0, 0
        for i in range(first, last):
            at = position[span_level[i]]
            low, high, total = min(low, at), max(high, at), total + at
        cost += high - low
        for i in range(first, last):
            goal[span_level[i]] += total / (last - first)
            uses[span_level[i]] += 1
    for level in range(size):
        goal[level] = goal[level] / uses[level] if uses[level] else position[level]
        # Ties keep their order.
        goal[level] += position[level] * 1e-9
    return cost
