"""The base class of records, and the header of each file; classes of records declare their events."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from operator import attrgetter
from typing import Any, ClassVar, Literal, NamedTuple, TypeAlias, dataclass_transform

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
@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Record:
    """One line of a trace, whose fields are those of the JSON object.

    Subclasses are frozen dataclasses, too; one whose class statement names an event is found in `EVENTS`.

    Attributes
    ----------
    sequence : int
        Position in the trace of the node, from 0; it continues over rotated parts and restarts.
    time : float or None
        Seconds since the epoch; only in runs.
    node : str or None
        Id of the node net.
    location : Location or None
        Where the record was read; not a field of the JSON object.
    """

    event: ClassVar[str]
    declared: ClassVar[Declaration] = Declaration()
    _compared: ClassVar[Any]
    """Returns the values of the fields that two equal records have in common."""

    sequence: int
    time: float | None = None
    node: str | None = None
    location: Location | None = field(default=None, compare=False, repr=False)

    def __init_subclass__(cls, event: str | None = None) -> None:
        # What is the same for all records is written below, not generated once more for each class.
        dataclass(frozen=True, kw_only=True, repr=False, eq=False)(cls)
        cls._compared = attrgetter(*(each.name for each in fields(cls) if each.compare))
        if event is not None:
            cls.event = event
            EVENTS[event] = cls

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Record) or other.__class__ is not self.__class__:
            return NotImplemented
        return bool(self._compared(self) == self._compared(other))

    def __hash__(self) -> int:
        return hash(self._compared(self))

    def __repr__(self) -> str:
        shown = (f"{each.name}={getattr(self, each.name)!r}" for each in fields(self) if each.repr)
        return f"{type(self).__qualname__}({', '.join(shown)})"


SCHEMA = 1
"""Version of the schema; a reader refuses a later one."""


class Header(Record, event="header"):
    """The first line of each file.

    Attributes
    ----------
    schema : int
        Version of the schema.
    kind : {"run", "witness"}
        Kind of the trace.
    model, source : str
        Id of the model, and its file.
    settings : list of str
        Settings that changed the model for this run, as for `--set`.
    simulated : bool
        For a run: whether its nodes used simulated time, which the times of its records are not.
    property : str or None
        For a witness: the question, such as ``G a <= 1``.
    verdict : str or None
        For a witness: the answer that it proves, such as ``violated``.
    loop : int or None
        For a witness: sequence number of the first record that repeats forever.
    signals, overflow : str or None
        For a witness: options of the flattening; None for a plain net.
    marking : dict of str to int
        Of a witness: initial marking of the flattened net; places that are not named are empty.
    signals_initial : dict of str to bool or str
        Of a witness: start value of each signal.
    cause : int or None
        For a witness: sequence number of the record from which its outcome may follow; 0: from the start.
    causes : list of int
        For a witness: sequence numbers of the records in the causal past of its outcome.
    decided : dict of str to list of int
        For a witness: the conditions that decide its outcome; for each, the sequence numbers of the records
        from which it is true (0: from the start), and up to which.
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
