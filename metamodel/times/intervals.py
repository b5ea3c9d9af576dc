"""Copies of firing intervals: each element of a model owns its interval."""

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
