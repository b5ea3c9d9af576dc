"""Random runs of time Petri nets: each clock draws when it fires, uniformly from its interval.

A transition without a latest time may wait forever. The steps of callbacks draw from an exponential
distribution then, since work waits for them; all others, such as losses and requests from outside, do not
fire. So each run is one of the net, in which some things never happen.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from heapq import heappop, heappush
from random import Random

from dineros.analysis.timed.nets import TimedNet

MOST_AT_ONCE = 100_000
"""Firings at one moment, after which time counts as stopped."""


class TimeStopsError(Exception):
    """Transitions fire repeatedly, and time does not advance."""


class DrawnRun:
    """One run of a net.

    Parameters
    ----------
    net : TimedNet
        The net, in seconds.
    seed : int
        Of all that is drawn.
    steps : set of int
        Transitions without a latest time that fire all the same.
    mean : float
        The mean time after which they do.
    """

    def __init__(self, net: TimedNet, seed: int, steps: frozenset[int], mean: float) -> None:
        self._draw = Random(seed)
        self._steps, self._mean = steps, mean
        untimed = net.untimed
        count = len(untimed.transitions)
        self._take = [net.take.row(t) for t in range(count)]
        self._put = [net.put.row(t) for t in range(count)]
        self._test = [net.untimed.pre.row(t) for t in range(count)]
        self._inhibit = [untimed.inhibitor.row(t) for t in range(count)]
        self._bounds = [
            (float(each.earliest), None if each.latest is None else float(each.latest))
            for each in net.intervals
        ]
        self._above = net.above
        self._is_above = {high for highs in net.above for high in highs}
        self._marking = [int(tokens) for tokens in untimed.initial]
        asks: list[set[int]] = [set() for _ in untimed.places]
        for transition in range(count):
            for place, _ in (*self._test[transition], *self._inhibit[transition]):
                asks[place].add(transition)
        self._touched = [
            sorted({u for place, _ in (*self._take[t], *self._put[t]) for u in asks[place]} | {t})
            for t in range(count)
        ]
        self._since: dict[int, float] = {}
        self._version = [0] * count
        self._queue: list[tuple[float, float, int, int]] = []
        self.now = 0.0
        for transition in range(count):
            if self._is_enabled(transition):
                self._start(transition)

    def _is_enabled(self, transition: int) -> bool:
        marking = self._marking
        for place, weight in self._test[transition]:
            if marking[place] < weight:
                return False
        return all(marking[place] < weight for place, weight in self._inhibit[transition])

    def _start(self, transition: int) -> None:
        earliest, latest = self._bounds[transition]
        self._since[transition] = self.now
        if transition in self._is_above:  # others would wait past their latest times
            wait = earliest
        elif latest is not None:
            wait = earliest if earliest == latest else self._draw.uniform(earliest, latest)
        elif transition in self._steps:
            wait = earliest + self._draw.expovariate(1 / self._mean)
        else:
            return
        entry = self.now + wait, self._draw.random(), transition, self._version[transition]
        heappush(self._queue, entry)

    def firings(self, seconds: float) -> Iterator[tuple[int, float]]:
        """Yield what fires within a number of seconds, and when.

        Raises
        ------
        TimeStopsError
            Time does not advance.
        """
        queue, version, since = self._queue, self._version, self._since
        marking, at_once = self._marking, 0
        while queue and queue[0][0] <= seconds:
            time, _, transition, number = heappop(queue)
            if number != version[transition]:
                continue
            at_once = at_once + 1 if time <= self.now else 0
            if at_once > MOST_AT_ONCE:
                raise TimeStopsError
            self.now = max(self.now, time)
            if self._above[transition]:
                higher = self._overriding(transition)
                if higher is not None:  # it fires first, and this one right after it if it still can
                    heappush(queue, (self.now, self._draw.random(), transition, number))
                    transition = higher
            for place, weight in self._take[transition]:
                marking[place] -= weight
            touched = self._touched[transition]
            for other in touched:
                if other in since and (other == transition or not self._is_enabled(other)):
                    del since[other]
                    version[other] += 1
            for place, weight in self._put[transition]:
                marking[place] += weight
            yield transition, self.now
            for other in touched:
                if self._is_enabled(other):
                    if other not in since:
                        self._start(other)
                elif other in since:
                    del since[other]
                    version[other] += 1

    def _overriding(self, transition: int) -> int | None:
        """Return a transition with priority that could fire at this moment."""
        for high in self._above[transition]:
            if high in self._since and self.now - self._since[high] >= self._bounds[high][0]:
                return self._overriding(high) or high
        return None


def mean_of(net: TimedNet) -> float:
    """Return a time as steps of a net take: the mean of the latest bounds above 0; 0.001 without any."""
    latest = [float(each.latest) for each in net.intervals if each.latest]
    return sum(latest) / len(latest) if latest and math.isfinite(sum(latest)) else 0.001
