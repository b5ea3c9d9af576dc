"""Times in words, for pictures."""

from __future__ import annotations

from math import isfinite

from dineros.metamodel import pn
from dineros.metamodel.files.exact import exact_text, fraction_of


def interval_words(interval: pn.TimeInterval) -> str:
    """Return an interval of seconds in words, in milliseconds if it ends before one second.

    >>> interval_words(pn.TimeInterval(earliest=0.005, latest=0.02))
    '5 to 20 ms'
    >>> interval_words(pn.TimeInterval(latest=1.5)), interval_words(pn.TimeInterval(earliest=0.5))
    ('at most 1.5 s', 'at least 500 ms')
    """
    earliest, latest = interval.earliest, interval.latest
    unit, factor = ("ms", 1000) if (earliest if latest is None else latest) < 1 else ("s", 1)
    first = _scaled(earliest, factor)
    if latest is None:
        word = "more than" if interval.earliestExcluded else "at least"
        return f"{word} {first} {unit}" if earliest or interval.earliestExcluded else "any time"
    last = _scaled(latest, factor)
    if earliest == latest:
        return f"{last} {unit}"
    if not earliest and not interval.earliestExcluded:
        return f"{'less than' if interval.latestExcluded else 'at most'} {last} {unit}"
    is_open = interval.earliestExcluded, interval.latestExcluded
    return f"{'more than ' * is_open[0]}{first} to {'less than ' * is_open[1]}{last} {unit}"


def _scaled(bound: float, factor: int) -> str:
    """Return a bound in other units, exactly; invalid models may have bounds that are not numbers."""
    return exact_text(fraction_of(bound) * factor) if isfinite(bound) else str(bound)
