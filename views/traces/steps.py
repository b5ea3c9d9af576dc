"""One step of the picture of a trace."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from dineros.metamodel.records import Record
from dineros.metamodel.records.schema import Step as StepRecord

Mark = list[Any]
_SHOWN = (
    "handlers",
    "duration",
    "taken",
    "made",
    "data",
    "token",
    "message",
    "instance",
    "outcome",
    "attempt",
    "handler",
    "error",
    "policy",
    "tokens",
    "reason",
    "source",
    "resumed",
    "seed",
    "stage",
)


@dataclass
class Step:
    """One step of the picture.

    Attributes
    ----------
    event : str
        The event of its record.
    node : str or None
        The node net of the step; None inside a channel.
    text : str
        The description of the step.
    change : dict of str to int
        Tokens gained or lost, by place.
    marks : list
        What it does to lanes.
    transition : str or None
        What fires, fails or is left aside.
    time : float or None
        Seconds since the epoch.
    details : dict
        More fields of the record, for the detail of the step.
    """

    event: str
    node: str | None
    text: str
    change: dict[str, int]
    marks: list[Mark] = field(default_factory=list)
    transition: str | None = None
    time: float | None = None
    details: dict[str, Any] = field(default_factory=dict)


def details_of(record: Record) -> dict[str, Any]:
    """Return the further fields of a record that are shown."""
    values = {name: getattr(record, name, None) for name in _SHOWN}
    shown = {name: value for name, value in values.items() if value not in (None, {}, [], False)}
    if isinstance(record, StepRecord) and record.earliest is not None:
        shown["window"] = [record.earliest, record.latest]
    return shown
