"""Observers of a net, and how errors are reported to them."""

from __future__ import annotations

from typing import Protocol

from dineros.metamodel.errors import DinerosError
from dineros.runtime.scheduling.watchdog import Watchdog


class FiringObserver(Protocol):
    """Receives the events of a net.

    Attributes
    ----------
    is_observing : bool
        Whether there is an observer; if not, no event is built.
    watchdog : Watchdog
        Watches the functions of developers on the node's thread.
    """

    is_observing: bool
    watchdog: Watchdog

    def emit(self, event: str, **fields: object) -> None:
        """Report an event after it has happened."""

    def tell_error(
        self,
        error: str,
        policy: str | None = None,
        *,
        transition: str | None = None,
        handler: str | None = None,
        attempt: int = 1,
    ) -> None:
        """Record an error with its policy, location and attempt number."""

    def struck(self, callback: str, moment: float, missed: int) -> None:
        """Notice a tick of a timer: its callback, the time, and the number of missed ticks before it."""

    def status_changed(self) -> None:
        """Notice that the node's status may have changed: running, halted or blocked."""


def shown(error: BaseException) -> str:
    """Return an exception as one line; errors of DiNeROS without their type."""
    text = " ".join(str(error).split())
    if isinstance(error, DinerosError):
        return text
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
