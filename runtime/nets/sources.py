"""What brings signals from outside, and how it is: counters and the last error of each bridge."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

LOG = logging.getLogger("dineros.runtime.bridges")

SAYING_PERIOD = 60.0
"""Seconds in which one thing that goes wrong is said once: whoever sends nonsense can send a lot of it."""

SHOWN = 300
"""Characters of an error that are kept."""


@dataclass(frozen=True)
class SourceState:
    """How a bridge is at one moment.

    Attributes
    ----------
    name : str
        What it is, such as ``mqtt broker:1883``; never with credentials.
    is_connected : bool
        Whether it listens, serves, or got its last answer.
    accepted, refused : int
        Messages that set signals, and those that could not.
    failures : int
        What else went wrong: lost connections, answers that did not come, exceptions.
    last_error : str or None
        The last thing that went wrong.
    last_error_time : float or None
        When, in seconds since the epoch.
    """

    name: str
    is_connected: bool = False
    accepted: int = 0
    refused: int = 0
    failures: int = 0
    last_error: str | None = None
    last_error_time: float | None = None


class Source:
    """Counts for a bridge, from any thread.

    Parameters
    ----------
    name : str
        What it is, without credentials.
    tell : callable
        Told each error that is said, to record it.

    Attributes
    ----------
    state : SourceState
        How it is now.
    """

    def __init__(self, name: str, tell: Callable[[str], None]) -> None:
        self._tell = tell
        self._lock = threading.Lock()
        self.state = SourceState(name)
        self._said: dict[str, float] = {}  # what -> when it may be said again
        self._unsaid: dict[str, int] = {}

    def connected(self, is_connected: bool) -> None:
        """Note whether it has its other end."""
        with self._lock:
            self.state = replace(self.state, is_connected=is_connected)

    def accept(self) -> None:
        """Count a message that set signals."""
        with self._lock:
            self.state = replace(self.state, accepted=self.state.accepted + 1)

    def refuse(self, what: str, error: object) -> None:
        """Count a message that sets nothing; `what` is one of few, such as a topic of the configuration."""
        with self._lock:
            self.state = replace(self.state, refused=self.state.refused + 1)
        self._say(what, error)

    def fail(self, what: str, error: object) -> None:
        """Count what else went wrong."""
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
