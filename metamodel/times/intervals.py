"""New firing intervals: each element of a model owns its interval."""

from __future__ import annotations

from dineros.metamodel import pn


def copied_interval(interval: pn.TimeInterval | None) -> pn.TimeInterval | None:
    """Return a copy of the bounds of an interval for another owner, without where they come from."""
    if interval is None:
        return None
    return pn.TimeInterval(
        earliest=interval.earliest,
        latest=interval.latest,
        earliestExcluded=interval.earliestExcluded,
        latestExcluded=interval.latestExcluded,
    )


def exactly(seconds: float | None) -> pn.TimeInterval:
    """Return the interval of one moment; without a number of seconds, the default interval."""
    return pn.TimeInterval() if seconds is None else pn.TimeInterval(earliest=seconds, latest=seconds)
