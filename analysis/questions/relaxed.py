"""A net without its times and without what only times bound: it can do more, and has a bounded rest.

A timer strikes again and again. Without times nothing keeps its strikes from piling up, so that the place of
strikes has no bound. Without the arcs of such places the net can do all that it could, and more: what never
happens then never happens. With times, such a place is often bounded after all; see `bound_in_time`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.syntax import And, Enabled, Formula, Name, Not
from dineros.analysis.nets.bounds import flows_and_bounds
from dineros.analysis.nets.compiled import ArcTable, CompiledNet
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


def bound_in_time(
    net: TimedNet, loose: Relaxed, place: int, signals: frozenset[int], budget: Budget
) -> int | None:
    """Return how many tokens a place without arcs can hold with times; None if nothing proves a bound.

    Inhibitor arcs may limit what is put there. Or each marking enables a transition that takes a token from
    the place at once: then no time passes while it is marked. Such a transition must not depend on another
    place without arcs, which may be empty. Within a moment each transition that puts some there fires once,
    as it has to wait after each firing, or no more often than it has tokens that nothing puts back.

    Parameters
    ----------
    net : TimedNet
        The net with its times.
    loose : Relaxed
        The same without them.
    place : int
        The place.
    signals : frozenset of int
        Transitions that signals may keep from firing, which `net` does not know of.
    budget : Budget
        Limits.
    """
    if net.has_priorities:
        return None
    every = range(len(net.untimed.transitions))
    limited = _limited(net.untimed, place)
    if limited is not None:
        return limited
    fed = {p for t in every for p, _ in net.put.row(t)}
    most, takers = int(net.untimed.initial[place]), []
    for t in every:
        take, put, test = (dict(table.row(t)) for table in (net.take, net.put, net.test))
        if put.get(place, 0):
            once = [int(net.untimed.initial[p]) // weight for p, weight in take.items() if p not in fed]
            if net.intervals[t].earliest <= 0 and not once:
                return None
            most += put[place] * (1 if net.intervals[t].earliest > 0 else min(once))
        elif take.get(place) == 1 and test[place] == 1 and net.intervals[t].latest == 0 and t not in signals:
            inhibitors = dict(net.untimed.inhibitor.row(t))
            depends_on = (test.keys() | inhibitors.keys()) & loose.places
            if depends_on == {place} and place not in inhibitors:
                takers.append(t)
    return most if loose.some_is_enabled(takers, budget) else None


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
