"""The observers of a net: its recorder, functions of developers, and what measures response times."""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from dineros.runtime.nodes.responses import Responses
from dineros.runtime.nodes.status import ErrorReport
from dineros.runtime.scheduling.watchdog import Watchdog

LOG = logging.getLogger("dineros.runtime")
KEPT_ERRORS = 100


@dataclass(frozen=True)
class Change:
    """A change of a net.

    Attributes
    ----------
    event : str
        Kind of event, as in a trace: ``fire``, ``signal``, ``take``, ``publish`` and so on.
    fields : mapping
        The fields of its record in a trace.
    """

    event: str
    fields: Mapping[str, object]


class Observers:
    """Receives the events of one net, and passes them on.

    Attributes
    ----------
    is_observing : bool
        Whether changes are recorded, reported or measured; if not, no event is built.
    errors : deque of ErrorReport
        The last failures, the oldest first.
    failures : int
        Number of failed firings.
    responses : Responses or None
        Response times of callbacks, once they are requested.
    on_status : callable or None
        Called when the node's status may have changed; from any thread.
    watchdog : Watchdog
        Watches the functions of developers on the node's thread.
    """

    def __init__(self, node: str) -> None:
        self.is_observing = False
        self.errors: deque[ErrorReport] = deque(maxlen=KEPT_ERRORS)
        self.failures = 0
        self.responses: Responses | None = None
        self.on_status: Callable[[], None] | None = None
        self.watchdog = Watchdog(node, self.status_changed)
        self._record: Callable[..., None] | None = None
        self._callbacks: tuple[Callable[[Change], object], ...] = ()
        self._lock = threading.Lock()

    def emit(self, event: str, **fields: object) -> None:
        """Record and report an event after it has happened."""
        if event == "error":
            self._note_error(fields)
        if self._record is not None:
            self._record(event, **fields)
        if self.responses is not None:
            self.responses.note(event, fields)
        if self._callbacks:
            change = Change(event, MappingProxyType(_copied(fields)))
            for callback in self._callbacks:
                name = f"{getattr(callback, '__name__', 'a callback')}, called at each change,"
                try:
                    self.watchdog.call(callback, change, name)
                except Exception:
                    LOG.exception("a callback of on_change failed at %s", event)

    def tell_error(
        self,
        error: str,
        policy: str | None = None,
        *,
        transition: str | None = None,
        handler: str | None = None,
        attempt: int = 1,
    ) -> None:
        """Record and report an error."""
        where = {"transition": transition, "handler": handler}
        self.emit("error", **where, error=error, attempt=attempt, policy=policy)

    def record_with(self, record: Callable[..., None] | None) -> None:
        """Record with this function from now on; None: stop recording."""
        self._record = record
        self._observe()

    def measure(self, responses: Responses) -> None:
        """Measure response times from now on."""
        self.responses = responses
        self._observe()

    def struck(self, callback: str, moment: float, missed: int) -> None:
        """Measure a tick of a timer, if response times are measured."""
        if self.responses is not None:
            self.responses.struck(callback, moment, missed)

    def _observe(self) -> None:
        others = self._record is not None or self.responses is not None
        self.is_observing = others or bool(self._callbacks)

    def add_callback(self, callback: Callable[[Change], object]) -> None:
        """Call this function after each change from now on."""
        with self._lock:
            self._callbacks = (*self._callbacks, callback)
            self.is_observing = True

    def remove_callback(self, callback: Callable[[Change], object]) -> None:
        """Stop calling this function."""
        with self._lock:
            self._callbacks = tuple(known for known in self._callbacks if known is not callback)
            self._observe()

    def _note_error(self, fields: Mapping[str, object]) -> None:
        self.failures += 1
        transition, handler, policy = (
            None if fields.get(name) is None else str(fields[name])
            for name in ("transition", "handler", "policy")
        )
        self.errors.append(ErrorReport(time.time(), transition, handler, str(fields["error"]), policy))
        self.status_changed()

    def status_changed(self) -> None:
        """Notify the listener that the status may have changed."""
        if (callback := self.on_status) is not None:
            callback()


def _copied(value: Any) -> Any:
    """Return a copy of a record's values: callbacks cannot change tokens by changing it."""
    if isinstance(value, dict):
        return {key: _copied(element) for key, element in value.items()}
    if isinstance(value, (list, tuple)):
        return [_copied(element) for element in value]
    return value
