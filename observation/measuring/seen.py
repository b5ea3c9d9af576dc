"""One time that a recording shows, and within which bounds the true one lies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from dineros.metamodel.records import Record

Feature = Literal["duration", "period", "latency"]
"""Of what a time is: of a run of a callback or handler, between two ticks, of a message on its way."""


@dataclass(frozen=True)
class Part:
    """What a time belongs to.

    Attributes
    ----------
    feature : Feature
        What was measured.
    element : str
        Id of the element: a callback, a transition, or the channel of a message.
    writer, reader : str
        Of a message: the places of its publisher and reader; of a call: the client, and ``request`` or
        ``reply``.
    """

    feature: Feature
    element: str
    writer: str = ""
    reader: str = ""


@dataclass(frozen=True)
class Seen:
    """One time, in seconds.

    Attributes
    ----------
    part : Part
        What it belongs to.
    least, most : float
        The true time is not outside. They differ where it is not known how long something had to wait.
    at : float
        When it was over, by the clock of the recording.
    record : Record
        The record that ended it.
    """

    part: Part
    least: float
    most: float
    at: float
    record: Record

    @property
    def is_certain(self) -> bool:
        """Whether nothing had to wait, so that the time itself is known."""
        return self.most - self.least <= CERTAIN


CERTAIN = 1e-9
"""Seconds."""
