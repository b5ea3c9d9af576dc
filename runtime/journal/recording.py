"""The protocol of recorders, which keep the records of a node."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

from dineros.runtime.journal.saved import SavedState
from dineros.runtime.nets.ports import Ports


class Recorder(Protocol):
    """Keeps the records of a node, in order. Called on the thread of the node's loop only.

    It adds the sequence number, the time and the node to each record, and writes headers. A record is made
    when its event has happened: a checkpoint taken at that moment includes the event. So a recorder may start
    a new file after any record and begin it with a checkpoint.
    """

    def open(self, ports: Ports, checkpoint: Callable[[], SavedState]) -> None:
        """Prepare for the first record.

        `ports` has the ids of model and node; `checkpoint` returns the current state of the node. It may be
        called between two records or at the end of `record`.
        """

    def record(self, event: str, **fields: object) -> None:
        """Keep one event; its values are JSON and do not change later."""

    def close(self) -> None:
        """Make all records permanent; no record follows."""


class ListRecorder:
    """Keeps records in memory, for tests and simulations."""

    def __init__(self) -> None:
        self.records: list[dict[str, object]] = []
        self.node = ""

    def open(self, ports: Ports, checkpoint: Callable[[], SavedState]) -> None:
        """Store the node's id."""
        self.node = ports.node

    def record(self, event: str, **fields: object) -> None:
        """Append a record."""
        common = {"sequence": len(self.records), "event": event, "time": time.time(), "node": self.node}
        self.records.append(common | fields)

    def close(self) -> None:
        """Do nothing."""
