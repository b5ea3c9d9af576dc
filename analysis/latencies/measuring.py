"""How long the instances of a path take: read from the clock of an observer in all state classes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from dineros.analysis.answers.budget import Budget
from dineros.analysis.latencies.markers import DONE, GO, LOST, OVER
from dineros.analysis.latencies.observer import Observer
from dineros.analysis.timed.classes import Kind
from dineros.analysis.timed.exploring import SEARCH_REASONS
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.search import ClassSearch

LONGER = 8
"""How much longer the clock runs where instances take longer than it does."""
MOST_ROUNDS = 3


@dataclass(frozen=True)
class Bound:
    """A bound of times."""

    value: Fraction
    """Exact, in seconds."""
    is_reached: bool = True
    """Whether an instance takes exactly so long."""


@dataclass(frozen=True)
class Measured:
    """What was measured."""

    least: Bound | None
    greatest: Bound | None
    """`least`, `greatest`: of all instances that end. `least` is None if no instance ends. `greatest` is None
    then, too, and if nothing bounds the times.
    """
    is_lost: bool
    """Whether an instance can be lost."""
    is_complete: bool
    """Whether that holds for all instances."""
    reason: str = ""
    """The reason if the search is incomplete, or if no greatest time exists; otherwise empty."""
    states: int = 0
    """State classes."""
    is_gone: bool = False
    """Whether an instance can end before the path does: a callback does not publish."""


def measured(observer: Observer, base: TimedNet, budget: Budget, missing: str = "") -> Measured:
    """Measure all instances that an observer can follow.

    Parameters
    ----------
    base
        The net without the observer.
    missing
        A time that the model does not give. Then only the least time is measured.
    """
    budget = budget.begun()
    limit = clock_of(base)
    if missing:
        found = _searched(observer.net(limit), limit, budget, stops=False)
        assert found is not None
        return replace(found, greatest=None, reason=missing)
    for _ in range(MOST_ROUNDS):
        found = _searched(observer.net(limit), limit, budget)
        if found is not None:
            return found
        limit *= LONGER
    return Measured(None, None, False, False, f"some instances take longer than {float(limit / LONGER):g} s")


def clock_of(base: TimedNet) -> Fraction:
    """Return how long the clock of an observer runs at first, in seconds."""
    latest = (each.latest or each.earliest for each in base.intervals)
    return 2 * base.unit + 2 * sum(latest, start=Fraction(0))


def _searched(net: TimedNet, limit: Fraction, budget: Budget, stops: bool = True) -> Measured | None:
    """Search all classes; None if an instance takes as long as the clock runs, and the search stops there."""
    names = net.untimed.places
    done, go, over = (names.index(place) for place in (DONE, GO, OVER))
    lost = names.index(LOST)
    kind: Kind = "E" if net.has_priorities else "M"
    search = ClassSearch(net, kind, budget, keeps_parents=True, is_breadth_first=True)
    looked = 0

    def is_late() -> bool:
        nonlocal looked
        fresh = search.markings(looked)
        looked += len(fresh)
        return bool(((fresh[:, over] > 0) & (fresh[:, go] > 0)).any())

    search.run(is_late if stops else None)
    if stops and (is_late() or _is_late(search, over, go)):
        return None
    markings = search.markings()
    ended = np.flatnonzero((markings[:, done] > 0) & (markings[:, over] == 0))
    classes = np.flatnonzero(np.isin(search.marking_of, ended))
    times = [times_of(search, int(number), limit) for number in classes]
    least = min((each[0] for each in times), key=lambda b: (b.value, not b.is_reached), default=None)
    greatest = max((each[1] for each in times), key=lambda b: (b.value, b.is_reached), default=None)
    return Measured(
        least,
        greatest,
        bool((markings[:, lost] > 0).any()),
        search.is_done,
        "" if search.is_done else SEARCH_REASONS.get(str(search.reason), str(search.reason)),
        search.classes,
        bool((markings[:, [go, done, lost, over]].sum(axis=1) == 0).any()),
    )


def _is_late(search: ClassSearch, over: int, go: int) -> bool:
    markings = search.markings()
    return bool(((markings[:, over] > 0) & (markings[:, go] > 0)).any())


def times_of(search: ClassSearch, number: int, limit: Fraction) -> tuple[Bound, Bound]:
    """Return how long the instance has taken that ends in a class: only the observer's clock runs there.

    A linear class says in how much time the clock ends, a strong one how much time it has counted.
    """
    first = int(search.known.record_start[number])
    upper, lower = (int(search.known.codes[first + at]) for at in (0, 1))
    most = Bound((upper >> 1) * search.net.unit, bool(upper & 1))
    least = Bound(-(lower >> 1) * search.net.unit, bool(lower & 1))
    if search.is_strong:
        return least, most
    return Bound(limit - most.value, most.is_reached), Bound(limit - least.value, least.is_reached)
