"""Times of a simulated run: how long callbacks respond, and how long data takes, as quantiles."""

from __future__ import annotations

from array import array
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from dineros.analysis.answers.outcome import FiredAt
from dineros.analysis.latencies.answers import require_times
from dineros.analysis.latencies.parts import Parts
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.analysis.timed_runs.drawing import DrawnRun, TimeStopsError, mean_of
from dineros.analysis.timed_runs.following import Following
from dineros.analysis.witnesses.witness import Witness, witness_of
from dineros.metamodel import sym
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.times.given import duration_of, latency_between

BINS = 20
"""Bars of a histogram."""
MOST_FIRINGS = 20_000_000
"""After which a simulation ends."""


@dataclass
class SimulatedTimes:
    """The times of one chain."""

    first: str
    last: str
    """`first`, `last`: ids of the callbacks where it begins and ends; the same: a response time."""
    values: array[float] = field(default_factory=lambda: array("d"))
    """Seconds, in the order in which the instances ended."""


def histogram(values: Sequence[float]) -> dict[str, Any]:
    """Return bars of equal width: their least and greatest bounds, and how many values are in each.

    Examples
    --------
    >>> histogram([0.0, 0.5, 1.0])["counts"][0]
    1
    """
    least, greatest = min(values), max(values)
    width = (greatest - least) / BINS
    counts = [0] * BINS
    for value in values:
        counts[min(BINS - 1, int((value - least) / width)) if width else 0] += 1
    return {"least": least, "greatest": greatest, "counts": counts}


@dataclass
class Simulated:
    """What a simulation measured."""

    seconds: float
    """How long it went on, in simulated time."""
    firings: int = 0
    """Of the net with times."""
    times: dict[tuple[str, str], SimulatedTimes] = field(default_factory=dict)
    """By first and last callback."""
    lost: Counter[str] = field(default_factory=Counter)
    """Messages that were lost, by place of their reader."""
    missing: list[str] = field(default_factory=list)
    """What has no greatest time, so that it was drawn from a distribution that the model does not give."""
    run: Witness | None = None
    """The beginning of the run, with the time of each firing."""

    @property
    def responses(self) -> list[SimulatedTimes]:
        """Those of single callbacks."""
        return [each for each in self.times.values() if each.first == each.last]

    @property
    def chains(self) -> list[SimulatedTimes]:
        """Those of chains from one callback to another one."""
        return [each for each in self.times.values() if each.first != each.last]


def simulate_times(model: sym.SystemModel, seconds: float, seed: int = 0, kept: int = 0) -> Simulated:
    """Simulate a model with its times; durations, latencies, offsets and jitter are drawn uniformly.

    Followed are callbacks of timers and topics whose runs do not overlap, and what they publish. Values that
    a callback keeps for another one, services and actions are simulated, and not followed.

    Parameters
    ----------
    model : sym.SystemModel
        A model of the middleware ``ros2`` with times.
    seconds : float
        How long, in simulated time.
    seed : int
        The same seed gives the same run.
    kept : int
        How many of the first firings are kept as a run.

    Raises
    ------
    DinerosError
        The model has no times, or its time stops.
    """
    require_times(model)
    parts = Parts(timed_base_subject(model))
    net = parts.subject.timed
    steps = _steps(parts)
    found = Simulated(seconds, missing=_missing(parts, steps))
    arrays: defaultdict[tuple[str, str], array[float]] = defaultdict(lambda: array("d"))

    def seen(first: str, last: str, time: float, ended: float) -> None:
        arrays[first, last].append(time)

    def lost(place: str) -> None:
        found.lost[place] += 1

    begun: list[tuple[int, FiredAt]] = []
    following = Following(parts, seen, lost)
    run = DrawnRun(net, seed, steps, mean_of(net))
    try:
        for transition, time in run.firings(seconds):
            following.fired(transition, time)
            found.firings += 1
            if found.firings <= kept:
                begun.append((transition, (time, time, time)))
            if found.firings >= MOST_FIRINGS:
                found.seconds = time
                break
    except TimeStopsError:
        raise DinerosError(
            f"time stops after {run.now:g} s: transitions fire again and again at one moment",
            hint="`dineros check --time` names them",
        ) from None
    if begun:
        found.run = witness_of(parts.subject, [t for t, _ in begun], times=[time for _, time in begun])
    for (first, last), values in sorted(arrays.items()):
        found.times[first, last] = SimulatedTimes(first, last, values)
    return found


def _steps(parts: Parts) -> frozenset[int]:
    """Return the transitions without a latest time that fire all the same: steps, and arrivals."""
    net = parts.subject.timed
    wanted = {name for run in parts.runs.values() for name in run.moves | run.starts}
    wanted |= {name for pipe in parts.pipes.values() for name in pipe.exits}
    names = net.untimed.transitions
    return frozenset(t for t, name in enumerate(names) if name in wanted and net.intervals[t].latest is None)


def _missing(parts: Parts, steps: frozenset[int]) -> list[str]:
    """Return what the model does not give, so that times of these elements say nothing."""
    names = {parts.subject.timed.untimed.transitions[t] for t in steps}
    found = []
    for (page, _), run in parts.runs.items():
        duration = duration_of(page)
        if (duration is None or duration.latest is None) and run.moves & names:
            found.append(f"the duration of callback {page.id} is not given")
    for (writer, reader), _ in parts.pipes.items():
        latency = latency_between(writer, reader)
        if (latency is None or latency.latest is None) and writer.channel is not None:
            found.append(f"the model gives no latency for topic {writer.channel.topic}")
    return list(dict.fromkeys(found))
