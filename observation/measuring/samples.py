"""Times that were measured, and what to say of them: how many, their quantiles, the greatest."""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

QUANTILES = (0.5, 0.95, 0.99)


@dataclass(frozen=True)
class Summary:
    """What is said of some times, in seconds.

    Attributes
    ----------
    count : int
        The size of the sample.
    least, greatest : float
        The extremes that were observed.
    median, q95, q99 : float
        Quantiles: the least observed time that so many percent do not exceed.
    """

    count: int
    least: float
    median: float
    q95: float
    q99: float
    greatest: float

    def __str__(self) -> str:
        quantiles = f"50 % {duration_text(self.median)}, 95 % {duration_text(self.q95)}"
        extremes = f"99 % {duration_text(self.q99)}, at most {duration_text(self.greatest)}"
        return f"{self.count:,} measured, at least {duration_text(self.least)}, {quantiles}, {extremes}"

    def to_dict(self) -> dict[str, Any]:
        """Return them for JSON."""
        return asdict(self)


class Samples:
    """Times of one kind, in seconds.

    Examples
    --------
    >>> times = Samples([0.004, 0.001, 0.002, 0.003])
    >>> times.quantile(0.5), times.summary().greatest
    (0.002, 0.004)
    """

    def __init__(self, values: Iterable[float] = ()) -> None:
        self._values = array("d", values)
        self._is_sorted = False

    def __len__(self) -> int:
        return len(self._values)

    def add(self, seconds: float) -> None:
        """Take one more."""
        self._values.append(seconds)
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
        """Return what is said of them."""
        median, q95, q99 = (self.quantile(each) for each in QUANTILES)
        return Summary(len(self._values), self.quantile(0), median, q95, q99, self.quantile(1))


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
