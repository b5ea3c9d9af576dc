"""One recorded time, with bounds for the true one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from dineros.metamodel.records import Record

Feature = Literal["duration", "period", "latency"]
"""The kind of a time: run of a callback or handler, gap between two ticks, latency of a message."""


@dataclass(frozen=True)
class Part:
    """The element of a time."""

    feature: Feature
    """What was measured."""
    element: str
    """Id of the element: a callback, a transition, or the channel of a message."""
    writer: str = ""
    reader: str = ""
    """`writer`, `reader`: of a message: the places of its publisher and reader; of a call: the client, and
    ``request`` or ``reply``.
    """


@dataclass(frozen=True)
class Seen:
    """One time, in seconds."""

    part: Part
    """Its element."""
    least: float
    most: float
    """`least`, `most`: bounds of the true time. They differ if the length of a wait is unknown."""
    at: float
    """When it ended, by the clock of the recording."""
    record: Record
    """The record that ended it."""

    @property
    def is_certain(self) -> bool:
        """Whether there was no wait, so that the time is exact."""
        return self.most - self.least <= CERTAIN


CERTAIN = 1e-9
"""Seconds."""
