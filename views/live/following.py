"""Follows traces that are still written: a snapshot, then numbered changes for a live page."""

from __future__ import annotations

import json
import logging
import secrets
import threading
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

from dineros.metamodel import pn
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.records import Header, Record, RecordDecoder, Stop
from dineros.metamodel.records.following import Follower, new_records
from dineros.views.nets.placement.picture import Picture
from dineros.views.traces.building import TraceBuilder
from dineros.views.traces.coding import TraceCoder
from dineros.views.traces.facts import facts_of
from dineros.views.traces.merging import Merger
from dineros.views.traces.net_pane import net_content

LOG = logging.getLogger("dineros.views.live")

ModelSource = pn.Net | Callable[[Header], pn.Net | None] | None
"""The model, or a function that finds it by the header of a trace, or None."""

PATIENCE = 1.0
"""Seconds that a received message waits for the record that sent it."""

KEPT = 2000
"""Limit of the changes kept for pages that reconnect; others get a snapshot."""


class Source(Protocol):
    """A source of records."""

    def new(self) -> list[Record]:
        """Return the records since the last call."""


class FileSource:
    """A single file that grows.

    Parameters
    ----------
    path : Path
        The file, which may not exist yet.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._decoder = RecordDecoder(path)

    def new(self) -> list[Record]:
        """Return the records written since the last call."""
        if not self._path.is_file():
            return []
        return new_records(self._path, self._decoder)


def source_of(path: Path) -> Source:
    """Return the records of a folder of a run, or of one file."""
    return FileSource(path) if path.suffix == ".jsonl" else Follower(path)


class LiveTrace:
    """A trace that grows."""

    def __init__(self, source: Source, model: ModelSource, title: str) -> None:
        self.epoch = secrets.token_hex(4)
        self.number = 0
        self.problem: str | None = None
        self._source, self._model, self._title = source, model, title
        self._builder = TraceBuilder()
        self._coder = TraceCoder(self._builder, title)
        self._net: Picture | None = None
        self._failure: DinerosError | None = None
        self._drawing: threading.Thread | None = None
        self._merger = Merger([])
        self._waiting_since: float | None = None
        self._running: dict[str, bool] = {}
        self._changes: deque[tuple[int, str]] = deque(maxlen=KEPT)
        self._snapshot()

    @property
    def is_waiting(self) -> bool:
        """Whether the content may change without new records: by a drawing, or by a time-out."""
        return self._drawing is not None or self._waiting_since is not None

    @property
    def has_ended(self) -> bool:
        """Whether each started node has recorded its stop."""
        return bool(self._running) and not any(self._running.values())

    def poll(self) -> list[str]:
        """Read new records; return the messages for pages that are up to date.

        If a trace is damaged, the message reports it, and reading stops.
        """
        if self.problem is not None:
            return []
        try:
            records = self._source.new()
            restarted = self._take(records) | self._drawn()
        except DinerosError as error:
            self.problem = str(error)
            return [json.dumps({"type": "problem", "text": self.problem})]
        if restarted:
            self.number += 1
            self._changes.clear()
            return [self.snapshot()]
        change = self._coder.changes()
        if change is None:
            return []
        self.number += 1
        said = {"type": "change", "number": self.number, "ended": self.has_ended, **change}
        message = json.dumps(said, ensure_ascii=False)
        self._changes.append((self.number, message))
        return [message]

    def greeting(self, epoch: str | None, number: int | None) -> list[str]:
        """Return the data for a page that has seen changes up to a number: later changes, or everything."""
        found = [message for at, message in self._changes if number is not None and at > number]
        seen = epoch == self.epoch and number is not None and number <= self.number
        complete = seen and len(found) == self.number - (number or 0)
        messages = found if complete else [self.snapshot()]
        if self.problem is not None:
            messages = [*messages, json.dumps({"type": "problem", "text": self.problem})]
        return messages or [json.dumps({"type": "nothing new", "number": self.number})]

    def snapshot(self) -> str:
        """Return the complete current state."""
        return json.dumps(
            {
                "type": "snapshot",
                "epoch": self.epoch,
                "number": self.number,
                "view": self._snapshot(),
                "net": self._net,
                "ended": self.has_ended,
            },
            ensure_ascii=False,
        )

    def _snapshot(self) -> dict[str, Any]:
        return self._coder.snapshot()

    def _take(self, records: list[Record]) -> bool:
        """Add records; return whether the earlier state became invalid because the model is now known."""
        known = self._builder.header is not None
        for record in records:
            if isinstance(record, Header) and self._builder.header is None:
                self._begin(record)
            self._merger.push(record.node or "", record)
        now = time.monotonic()
        force = self._waiting_since is not None and now - self._waiting_since > PATIENCE
        for node, record in self._merger.ready(force=force):
            self._builder.add(record, node or None)
            if not isinstance(record, Header):
                self._running[record.node or node] = not isinstance(record, Stop)
        if force or not self._merger.waiting:
            self._waiting_since = None
        elif self._waiting_since is None:
            self._waiting_since = now
        return not known and self._builder.header is not None

    def _begin(self, header: Header) -> None:
        model = self._model(header) if callable(self._model) else self._model
        self._builder = TraceBuilder(facts_of(model))
        self._builder.add(header)
        self._coder = TraceCoder(self._builder, self._title)
        # Until it is drawn, which takes its time, the trace itself is shown.
        self._drawing = threading.Thread(target=self._draw, args=(model,), daemon=True)
        self._drawing.start()

    def _draw(self, model: pn.Net | None) -> None:
        try:
            self._net = net_content(model)
        except DinerosError as error:
            self._failure = error

    def _drawn(self) -> bool:
        """Report once that the net is drawn."""
        if self._drawing is None or self._drawing.is_alive():
            return False
        self._drawing = None
        if self._failure is not None:  # reported here, as no one asks once the page has ended
            LOG.warning("the live page shows no net: %s", self._failure)
        return self._net is not None
