"""Kernels for what firing a transition does to the bounds of a class.

Linear classes bound the times until transitions fire; strong classes bound the times for which transitions
have been enabled. All matrices are in normal form: each bound is the strictest one that follows from all.

References
----------
B. Berthomieu, F. Vernadat, *State class constructions for branching analysis of time Petri nets*, TACAS
2003, LNCS 2619.
"""

from __future__ import annotations

from dineros.analysis.nets.kernel_cache import kernel
from dineros.analysis.timed.kernels.records import UNBOUNDED, ZERO, plus


@kernel()
def least_waits(matrix, clocks, low):  # type: ignore[no-untyped-def]
    """By clock: the bound of how much longer than the first one to fire its transition has to wait."""
    for j in range(1, clocks + 1):
        least = ZERO
        for i in range(1, clocks + 1):
            least = min(least, matrix[i, j])
        low[j] = least


@kernel()
def can_fire_first(matrix, clocks, clock):  # type: ignore[no-untyped-def]
    """Whether a transition of a linear class can fire first; clock 0 stands for one without a clock."""
    can = True
    for i in range(1, clocks + 1):
        can &= matrix[i, clock] >= ZERO
    return can


@kernel()
def linear_ends(upper, lower, enabled, first, kept, start, clocks, matrix, low, clock, ends):  # type: ignore[no-untyped-def]
    """Write the bounds of each clock after a transition of a linear class has fired first, which it can.

    The next marking has so many clocks, from `first` on in `enabled`, from `start` on in `kept`; `ends` has
    a row for the upper bounds and one for the lower ones. `clock` is the number of the transition's clock, 0
    if it has none: it may fire at any time, so what others still have to wait is bounded above by what they
    had to wait before.
    """
    for a in range(clocks):
        i = kept[start + a]
        if i:
            ends[0, a] = matrix[i, clock]
            ends[1, a] = low[i]
        else:
            ends[0, a] = upper[enabled[first + a]]
            ends[1, a] = lower[enabled[first + a]]


@kernel()
def let_time_pass(net, known, matrix, row, clocks, fired, elapsed):  # type: ignore[no-untyped-def]
    """Write the clocks that can be reached by waiting, until `fired` may fire as far as others let it.

    Clocks stay within their latest bounds, and below the earliest bounds of transitions with priority over
    `fired` (-1: priorities do not count). Whether there are any.
    """
    first = known.enabled_start[row]
    elapsed[0, 0] = ZERO
    for i in range(1, clocks + 1):
        elapsed[0, i] = matrix[0, i]
        elapsed[i, 0] = UNBOUNDED
    for k in range(1, clocks + 1):
        transition = known.enabled[first + k - 1]
        limit = net.upper[transition]
        if fired >= 0 and is_above(net, transition, fired):
            limit = min(limit, 1 - net.lower[transition])
        if limit < UNBOUNDED:
            for i in range(1, clocks + 1):
                elapsed[i, 0] = min(elapsed[i, 0], plus(matrix[i, k], limit))
    for i in range(1, clocks + 1):
        if plus(elapsed[i, 0], elapsed[0, i]) < ZERO:
            return False
        for j in range(1, clocks + 1):
            elapsed[i, j] = min(matrix[i, j], plus(elapsed[i, 0], elapsed[0, j]))
        elapsed[i, i] = ZERO
    return True


@kernel()
def is_above(net, transition, fired):  # type: ignore[no-untyped-def]
    """Whether a transition has priority over another."""
    found = False
    for k in range(net.above_start[fired], net.above_start[fired + 1]):
        found |= net.above[k] == transition
    return found


@kernel()
def strong_ends(kept, start, clocks_after, elapsed, clocks, clock, earliest, low, ends):  # type: ignore[no-untyped-def]
    """Write the bounds of each clock after a transition has fired, which it can once time has passed.

    The next marking has so many clocks, from `start` on in `kept`; `ends` has a row for the upper bounds and
    one for the lower ones.
    """
    for j in range(1, clocks + 1):
        low[j] = elapsed[0, j]
    if clock:
        for j in range(1, clocks + 1):
            low[j] = min(low[j], plus(earliest, elapsed[clock, j]))
        low[clock] = min(low[clock], earliest)
    for a in range(clocks_after):
        i = kept[start + a]
        ends[0, a] = elapsed[i, 0] if i else ZERO
        ends[1, a] = low[i] if i else ZERO


@kernel()
def matrix_after(kept, start, clocks, before, ends, result):  # type: ignore[no-untyped-def]
    """Write the matrix of the clocks that continue from another matrix, and of those that start again."""
    result[0, 0] = ZERO
    for a in range(clocks):
        result[a + 1, 0] = ends[0, a]
        result[0, a + 1] = ends[1, a]
    for a in range(clocks):
        i = kept[start + a]
        for b in range(clocks):
            bound = plus(ends[0, a], ends[1, b])
            j = kept[start + b]
            if i and j:
                bound = min(bound, before[i, j])
            result[a + 1, b + 1] = bound
        result[a + 1, a + 1] = ZERO


@kernel()
def keep_below(matrix, clocks, clock, limit):  # type: ignore[no-untyped-def]
    """Keep what has a clock within an upper bound; whether anything is left."""
    if plus(matrix[0, clock], limit) < ZERO:
        return False
    if limit >= matrix[clock, 0]:
        return True
    for i in range(clocks + 1):
        through = plus(matrix[i, clock], limit)
        if through < UNBOUNDED:
            for j in range(clocks + 1):
                if i != j:
                    matrix[i, j] = min(matrix[i, j], plus(through, matrix[0, j]))
    return True


@kernel()
def keep_above_and_forget(matrix, clocks, clock, limit):  # type: ignore[no-untyped-def]
    """Keep what has a clock above a lower bound (of ``0 - x``), forget how far above; whether any is left.

    Once a transition without a latest bound may fire, it does not matter for how long it has been enabled.
    """
    if plus(matrix[clock, 0], limit) < ZERO:
        return False
    if limit < matrix[0, clock]:
        for i in range(clocks + 1):
            through = plus(matrix[i, 0], limit)
            if through < UNBOUNDED:
                for j in range(clocks + 1):
                    if i != j:
                        matrix[i, j] = min(matrix[i, j], plus(through, matrix[clock, j]))
    matrix[0, clock] = limit
    matrix[clock, 0] = UNBOUNDED
    for i in range(1, clocks + 1):
        if i != clock:
            matrix[clock, i] = UNBOUNDED
            matrix[i, clock] = plus(matrix[i, 0], limit)
    return True
