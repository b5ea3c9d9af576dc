"""Kernels for what leads into a class, and for cutting a class by it.

All matrices are in normal form, and their rows and columns 0 are those of 0.

References
----------
B. Berthomieu, F. Vernadat, *State class constructions for branching analysis of time Petri nets*, TACAS
2003, LNCS 2619. J. Bengtsson, W. Yi, *Timed automata: semantics, algorithms and tools*, LNCS 3098, 2004.
"""

from __future__ import annotations

from dineros.analysis.nets.kernel_cache import kernel
from dineros.analysis.timed.kernels.domains import is_above
from dineros.analysis.timed.kernels.records import UNBOUNDED, ZERO, plus


@kernel()
def copy(source, clocks, target):  # type: ignore[no-untyped-def]
    """Copy a matrix with this number of clocks."""
    for i in range(clocks + 1):
        for j in range(clocks + 1):
            target[i, j] = source[i, j]


@kernel()
def close(matrix, clocks):  # type: ignore[no-untyped-def]
    """Bring a matrix into normal form; whether it allows anything."""
    for k in range(clocks + 1):
        for i in range(clocks + 1):
            through = matrix[i, k]
            if through < UNBOUNDED and i != k:
                for j in range(clocks + 1):
                    matrix[i, j] = min(matrix[i, j], plus(through, matrix[k, j]))
                if matrix[i, i] < ZERO:
                    return False
    return True


@kernel()
def tighten(matrix, clocks, i, j, limit):  # type: ignore[no-untyped-def]
    """Bound one difference of a matrix in normal form; whether anything is left."""
    if limit >= matrix[i, j]:
        return True
    if plus(matrix[j, i], limit) < ZERO:
        return False
    for a in range(clocks + 1):
        through = plus(matrix[a, i], limit)
        if through < UNBOUNDED:
            for b in range(clocks + 1):
                if a != b:
                    matrix[a, b] = min(matrix[a, b], plus(through, matrix[j, b]))
    return True


@kernel()
def lead_into(net, known, row, at, class_after, result):  # type: ignore[no-untyped-def]
    """Write the clocks from which a transition leads into a class after some time; whether there are any.

    `at` is the position of the transition among those enabled in the marking `row`. Clocks that start again
    are 0; all clocks stay within their latest bounds until the transition fires, and below the earliest
    bounds of those with priority over it.
    """
    first, clocks = known.enabled_start[row], known.clocks[row]
    fired, after, kept = known.enabled[at], known.next_marking[at], known.kept_start[at]
    count = known.clocks[after]
    for i in range(clocks + 1):
        for j in range(clocks + 1):
            result[i, j] = UNBOUNDED
        result[i, i] = ZERO
    for i in range(1, clocks + 1):
        transition = known.enabled[first + i - 1]
        result[i, 0] = net.upper[transition]
        result[0, i] = net.lower[transition] if transition == fired else ZERO
        if net.above.size and is_above(net, transition, fired):
            result[i, 0] = min(result[i, 0], 1 - net.lower[transition])
    # A clock that starts again has the row and column of 0, as 0 itself has.
    for a in range(count + 1):
        i = known.kept[kept + a - 1] if a else 0
        for b in range(count + 1):
            j = known.kept[kept + b - 1] if b else 0
            result[i, j] = min(result[i, j], class_after[a, b])
    if result[0, 0] < ZERO or not close(result, clocks):
        return False
    for i in range(1, clocks + 1):
        least = ZERO
        for j in range(1, clocks + 1):
            least = min(least, result[j, i])
        result[0, i] = least
    return True


@kernel()
def allows_all(larger, clocks, smaller):  # type: ignore[no-untyped-def]
    """Whether a matrix allows all that another in normal form allows."""
    for i in range(clocks + 1):
        for j in range(clocks + 1):
            if smaller[i, j] > larger[i, j]:
                return False
    return True


@kernel()
def are_apart(one, clocks, other):  # type: ignore[no-untyped-def]
    """Whether bounds of two matrices exclude each other; if not, the two may still have nothing in common."""
    for i in range(clocks + 1):
        for j in range(clocks + 1):
            if plus(one[i, j], other[j, i]) < ZERO:
                return True
    return False


@kernel()
def needed_bounds(matrix, clocks, other, facets, room):  # type: ignore[no-untyped-def]
    """Write which bounds of another matrix cut a class, without those that follow from the rest.

    Only these may cut it: an implied bound may cut at an irrelevant place.

    Returns
    -------
    int
        How many; each is a row and a column in `facets`. -1 if the two have nothing in common.
    """
    size = clocks + 1
    found = 0
    for i in range(size):
        for j in range(size):
            if other[i, j] < matrix[i, j]:
                facets[found, 0], facets[found, 1] = i, j
                found += 1
    copy(matrix, clocks, room)
    for f in range(found):
        i, j = facets[f, 0], facets[f, 1]
        if not tighten(room, clocks, i, j, other[i, j]):
            return -1
    f = 0
    while f < found and found > 1:
        copy(matrix, clocks, room)
        for g in range(found):
            if g != f:
                tighten(room, clocks, facets[g, 0], facets[g, 1], other[facets[g, 0], facets[g, 1]])
        if room[facets[f, 0], facets[f, 1]] <= other[facets[f, 0], facets[f, 1]]:
            for g in range(f + 1, found):
                facets[g - 1, 0], facets[g - 1, 1] = facets[g, 0], facets[g, 1]
            found -= 1
        else:
            f += 1
    return found
