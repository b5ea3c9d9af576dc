"""Groups of places of which at most one is marked, with one token: found by linear programs.

A weighting y >= 0 whose sum no firing increases, with y . m0 = c, allows at most one token in total on the
places of weight more than c / 2. The largest such group maximises a sum of weights, so each group costs one
program, independent of the number of semiflows.

References
----------
M. Silva, E. Teruel, J. M. Colom, *Linear algebraic and linear programming techniques for the analysis of
place/transition net systems*, Lectures on Petri Nets I, LNCS 1491, 1998.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from dineros.analysis.nets.bounds import grows, integer_weights, weighted_sum
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.linear_programs import LinearProgram


def state_machines(net: CompiledNet, places: Iterable[int]) -> list[tuple[int, ...]]:
    """Disjoint groups of two or more of some places that have at most one token together, large ones first.

    Examples
    --------
    >>> net = CompiledNet.build({"a": 1, "b": 0, "c": 2},
    ...     [("t", {"a": 1}, {"b": 1}), ("u", {"b": 1, "c": 1}, {"a": 1, "c": 1})])
    >>> state_machines(net, range(3))
    [(0, 1)]
    """
    search = _GroupSearch(net, places)
    while search.add(None):
        pass
    # If fractional tokens are optimal, one place is required to be integral.
    for place in sorted(search.free):
        if place in search.free:
            search.add(place)
    return search.groups


class _GroupSearch:
    """The groups so far, and the free places."""

    def __init__(self, net: CompiledNet, places: Iterable[int]) -> None:
        self._net = net
        initial = {p: int(net.initial[p]) for p in np.flatnonzero(net.initial).tolist()}
        # Diagrams grow if groups do not fit together: the result must not depend on earlier solutions.
        self._program = LinearProgram([*net.delta, initial], len(net.places), is_warm=False)
        self._limits = np.zeros(len(net.delta) + 1)
        self._limits[-1] = 1
        self.free = set(places)
        self.groups: list[tuple[int, ...]] = []

    def add(self, place: int | None) -> bool:
        """Search for the largest group of free places, with `place` if given; return whether there is one."""
        low, costs = np.zeros(len(self._net.places)), np.zeros(len(self._net.places))
        costs[list(self.free)] = -1
        if place is not None:
            low[place] = 1
        proposed = self._program.solve(costs, self._limits, low, np.ones(len(self._net.places)))
        if proposed is None:
            return False
        weights = integer_weights(proposed)
        if grows(self._net, weights):
            return False
        total = weighted_sum(self._net, weights)
        group = tuple(sorted(p for p in weights.keys() & self.free if 2 * weights[p] > total))
        if len(group) < 2:
            return False
        self.groups.append(group)
        self.free.difference_update(group)
        return True
