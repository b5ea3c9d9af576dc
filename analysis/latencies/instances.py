"""The run in which an instance of a path takes longest, with its schedule."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import FiredAt
from dineros.analysis.latencies.markers import DONE, OVER, WATCHING
from dineros.analysis.latencies.measuring import LONGER, Bound, clock_of, times_of
from dineros.analysis.latencies.observer import Observer
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.schedules import Gap, schedule
from dineros.analysis.timed.search import ClassSearch

NEARLY = Fraction(1, 100)
"""Part of the unit of a net by which a schedule misses a greatest time that is not attained."""


@dataclass(frozen=True)
class Instance:
    """A run with an instance that is followed to its end."""

    trace: tuple[int, ...]
    """Transitions of the net without the observer; the last one ends the instance."""
    times: tuple[FiredAt, ...]
    """When each of them fires."""
    began: float
    """When the instance begins, in seconds from the start."""


def longest_instance(observer: Observer, base: TimedNet, longest: Bound, budget: Budget) -> Instance | None:
    """Return a run with an instance that takes longest; None if it is not found within the budget.

    The whole net is searched, so that the run is one of the model: what has no influence on the instance
    fires in it, too.

    Parameters
    ----------
    base
        The net without the observer.
    longest
        The greatest time of an instance. If no instance attains it, one that nearly does is returned.
    """
    limit = clock_of(base)
    while limit <= longest.value:
        limit *= LONGER
    net = observer.net(limit, is_whole=True)
    done, over, watching = (net.untimed.places.index(place) for place in (DONE, OVER, WATCHING))
    search = ClassSearch(
        net, "E" if net.has_priorities else "M", budget.begun(), keeps_parents=True, is_breadth_first=True
    )
    looked = 0
    found: list[int] = []

    def is_met() -> bool:
        nonlocal looked
        first, looked = looked, search.classes
        markings = search.markings()
        ended = (markings[:, done] > 0) & (markings[:, over] == 0)
        fresh = np.flatnonzero(ended[search.marking_of[first:looked]]) + first
        found.extend(n for n in fresh.tolist() if times_of(search, n, limit)[1] == longest)
        return bool(found)

    search.run(is_met)
    if not found and not is_met():
        return None
    trace = search.trace(found[0])
    start = _first_marked(net, trace, watching)
    least = longest.value if longest.is_reached else longest.value - net.unit * NEARLY
    names = [observer.original(net.untimed.transitions[t]) for t in trace]
    index = {name: number for number, name in enumerate(base.untimed.transitions)}
    scheduled = schedule(net, trace, [Gap(start, len(trace), least, False)])
    kept = [(index[name], one) for name, one in zip(names, scheduled, strict=True) if name is not None]
    plain = tuple(transition for transition, _ in kept)
    schedule(base, plain)  # a sequence without a schedule is an error of this program
    times = tuple(
        (float(one.at), float(one.earliest), None if one.latest is None else float(one.latest))
        for _, one in kept
    )
    return Instance(plain, times, float(scheduled[start - 1].at))


def _first_marked(net: TimedNet, trace: tuple[int, ...], place: int) -> int:
    """Return the number of the firing that first marks a place, counted from 1."""
    for number, transition in enumerate(trace, 1):
        if dict(net.put.row(transition)).get(place, 0):
            return number
    raise AssertionError("the clock of the observer runs in each instance")
