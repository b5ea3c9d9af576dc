"""Arrival curves: how many events can happen in a window of time, in whole units of time.

A curve is a sum of periodic terms. A term stands for events that follow moments `period` apart, each by a
delay that varies by at most `spread`, `count` events at each moment. So a closed window of the length `w`
holds at most ``count * (floor((w + spread) / period) + 1)`` of them: their moments lie in a window of the
length ``w + spread`` (K. Tindell, J. Clark, *Holistic schedulability analysis*, 1994, call it jitter).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

MOST_TERMS = 48
"""Terms of a curve; beyond that, those of one period become one, with the greatest spread."""


@dataclass(frozen=True)
class Curve:
    """How many events can happen in a window.

    Examples
    --------
    >>> curve = Curve(((1, 10, 2),))
    >>> [curve.within(window) for window in (0, 7, 8)], curve.before(8), curve.span(3)
    ([1, 1, 2], 1, 18)
    """

    terms: tuple[tuple[int, int, int], ...] = ()
    """Count, period and spread of each term."""
    has_moments: bool = True
    """Whether each event follows a moment of its own, as terms say it; else the curve only bounds numbers."""

    @property
    def one_period(self) -> int | None:
        """The period of events that follow one series of moments, one each; None of others."""
        return self.terms[0][1] if self.has_moments and [term[0] for term in self.terms] == [1] else None

    def within(self, window: int) -> int:
        """Return the greatest number in a closed window."""
        return sum(count * ((window + spread) // period + 1) for count, period, spread in self.terms)

    def before(self, window: int) -> int:
        """Return the greatest number in a window without its last moment; `window` is above 0."""
        return sum(count * ((window + spread - 1) // period + 1) for count, period, spread in self.terms)

    def span(self, number: int) -> int:
        """Return the length of the shortest closed window that can hold a number of events.

        The curve is not empty.
        """
        if self.within(0) >= number:
            return 0
        least, most = 0, 1
        while self.within(most) < number:
            least, most = most, 2 * most
        while most - least > 1:
            middle = (least + most) // 2
            least, most = (least, middle) if self.within(middle) >= number else (middle, most)
        return most

    def spread(self, more: int) -> Curve:
        """Return the curve of events that follow these by a delay that varies by at most `more`."""
        terms = tuple((count, period, spread + more) for count, period, spread in self.terms)
        return Curve(terms, self.has_moments)

    def times(self, number: int) -> Curve:
        """Return the curve of events of which a fixed number happens at each event of this curve."""
        terms = tuple((count * number, period, spread) for count, period, spread in self.terms)
        return Curve(terms, self.has_moments)

    @property
    def rate(self) -> Fraction:
        """Events in a unit of time, in the long run."""
        return sum((Fraction(count, period) for count, period, _ in self.terms), Fraction(0))


def added(curves: Iterable[Curve]) -> Curve:
    """Return the curve of the events of several curves together, or one above it if it has too many terms."""
    counts: dict[tuple[int, int], int] = {}
    has_moments = True
    for curve in curves:
        has_moments = has_moments and curve.has_moments
        for count, period, spread in curve.terms:
            counts[period, spread] = counts.get((period, spread), 0) + count
    if len(counts) > MOST_TERMS:
        merged: dict[int, tuple[int, int]] = {}
        for (period, spread), count in counts.items():
            so_far, widest = merged.get(period, (0, 0))
            merged[period] = so_far + count, max(widest, spread)
        counts = {(period, spread): count for period, (count, spread) in merged.items()}
    return Curve(tuple((count, *term) for term, count in sorted(counts.items()) if count), has_moments)
