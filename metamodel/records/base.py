"""What all records of a trace have."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple, TypeAlias

from dineros.metamodel.errors import Location
from dineros.metamodel.token_data import Value

Data: TypeAlias = dict[str, Value]
"""Fields of a balloon token."""


class StoredToken(NamedTuple):
    """A balloon token, written as ``[id, data]``."""

    id: int
    data: Data


@dataclass(frozen=True, kw_only=True)
class Record:
    """One line of a trace.

    Attributes
    ----------
    sequence : int
        Position in the trace of the node, from 0; goes on over rotated parts and restarts.
    time : float or None
        Seconds since the epoch; only in runs.
    node : str or None
        Id of the node net.
    location : Location or None
        Where the record was read; no field of the JSON object.
    """

    event: ClassVar[str]

    sequence: int
    time: float | None = None
    node: str | None = None
    location: Location | None = field(default=None, compare=False, repr=False)
