"""What all records of a trace have, and the first of every file; classes of records tell their events."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, Literal, NamedTuple, TypeAlias, dataclass_transform

from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.errors import Location
from dineros.metamodel.records.declarations import Declaration
from dineros.metamodel.token_data import Value

Data: TypeAlias = dict[str, Value]
"""Fields of a balloon token."""


class StoredToken(NamedTuple):
    """A balloon token, written as ``[id, data]``."""

    id: int
    data: Data


EVENTS: dict[str, type[Record]] = {}
"""Class of the records of each event."""


@dataclass_transform(frozen_default=True, kw_only_default=True, field_specifiers=(field,))
@dataclass(frozen=True, kw_only=True)
class Record:
    """One line of a trace, whose fields are those of the JSON object.

    Subclasses are frozen dataclasses, too; one whose class statement names an event is found in `EVENTS`.

    Attributes
    ----------
    sequence : int
        Position in the trace of the node, from 0; continues over rotated parts and restarts.
    time : float or None
        Seconds since the epoch; only in runs.
    node : str or None
        Id of the node net.
    location : Location or None
        Where the record was read; no field of the JSON object.
    """

    event: ClassVar[str]
    declared: ClassVar[Declaration] = Declaration()

    sequence: int
    time: float | None = None
    node: str | None = None
    location: Location | None = field(default=None, compare=False, repr=False)

    def __init_subclass__(cls, event: str | None = None) -> None:
        dataclass(frozen=True, kw_only=True)(cls)
        if event is not None:
            cls.event = event
            EVENTS[event] = cls


SCHEMA = 1
"""Version of the schema; a reader refuses a later one."""


class Header(Record, event="header"):
    """First line of every file.

    Attributes
    ----------
    schema : int
        Version of the schema.
    kind : {"run", "witness"}
        What the file is.
    model, source : str
        Id of the model, and the file it comes from.
    settings : list of str
        How the model was changed for this run, as for `--set`.
    simulated : bool
        Of a run: whether its nodes ran in simulated time, which the times of its records are not.
    property : str or None
        Of a witness: what was asked, such as ``G a <= 1``.
    verdict : str or None
        Of a witness: the answer it proves, such as ``violated``.
    loop : int or None
        Of a witness: sequence of the first record that repeats forever.
    signals, overflow : str or None
        Of a witness: how the model was flattened; None for a plain net.
    marking : dict of str to int
        Of a witness: initial marking of the flattened net; places that are not named are empty.
    signals_initial : dict of str to bool or str
        Of a witness: start value of each signal.
    cause : int or None
        Of a witness: sequence of the record with which its outcome may have begun; 0: it was so from the
        start.
    causes : list of int
        Of a witness: sequences of the records in the causal past of its outcome.
    decided : dict of str to list of int
        Of a witness: the conditions that decide its outcome; sequences of the record since which each is true
        (0: from the start), and of that up to which.
    """

    schema: int = SCHEMA
    kind: Literal["run", "witness"]
    model: str
    source: str = ""
    settings: list[str] = field(default_factory=list)
    simulated: bool = False
    property: str | None = None
    verdict: str | None = None
    loop: int | None = None
    signals: str | None = None
    overflow: str | None = None
    marking: dict[str, int] = field(default_factory=dict)
    signals_initial: dict[str, SignalSetting] = field(default_factory=dict)
    cause: int | None = None
    causes: list[int] = field(default_factory=list)
    decided: dict[str, list[int]] = field(default_factory=dict)
