"""Samples of measured times, and their summaries: number, quantiles, greatest."""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from random import Random
from typing import Any

QUANTILES = (0.5, 0.95, 0.99)
MOST = 1 << 20
"""Default limit of the stored times."""


@dataclass(frozen=True)
class Summary:
    """A summary of times, in seconds.

    Attributes
    ----------
    least, greatest : float
        The extremes that were observed.
    """

    count: int
    """The size of the sample."""
    least: float
    median: float
    q95: float
    q99: float
    """`median`, `q95`, `q99`: quantiles: the least observed time that this percentage does not exceed."""
    greatest: float

    def __str__(self) -> str:
        quantiles = {"50 %": self.median, "95 %": self.q95, "99 %": self.q99}
        times = {"least": self.least, **quantiles, "greatest": self.greatest}
        shown = ", ".join(f"{name} {duration_text(time)}" for name, time in times.items())
        return f"{self.count:,} measured: {shown}"

    def to_dict(self) -> dict[str, Any]:
        """Return them for JSON."""
        return asdict(self)


class Samples:
    """Times of one kind, in seconds.

    Of more than `most`, as many are kept at random (Vitter's algorithm R); the extremes stay exact.

    Examples
    --------
    >>> times = Samples([0.004, 0.001, 0.002, 0.003])
    >>> times.quantile(0.5), times.summary().greatest
    (0.002, 0.004)
    """

    def __init__(self, values: Iterable[float] = (), most: int = MOST) -> None:
        self._values = array("d")
        self._is_sorted = False
        self._most = most
        self._draw = Random(0)
        self._count = 0
        self._least, self._greatest = math.inf, -math.inf
        for each in values:
            self.add(each)

    def __len__(self) -> int:
        return self._count

    def add(self, seconds: float) -> None:
        """Add a time."""
        self._count += 1
        self._least, self._greatest = min(self._least, seconds), max(self._greatest, seconds)
        if len(self._values) < self._most:
            self._values.append(seconds)
        elif (place := int(self._draw.random() * self._count)) < self._most:
            self._values[place] = seconds
        self._is_sorted = False

    def quantile(self, share: float) -> float:
        """Return the least time that this share of the times does not exceed (the nearest rank).

        Raises
        ------
        ValueError
            There are no times.
        """
        if not self._values:
            raise ValueError("no times were measured")
        if not self._is_sorted:
            self._values = array("d", sorted(self._values))
            self._is_sorted = True
        return self._values[max(0, math.ceil(share * len(self._values)) - 1)]

    def summary(self) -> Summary:
        """Return their summary."""
        median, q95, q99 = (self.quantile(each) for each in QUANTILES)
        return Summary(self._count, self._least, median, q95, q99, self._greatest)


def duration_text(seconds: float) -> str:
    """Return a length of time with its unit, to three digits or the microsecond.

    Examples
    --------
    >>> duration_text(0.083), duration_text(12.4), duration_text(0.00002)
    ('83 ms', '12.4 s', '20 µs')
    """
    size = abs(seconds)
    if 0 < size < 0.0009995:
        return f"{seconds * 1e6:.3g} µs"
    if 0 < size < 0.9995:
        return f"{seconds * 1e3:.3g} ms"
    return f"{seconds:.3g} s" if size < 999.5 else f"{seconds:,.0f} s"
