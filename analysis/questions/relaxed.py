"""A net without its times and without what only times bound: it can do more, and has a bounded rest.

A timer strikes again and again. Without times nothing keeps its strikes from piling up, so that the place of
strikes has no bound. Without the arcs of such places the net can do all that it could, and more: what never
happens then never happens. With times, such a place is often bounded after all; see `bounds_in_time`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.syntax import And, Enabled, Formula, Name, Not
from dineros.analysis.nets.bounds import flows_and_bounds
from dineros.analysis.nets.compiled import ArcTable, CompiledNet
from dineros.analysis.nets.linear_programs import LinearProgram, in_whole_numbers
from dineros.analysis.portfolio.asking import find_marking
from dineros.analysis.timed.nets import TimedNet


@dataclass(frozen=True)
class Relaxed:
    """A net without the arcs of places that no weighted sum of tokens bounds.

    Attributes
    ----------
    net : CompiledNet
        It; places and transitions are numbered as before.
    places : frozenset of int
        Those without arcs.
    transitions : frozenset of int
        Those that may be enabled more often than before.
    """

    net: CompiledNet
    places: frozenset[int]
    transitions: frozenset[int]

    def some_is_enabled(self, among: Iterable[int], budget: Budget) -> bool:
        """Return whether it is proved that each reachable marking enables one of some transitions."""
        names = self.net.transitions
        none: list[Formula] = [Not(Enabled(Name(names[t]))) for t in among]
        if not none:
            return False
        condition = And(tuple(none)) if len(none) > 1 else none[0]
        return find_marking(self.net, condition, NetNames(self.net), budget).status == "unreachable"


def relaxed(net: CompiledNet) -> Relaxed:
    """Return a net without the arcs of places that no weighted sum of tokens bounds."""
    _, bounds = net.once(flows_and_bounds)
    free = frozenset(place for place, bound in enumerate(bounds) if bound is None)
    if not free:
        return Relaxed(net, free, frozenset())
    every = range(len(net.transitions))
    needing = frozenset(
        t for t in every for place, _ in (*net.pre.row(t), *net.inhibitor.row(t)) if place in free
    )
    pre, post, inhibitor = (
        ArcTable.from_rows([{p: w for p, w in table.row(t) if p not in free} for t in every])
        for table in (net.pre, net.post, net.inhibitor)
    )
    return Relaxed(replace(net, pre=pre, post=post, inhibitor=inhibitor), free, needing)


def bounds_in_time(
    net: TimedNet, loose: Relaxed, signals: frozenset[int], budget: Budget
) -> dict[int, int | None]:
    """Return how many tokens places without arcs can hold with times; None where nothing proves a bound.

    Inhibitor arcs may limit what is put there. Or each marking enables a transition that takes a token from
    the place at once: then no time passes while it is marked. Such a transition must not depend on another
    place without arcs, which may be empty. So at the beginning of each moment the place is empty, or as in
    the initial marking. Within a moment, a transition that has to wait after each firing fires once at most.
    A weighted sum of tokens that no other transition increases bounds what comes.

    Parameters
    ----------
    loose : Relaxed
        The same without them.
    signals : frozenset of int
        Transitions that signals may keep from firing, which `net` does not know of.
    """
    found: dict[int, int | None] = dict.fromkeys(sorted(loose.places))
    if net.has_priorities:
        return found
    found = {place: _limited(net.untimed, place) for place in found}
    taken_at_once = [
        place
        for place, limit in found.items()
        if limit is None and loose.some_is_enabled(_takers(net, loose, place, signals), budget)
    ]
    sums = _Sums(net, found, taken_at_once)
    return found | {place: sums.bound(place) for place in taken_at_once}


def _takers(net: TimedNet, loose: Relaxed, place: int, signals: frozenset[int]) -> list[int]:
    """Return the transitions that take a token from a place at once, and need no other place without arcs."""
    found = []
    for t, interval in enumerate(net.intervals):
        if interval.latest != 0 or t in signals:
            continue
        take, test, inhibitors = (
            dict(table.row(t)) for table in (net.take, net.untimed.pre, net.untimed.inhibitor)
        )
        depends_on = (test.keys() | inhibitors.keys()) & loose.places
        if take.get(place) == 1 and test[place] == 1 and place not in inhibitors and depends_on == {place}:
            found.append(t)
    return found


class _Sums:
    """Weighted sums of tokens that grow in a moment only by transitions that have to wait after each firing.

    Parameters
    ----------
    known : mapping
        Bounds of places without arcs; None of those whose tokens may not count in a sum.
    taken_at_once : sequence of int
        Those of them that are empty at the beginning of each moment, or as in the initial marking.
    """

    def __init__(self, net: TimedNet, known: Mapping[int, int | None], taken_at_once: Sequence[int]) -> None:
        self._net, every = net.untimed, range(len(net.intervals))
        at_once = [t for t in every if net.intervals[t].earliest <= 0]
        self._later = [t for t in every if net.intervals[t].earliest > 0]
        _, bounds = net.untimed.once(flows_and_bounds)
        self._at_first: list[int | None] = []
        for place, bound in enumerate(bounds):
            least = known.get(place) if bound is None else bound.value
            self._at_first.append(int(self._net.initial[place]) if place in taken_at_once else least)
        self._rows = len(at_once)
        self._at_once = at_once
        rows = [{p: float(n) for p, n in self._net.delta[t].items()} for t in at_once]
        self._program = LinearProgram(rows, len(bounds), is_warm=False)

    def bound(self, place: int) -> int | None:
        """Return how many tokens a place can hold; None if no such sum bounds it."""
        costs = np.array([0.0 if at_first is None else 1.0 + at_first for at_first in self._at_first])
        high = np.array([0.0 if at_first is None else np.inf for at_first in self._at_first])
        low = np.zeros(len(costs))
        low[place] = 1.0
        proposed = self._program.solve(costs, np.zeros(self._rows), low, high)
        if proposed is None:
            return None
        weights, _ = in_whole_numbers(proposed)
        if weights[place] <= 0 or any(weight < 0 for weight in weights):
            return None
        if any(self._grows(weights, t) > 0 for t in self._at_once):
            return None
        total = sum(max(0, self._grows(weights, t)) for t in self._later)
        for weight, at_first in zip(weights, self._at_first, strict=True):
            if weight and at_first is None:
                return None
            total += weight * (at_first or 0)
        return total // weights[place]

    def _grows(self, weights: Sequence[int], transition: int) -> int:
        return sum(weights[place] * change for place, change in self._net.delta[transition].items())


def _limited(net: CompiledNet, place: int) -> int | None:
    """Return how many tokens inhibitor arcs let a place hold; None if a transition puts some without one."""
    most = int(net.initial[place])
    for t, change in enumerate(net.delta):
        put = change.get(place, 0)
        if put > 0:
            limit = dict(net.inhibitor.row(t)).get(place)
            if limit is None:
                return None
            most = max(most, limit - 1 + put)
    return most
