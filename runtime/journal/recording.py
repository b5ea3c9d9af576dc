"""What a node records of its run: the protocol of recorders."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

from dineros.runtime.journal.saved import SavedState
from dineros.runtime.nets.ports import Ports


class Recorder(Protocol):
    """Keeps what a node does, in the order it happens. Called on the thread of the node's loop only.

    It adds the sequence number, the time and the node to each record, and writes headers. A record is made
    when what it says is done: at that moment a checkpoint holds it. A recorder that starts a new file after
    a record can therefore begin it with a checkpoint.
    """

    def open(self, ports: Ports, checkpoint: Callable[[], SavedState]) -> None:
        """Get ready, before the first record.

        `ports` names model and node; `checkpoint` gives the node's present state, whenever it is called
        between two records or at the end of `record`.
        """

    def record(self, event: str, **fields: object) -> None:
        """Keep one event; the values are JSON, and are not changed later."""

    def close(self) -> None:
        """Keep all recorded so far for good; no record follows."""


class ListRecorder:
    """Keeps records in memory, for tests and simulations."""

    def __init__(self) -> None:
        self.records: list[dict[str, object]] = []
        self.node = ""

    def open(self, ports: Ports, checkpoint: Callable[[], SavedState]) -> None:
        """Note the node's id."""
        self.node = ports.node

    def record(self, event: str, **fields: object) -> None:
        """Append a record."""
        common = {"sequence": len(self.records), "event": event, "time": time.time(), "node": self.node}
        self.records.append(common | fields)

    def close(self) -> None:
        """Do nothing."""
