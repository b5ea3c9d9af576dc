"""Schedules: when the transitions of a firing sequence fire.

Each firing is a variable, and the firing intervals bound the differences of two variables. So the earliest
and the latest time of each firing are longest and shortest paths (Bellman and Ford), and all firings at their
earliest times are a schedule. A bound that is left out is moved by a fraction of the unit that no sequence of
this length can add up to a whole unit, so all numbers stay exact.

This computation shares nothing with state classes but the net: it also checks the sequences that they find.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import lcm

import numpy as np

from dineros.analysis.nets.witness import WitnessError
from dineros.analysis.timed.nets import TimedNet

MOST = 1 << 62
"""Sums of bounds below this are counted by the compiled kernel."""


@dataclass(frozen=True)
class ScheduledFiring:
    """When a transition of a sequence fires.

    Attributes
    ----------
    at : Fraction
        Its time in the schedule that was chosen: each firing as early as it can, counted from the start.
    earliest : Fraction
        No schedule of the sequence has it earlier.
    latest : Fraction or None
        No schedule of the sequence has it later; None if it may be any time later.
    """

    transition: int
    at: Fraction
    earliest: Fraction
    latest: Fraction | None


@dataclass(frozen=True)
class Gap:
    """A bound on the time between two firings of a sequence: ``x[target] - x[source] >= least``.

    Attributes
    ----------
    source, target : int
        Firings, counted from 1; 0 is the start.
    is_strict : bool
        Whether it is more than `least`.
    """

    source: int
    target: int
    least: Fraction
    is_strict: bool


def schedule(net: TimedNet, trace: Sequence[int], gaps: Sequence[Gap] = ()) -> tuple[ScheduledFiring, ...]:
    """Return when the transitions of a firing sequence fire.

    Parameters
    ----------
    gaps
        More bounds: only schedules that keep them are looked at.

    Raises
    ------
    WitnessError
        There is no schedule: the sequence is not one of the net with its times.

    Examples
    --------
    >>> from dineros.analysis.nets.compiled import Transition
    >>> from dineros.analysis.timed.nets import Interval
    >>> steps = [Transition("tick", {"idle": 1}, {"due": 1}), Transition("work", {"due": 1}, {"idle": 1})]
    >>> times = {"tick": Interval(Fraction(10), Fraction(10)), "work": Interval(Fraction(1), Fraction(3))}
    >>> net = TimedNet.build({"idle": 1, "due": 0}, steps, times)
    >>> [(str(one.earliest), str(one.at), str(one.latest)) for one in schedule(net, [0, 1, 0])]
    [('10', '10', '10'), ('11', '11', '13'), ('21', '21', '23')]
    """
    bounds = [*_bounds(net, trace), *gaps]
    size = len(trace) + 1
    # All numbers are whole in parts of the unit of which no sequence of this length adds up to a unit.
    parts = 2 * (size + 1) if any(bound.is_strict for bound in bounds) else 1
    part = net.unit / (parts * lcm(*((b.least / net.unit).denominator for b in gaps)))
    arcs = [(b.source, b.target, int(b.least / part) + b.is_strict) for b in bounds]
    earliest = _longest(size, arcs)
    # The latest times are shortest paths: the same bounds turned round, from the start backwards.
    back = _longest(size, [(target, source, least) for source, target, least in arcs])
    if earliest is None or back is None:
        raise WitnessError("a firing sequence has no schedule")
    made = []
    for number, transition in enumerate(trace, 1):
        first, before = earliest[number], back[number]
        assert first is not None, "each firing comes after the start"
        at, latest = first * part, None if before is None else -before * part
        made.append(
            ScheduledFiring(transition, at, _unshifted(at, net.unit), _unshifted_up(latest, net.unit))
        )
    return tuple(made)


def check_times(
    net: TimedNet, trace: Sequence[int], times: Sequence[Fraction], tolerance: Fraction = Fraction(0)
) -> None:
    """Check that a firing sequence with these times, counted from the start, is one of the net.

    Parameters
    ----------
    tolerance
        By how much a bound may be missed: clocks of runs are floating-point numbers.

    Raises
    ------
    WitnessError
        A transition lacks tokens, fires too early, or after the latest time of another; or time goes back.
    """
    moments = [Fraction(0), *times]
    names = net.untimed.transitions
    for bound in _bounds(net, trace):
        gap = moments[bound.target] - moments[bound.source] - bound.least + tolerance
        if gap < 0 or (not gap and bound.is_strict and not tolerance):
            number = max(bound.source, bound.target)
            raise WitnessError(
                f"firing {number} of {names[trace[number - 1]]} at {float(moments[number]):g} is not in time"
            )


def _unshifted(time: Fraction, unit: Fraction) -> Fraction:
    """Return the bound that a time above it by a shift stands for."""
    return time // unit * unit


def _unshifted_up(time: Fraction | None, unit: Fraction) -> Fraction | None:
    return None if time is None else -(-time // unit) * unit


def _bounds(net: TimedNet, trace: Sequence[int]) -> list[Gap]:
    """Fire the sequence and collect what bounds its times; variable 0 is the start.

    Raises
    ------
    WitnessError
        A transition lacks tokens where the sequence fires it.
    """
    marking = net.untimed.initial.tolist()
    since = dict.fromkeys(_enabled(net, marking), 0)
    bounds = []
    for number, fired in enumerate(trace, 1):
        if fired not in since:
            raise WitnessError(f"transition {net.untimed.transitions[fired]} is not enabled")
        bounds.append(Gap(number - 1, number, Fraction(0), False))
        own = net.intervals[fired]
        bounds.append(Gap(since[fired], number, own.earliest, own.is_open_below))
        for transition, start in since.items():
            interval = net.intervals[transition]
            if interval.latest is not None:
                bounds.append(Gap(number, start, -interval.latest, interval.is_open_above))
            if transition in net.above[fired]:
                bounds.append(Gap(number, start, -interval.earliest, not interval.is_open_below))
        for place, weight in net.take.row(fired):
            marking[place] -= weight
        going_on = {
            t: start for t, start in since.items() if t != fired and net.untimed.is_enabled(t, marking)
        }
        for place, weight in net.put.row(fired):
            marking[place] += weight
        since = {t: going_on.get(t, number) for t in _enabled(net, marking)}
    return bounds


def _enabled(net: TimedNet, marking: Sequence[int]) -> list[int]:
    return [t for t in range(len(net.untimed.transitions)) if net.untimed.is_enabled(t, marking)]


def _longest(size: int, arcs: Sequence[tuple[int, int, int]]) -> list[int | None] | None:
    """Return by variable the longest path from variable 0; None if paths grow forever."""
    from dineros.analysis.timed.kernels.paths import lengthen

    if any(source == target and least > 0 for source, target, least in arcs):
        return None
    ordered = sorted(arcs, key=lambda arc: (arc[0] > arc[1], arc[0] if arc[0] < arc[1] else -arc[0]))
    is_large = size * max((abs(least) for *_, least in arcs), default=0) >= MOST
    columns = np.array(ordered, dtype=object if is_large else np.int64).reshape(-1, 3).T.copy()
    length, reached = np.zeros(size, dtype=columns.dtype), np.zeros(size, dtype=np.bool_)
    reached[0] = True
    if not (lengthen.py_func if is_large else lengthen)(length, reached, *columns):
        return None
    return [int(one) if is_reached else None for one, is_reached in zip(length, reached, strict=True)]
