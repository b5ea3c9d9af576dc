"""Kernel of the FORCE heuristic."""

from __future__ import annotations

import numpy as np

from dineros.analysis.nets.kernel_cache import kernel


@kernel()
def force(order, span_start, span_level, rounds):  # type: ignore[no-untyped-def]
    """Improve `order` in place by moving levels to the mean centre of their spans; the best order stays.

    Span s holds the levels ``span_level[span_start[s]:span_start[s + 1]]``.
    """
    size = order.size
    position = np.empty(size, dtype=np.int64)
    current = order.copy()
    best = -1
    for _ in range(rounds):
        for i in range(size):
            position[current[i]] = i
        goal = np.zeros(size)
        uses = np.zeros(size)
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
        if best < 0 or cost < best:
            best = cost
            order[:] = current
        for level in range(size):
            goal[level] = goal[level] / uses[level] if uses[level] else position[level]
            # Ties keep their order.
            goal[level] += position[level] * 1e-9
        current = np.argsort(goal)
