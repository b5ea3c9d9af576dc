"""The state of a node after the records of a trace, or of its journal."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from dineros.metamodel.errors import Location
from dineros.metamodel.records import Record, parts_of, read_records
from dineros.runtime.journal.outlined import Outlined
from dineros.runtime.journal.state import JournalState, JournalStateError


def rebuild(records: Iterable[Record], until: int | None = None) -> JournalState:
    """Return the state of a node after its records.

    Parameters
    ----------
    records : iterable of Record
        Records, beginning with a start or a checkpoint.
    until : int, optional
        Sequence number of the last record to apply; by default, all are applied.
    """
    state = JournalState()
    for record in records:
        if until is not None and record.sequence > until:
            break
        state.apply(record)
    return state


def rebuild_at(folder: Path, node: str, until: int | None = None) -> JournalState:
    """Return the state of a node after the record with a sequence number, by default after the last.

    Only the part of the journal with that record is read: each part begins with a checkpoint.

    Raises
    ------
    JournalStateError
        The folder has no such record.
    RecordError
        A line is not a record.
    """
    parts = parts_of(folder, node)
    for part in reversed(parts):
        first = next(iter(read_records(part)), None)
        if first is not None and (until is None or first.sequence <= until):
            state = rebuild(map(Outlined(folder, node).inline, read_records(part)), until)
            if until is not None and state.next_sequence <= until:
                break
            return state
    what = f"no trace of node {node!r}" if not parts else f"no record {until} of node {node!r}"
    raise JournalStateError(what, location=Location(folder))
