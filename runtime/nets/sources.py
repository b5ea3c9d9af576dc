"""Signal sources outside the net and their state: counters and the last error of each bridge."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

LOG = logging.getLogger("dineros.runtime.bridges")

SAYING_PERIOD = 60.0
"""Seconds before the same error is reported again: a sender of invalid data can send a lot of it."""

SHOWN = 300
"""Maximum length of a stored error, in characters."""


@dataclass(frozen=True)
class SourceState:
    """The state of a bridge at one moment.

    Attributes
    ----------
    name : str
        Its description, such as ``mqtt broker:1883``; never with credentials.
    is_connected : bool
        Whether it listens, serves, or got its last response.
    accepted, refused : int
        Number of messages that set signals, and of invalid messages.
    failures : int
        Number of other failures: lost connections, missing responses, exceptions.
    last_error : str or None
        The last error.
    last_error_time : float or None
        Time of the last error, in seconds since the epoch.
    """

    name: str
    is_connected: bool = False
    accepted: int = 0
    refused: int = 0
    failures: int = 0
    last_error: str | None = None
    last_error_time: float | None = None


class Source:
    """Counts events of a bridge, from any thread.

    Parameters
    ----------
    name : str
        Its description, without credentials.
    tell : callable
        Records each reported error.

    Attributes
    ----------
    state : SourceState
        Its current state.
    """

    def __init__(self, name: str, tell: Callable[[str], None]) -> None:
        self._tell = tell
        self._lock = threading.Lock()
        self.state = SourceState(name)
        self._said: dict[str, float] = {}  # kind of error -> when it may be reported again
        self._unsaid: dict[str, int] = {}

    def connected(self, is_connected: bool) -> None:
        """Record whether it is connected."""
        with self._lock:
            self.state = replace(self.state, is_connected=is_connected)

    def accept(self) -> None:
        """Count a message that set signals."""
        with self._lock:
            self.state = replace(self.state, accepted=self.state.accepted + 1)

    def refuse(self, what: str, error: object) -> None:
        """Count a message that sets nothing; `what` is one of few texts, such as a configured topic."""
        with self._lock:
            self.state = replace(self.state, refused=self.state.refused + 1)
        self._say(what, error)

    def fail(self, what: str, error: object) -> None:
        """Count another failure."""
        with self._lock:
            self.state = replace(self.state, failures=self.state.failures + 1)
        self._say(what, error)

    def _say(self, what: str, error: object) -> None:
        text = f"{what}: {error}"
        if len(text) > SHOWN:
            text = f"{text[: SHOWN - 3]}..."
        text = "".join(each if each.isprintable() else repr(each)[1:-1] for each in text)
        now = time.monotonic()
        with self._lock:
            self.state = replace(self.state, last_error=text, last_error_time=time.time())
            if now < self._said.get(what, 0.0):
                self._unsaid[what] = self._unsaid.get(what, 0) + 1
                return
            self._said[what] = now + SAYING_PERIOD
            unsaid = self._unsaid.pop(what, 0)
        if unsaid:
            text += f" ({unsaid} like this were only counted)"
        LOG.error("%s", text)
        self._tell(text)
