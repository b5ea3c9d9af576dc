"""How handlers learn that the goal they execute is to be canceled."""

from __future__ import annotations

import threading
from collections.abc import Generator
from typing import Any

PERIOD = 0.02
"""Polling interval, in seconds, of a coroutine that waits."""


class CancelRequest:
    """Whether a handler's goal of an action is to be canceled; usable from any thread.

    If the transition belongs to no goal, no cancel is ever requested.

    Examples
    --------
    A handler on its own thread ends early::

        @net.handler("Drive", thread=True)
        def drive(firing):
            while not arrived() and not firing.cancel.wait(0.1):
                go_on()

    A handler on an event loop awaits the request: ``await firing.cancel``.
    """

    def __init__(self) -> None:
        self._event = threading.Event()

    @property
    def is_requested(self) -> bool:
        """Whether the goal is to be canceled."""
        return self._event.is_set()

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until a cancel is requested, or for `timeout` seconds; return whether it was requested."""
        return self._event.wait(timeout)

    def __await__(self) -> Generator[Any, None, None]:
        """Wait on an event loop until a cancel is requested."""
        import asyncio  # a slow import that most nodes do not need

        while not self._event.is_set():
            yield from asyncio.sleep(PERIOD).__await__()

    def set(self) -> None:
        """Notify the handlers; called by the action server."""
        self._event.set()
