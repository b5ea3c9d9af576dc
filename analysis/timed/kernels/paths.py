"""Kernel of longest paths, by Bellman and Ford, in the order of Yen: arcs forwards, then arcs backwards."""

from __future__ import annotations

from dineros.analysis.nets.kernel_cache import kernel


@kernel()
def lengthen(length, reached, source, target, least):  # type: ignore[no-untyped-def]
    """Find the longest paths from the variables that are reached; return whether they are finite.

    Parameters
    ----------
    length : int64 array, shape (variables,)
        The longest path to each variable known so far; gets the longest one.
    reached : bool array, shape (variables,)
        Whether there is a path to a variable.
    source, target, least : int64 arrays, shape (arcs,)
        Arcs: forward ones first, by ascending source; then backward ones, by descending source.
    """
    for _ in range(len(length) + 1):
        has_changed = False
        for arc in range(len(source)):
            start, end = source[arc], target[arc]
            if reached[start] and (not reached[end] or length[start] + least[arc] > length[end]):
                length[end] = length[start] + least[arc]
                reached[end] = True
                has_changed = True
        if not has_changed:
            return True
    return False
