"""Rules that make a time Petri net smaller, and change nothing that can be observed at any time.

Each rule removes what never decides anything: a transition that never fires, a place that never disables one
alone, a transition that another one stands in for. Firings do not move in time. So the two nets have the
same runs at the same times, seen at the places and transitions that are kept.

Clocks are why fewer rules hold with times than without. A transition keeps its clock while another one fires
only if it is enabled by the tokens that are left when those of the firing are taken. So a place may go only
if it does not decide that either, and of two equal transitions one may go only if their clocks agree.

References
----------
G. Berthelot, *Transformations and decompositions of nets*, Advances in Petri Nets 1986, LNCS 254, 1987. R. H.
Sloan, U. Buy, *Reduction rules for time Petri nets*, Acta Informatica 33, 1996.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from math import ceil
from typing import ClassVar

from dineros.analysis.reductions import PROOFS_OF_DEATH, reduce
from dineros.analysis.reductions.places import LARGEST_PROGRAM
from dineros.analysis.reductions.sampling import sampled
from dineros.analysis.timed.nets import Interval
from dineros.analysis.timed.reductions.net import SmallerNet, TimedArcs

Observed = frozenset[str]
"""Places and transitions that stay."""


class TimedRule(ABC):
    """A rule: what it can remove from a net.

    Attributes
    ----------
    is_place : bool
        Whether it removes places; else transitions.
    """

    is_place: ClassVar[bool] = False

    @property
    def name(self) -> str:
        """Name of the rule, as steps show it."""
        return type(self).__name__

    @abstractmethod
    def removable(self, net: SmallerNet, observed: Observed) -> Iterator[str]:
        """Yield what can be removed, one by one; each is removed before the next one is asked for."""


class NeverEnabled(TimedRule):
    """Remove a transition that no marking enables, not even without times.

    *Proof.* The net without times has all markings of the net with times. A transition that is never
    enabled has no running clock, forces no firing, and has priority over none.
    """

    def removable(self, net: SmallerNet, observed: Observed) -> Iterator[str]:
        """Yield what the rules for nets without times prove to be dead: by structure, or by weights."""
        kept = observed & net.transitions.keys()
        found = reduce(net.compile().untimed, (), observed_transitions=kept, rules=PROOFS_OF_DEATH)
        for step in found.steps:
            yield from step.transitions


class Overtaken(TimedRule):
    """Remove a transition that another one always overtakes.

    *Proof.* Let u be enabled whenever t is, with a latest time before the earliest one of t. After u took its
    tokens, t is never enabled. So whenever the clock of u starts again while t is enabled, that of t does,
    too: the clock of u is never behind that of t. Time does not pass the latest time of u, so t never fires;
    nor does it force or forbid anything, as u is forced before.
    """

    def removable(self, net: SmallerNet, observed: Observed) -> Iterator[str]:
        """Yield what is overtaken."""
        for name, arcs in list(net.transitions.items()):
            if name in observed or net.under(name):
                continue
            if any(
                other != name
                and _is_before(faster.interval, arcs.interval)
                and _is_easier(faster, arcs)
                and net.excludes_twice(other, name)
                for other, faster in net.transitions.items()
            ):
                yield name


class StandsIn(TimedRule):
    """Remove a transition if another one does the same at the same times, and at more.

    *Proof.* Let t and u have the same arcs, the same priorities, and u an interval that begins no later and
    ends no later. If neither is enabled any more after its tokens are taken, both clocks start at the same
    moments. If both have no interval, clocks do not matter. So u can fire whenever t can, with the same
    effect, and t forces nothing that u does not.
    """

    def removable(self, net: SmallerNet, observed: Observed) -> Iterator[str]:
        """Yield what another transition stands in for; of equal ones, the first stays."""
        families: dict[object, list[str]] = {}
        for name, arcs in net.transitions.items():
            rows = (arcs.take, arcs.put, arcs.test, arcs.inhibitors)
            key = tuple(frozenset(row.items()) for row in rows)
            if name not in observed:
                families.setdefault(key, []).append(name)
        for family in families.values():
            for name in reversed(family):
                if any(self._does(net, other, name) for other in family if other != name):
                    yield name

    @staticmethod
    def _does(net: SmallerNet, other: str, name: str) -> bool:
        if other not in net.transitions or name not in net.transitions:
            return False
        mine, theirs = net.transitions[name], net.transitions[other]
        if mine.above - {other} != theirs.above - {name} or net.under(name) != net.under(other):
            return False
        if mine.interval.is_free and theirs.interval.is_free:
            return True
        return _is_no_later(theirs.interval, mine.interval) and net.excludes_twice(name, other)


class Untested(TimedRule):
    """Remove a place that no transition tests.

    *Proof.* Its tokens decide nothing.
    """

    is_place = True

    def removable(self, net: SmallerNet, observed: Observed) -> Iterator[str]:
        """Yield places that only receive tokens, or that hold what everything asks of them forever."""
        for place, tokens in list(net.places.items()):
            if place not in observed and all(
                (place not in arcs.test and place not in arcs.inhibitors)
                or _holds_forever(net, place, tokens)
                for arcs in net.transitions.values()
            ):
                yield place


class NeverDecides(TimedRule):
    """Remove a place that never disables a transition alone, also not for a moment.

    *Proof.* The state equation bounds the tokens of the place from below: in all markings in which the other
    places enable t, and in those in which the other places enable u and, after its tokens are taken, t. In
    the first, the place has enough for t; in the second, for u and t together. So without the place the same
    is enabled, and the same clocks continue.
    """

    is_place = True

    def removable(self, net: SmallerNet, observed: Observed) -> Iterator[str]:
        """Yield places whose tokens are always enough."""
        if max(len(net.places), len(net.transitions)) > LARGEST_PROGRAM:
            return
        for place in list(net.places):
            arcs = net.transitions.values()
            if place in observed or any(place in one.inhibitors for one in arcs):
                continue
            if place in sampled(net.plain).deciding_places:
                continue
            if all(self._is_enough(net, place, name) for name in net.transitions):
                yield place

    @staticmethod
    def _is_enough(net: SmallerNet, place: str, name: str) -> bool:
        arcs = net.transitions[name]
        needed = arcs.test.get(place, 0)
        if not needed:
            return True
        others = {p: w for p, w in arcs.test.items() if p != place}
        if not _has(net, place, others, needed):
            return False
        for other, first in net.transitions.items():
            taken = first.take.get(place, 0)
            if other == name or not taken:
                continue
            guard = {p: w for p, w in first.test.items() if p != place}
            for p, weight in others.items():
                guard[p] = max(guard.get(p, 0), first.take.get(p, 0) + weight)
            if not _has(net, place, guard, taken + needed):
                return False
        return True


RULES: tuple[TimedRule, ...] = (NeverEnabled(), Overtaken(), StandsIn(), Untested(), NeverDecides())
"""All rules, in the order in which they are tried."""


def _has(net: SmallerNet, place: str, guard: dict[str, int], needed: int) -> bool:
    """Whether a place has enough tokens in each marking that has the guard's tokens on other places."""
    if net.bounds.excludes(guard):
        return True
    least = net.bounds.least(place, guard)
    return least is not None and ceil(least) >= needed


def _holds_forever(net: SmallerNet, place: str, tokens: int) -> bool:
    """Whether no transition changes a place, not even temporarily, and all conditions on it hold."""
    return all(
        place not in arcs.take
        and place not in arcs.put
        and arcs.test.get(place, 0) <= tokens < arcs.inhibitors.get(place, tokens + 1)
        for arcs in net.transitions.values()
    )


def _is_easier(easy: TimedArcs, hard: TimedArcs) -> bool:
    """Whether the first is enabled whenever the second is, seen by the arcs alone."""
    return all(hard.test.get(p, 0) >= w for p, w in easy.test.items()) and all(
        hard.inhibitors.get(p, w + 1) <= w for p, w in easy.inhibitors.items()
    )


def _is_before(one: Interval, other: Interval) -> bool:
    """Whether an interval ends before another one begins."""
    if one.latest is None or one.latest > other.earliest:
        return False
    return one.latest < other.earliest or one.is_open_above or other.is_open_below


def _is_no_later(one: Interval, other: Interval) -> bool:
    """Whether an interval begins and ends no later than another one."""
    begins = (one.earliest, one.is_open_below) <= (other.earliest, other.is_open_below)
    if one.latest is None or other.latest is None:
        return begins and other.latest is None
    return begins and (one.latest, not one.is_open_above) <= (other.latest, not other.is_open_above)
