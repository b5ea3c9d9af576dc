"""Properties of single places, read from a decision diagram of all markings."""

from __future__ import annotations

from dineros.analysis.symbolic.engine import SymbolicStateSpace


def is_stable(space: SymbolicStateSpace, place: int) -> bool:
    """Return whether a place (by number) holds the same number of tokens in all markings."""
    most: list[int] = []
    for sign in (1, -1):
        weights, constant = space.weights_of({place: sign})
        most.append(constant + space.counts.largest(weights))
    return most[0] == -most[1]
