"""Groups of places of which at most one is marked, with one token: found by linear programs.

A weighting y >= 0 whose sum no firing increases, with y . m0 = c, allows at most one token in total on the
places of weight more than c / 2. The largest such group maximises a sum of weights, so each group costs one
program, independent of the number of semiflows.

Many groups may be equally large. If transitions move all of many processes at once, a group may follow one
process before such a transition and another one after it. Diagrams are far smaller if each group stays with
one process, so groups within processes are found first.

References
----------
M. Silva, E. Teruel, J. M. Colom, *Linear algebraic and linear programming techniques for the analysis of
place/transition net systems*, Lectures on Petri Nets I, LNCS 1491, 1998.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Set

import numpy as np

from dineros.analysis.nets.bounds import grows, integer_weights, weighted_sum
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.graph_parts import representatives
from dineros.analysis.nets.linear_programs import LinearProgram

#: Number of processes, at least, and their places, as a part of those of the largest one.
FEWEST_PROCESSES, SMALL_PROCESS = 3, 1 / 2
#: Numbers of neighbours above which elements are taken out, at most, and the part of the processes that each
#: of these elements touches, at least.
MOST_CUTS, TOUCHED = 16, 1 / 2
#: Worth of a place outside of all processes for a group, as a part of that of a place of the process.
OTHERS = 1 / 1024


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
    found = processes(net)
    others = set(range(len(net.places))).difference(*found)
    for process in found:
        while search.add_within(process, others):
            pass
    while search.add(None):
        pass
    # If fractional tokens are optimal, one place is required to be integral.
    for place in sorted(search.free):
        if place in search.free:
            search.add(place)
    return search.groups


def processes(net: CompiledNet) -> list[tuple[int, ...]]:
    """Return the places of each process, if the net has several ones, apart from what most of them share.

    The elements with the most neighbours are taken out: transitions that move all processes at once, and
    places that all of them use. What is connected without them is a process.

    Examples
    --------
    >>> names = [f"{place}{number}" for number in range(3) for place in "abc"]
    >>> moves = [(f"t{i}", {f"b{i}": 1}, {f"c{i}": 1}) for i in range(3)]
    >>> start = ("start", {f"a{i}": 1 for i in range(3)}, {f"b{i}": 1 for i in range(3)})
    >>> net = CompiledNet.build(dict.fromkeys(names, 0), [start, *moves])
    >>> processes(net)
    [(1, 2), (4, 5), (7, 8)]
    """
    size = len(net.places)
    touched = [sorted(net.tested(t) | net.delta[t].keys()) for t in range(len(net.transitions))]
    touching: list[list[int]] = [[] for _ in range(size)]
    for t, places in enumerate(touched):
        for place in places:
            touching[place].append(t)
    numbers = {len(others) for others in (*touched, *touching)}
    best: list[tuple[int, ...]] = []
    for most in sorted(numbers, reverse=True)[1 : MOST_CUTS + 1]:
        kept = {place for place in range(size) if len(touching[place]) <= most}
        few = [t for t, places in enumerate(touched) if len(places) <= most]
        links = ([place for place in touched[t] if place in kept] for t in few)
        first = representatives(sorted(kept), (link for link in links if link))
        groups: defaultdict[int, list[int]] = defaultdict(list)
        for place in sorted(kept):
            groups[first[place]].append(place)
        least = max(2, SMALL_PROCESS * max(map(len, groups.values()), default=0))
        found = [tuple(group) for group in groups.values() if len(group) >= least]
        if len(found) <= max(len(best), FEWEST_PROCESSES - 1):
            continue
        number = {place: n for n, group in enumerate(found) for place in group}
        shared = [set(touched[t]) for t in set(range(len(touched))).difference(few)]
        shared += [set().union(*(touched[t] for t in touching[p])) for p in set(range(size)).difference(kept)]
        if all(len({number[p] for p in near & number.keys()}) >= TOUCHED * len(found) for near in shared):
            best = found
    return best


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
        return self._add(self.free, place)

    def add_within(self, places: Iterable[int], others: Set[int]) -> bool:
        """Search for the group with the most of some places that are free, and with some other ones.

        Return whether there is one.
        """
        within = self.free.intersection(places)
        return len(within) > 1 and self._add(within, None, self.free & others)

    def _add(self, wanted: Set[int], place: int | None, others: Set[int] = frozenset()) -> bool:
        low, costs = np.zeros(len(self._net.places)), np.zeros(len(self._net.places))
        costs[list(wanted)] = -1
        costs[list(others)] = -OTHERS
        if place is not None:
            low[place] = 1
        proposed = self._program.solve(costs, self._limits, low, np.ones(len(self._net.places)))
        if proposed is None:
            return False
        weights = integer_weights(proposed)
        if grows(self._net, weights):
            return False
        total = weighted_sum(self._net, weights)
        group = tuple(sorted(p for p in weights.keys() & (wanted | others) if 2 * weights[p] > total))
        if len(group) < 2:
            return False
        self.groups.append(group)
        self.free.difference_update(group)
        return True
