"""Determines since when a node was idle before a moment."""

from __future__ import annotations

import math
from collections import deque

CLOSE = 0.001
"""Largest seconds between two events that count as immediate successors."""
_KEPT = 512
"""Limit of the remembered spans; earlier times are unknown."""


class Spans:
    """Spans of time, in the order in which they end; the last one may be open."""

    def __init__(self) -> None:
        self._spans: deque[tuple[float, float]] = deque(maxlen=_KEPT)
        self._open: float | None = None

    def add(self, begin: float, end: float) -> None:
        """Record a completed span."""
        self._spans.append((begin, end))

    def begin(self, moment: float) -> None:
        """Begin a span, unless one is open."""
        if self._open is None:
            self._open = moment

    def end(self, moment: float) -> None:
        """End the open span, if there is one."""
        if self._open is not None:
            self.add(self._open, moment)
            self._open = None

    def before(self, moment: float) -> float:
        """Return the beginning of the spans that reach to a moment; the moment itself if none does."""
        if self._open is not None and self._open < moment:
            moment = self._open
        for begin, end in reversed(self._spans):
            if end < moment - CLOSE:
                return moment
            moment = min(moment, begin)
        return -math.inf if len(self._spans) == _KEPT else moment


def idle_before(moment: float, *kinds: Spans) -> float:
    """Return the last moment, not after this one, at which none of several kinds of spans was under way."""
    while True:
        earlier = min(spans.before(moment) for spans in kinds)
        if earlier >= moment:
            return moment
        moment = earlier
