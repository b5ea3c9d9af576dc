"""How handlers learn that the goal they work on is to be canceled."""

from __future__ import annotations

import threading
from collections.abc import Generator
from typing import Any

PERIOD = 0.02
"""Seconds between looks of a coroutine that waits."""


class CancelRequest:
    """Whether the goal of an action that a handler works on is to be canceled; from any thread.

    Where a transition belongs to no goal, it never is.

    Examples
    --------
    A handler on a thread of its own ends early::

        @net.handler("Drive", thread=True)
        def drive(firing):
            while not arrived() and not firing.cancel.wait(0.1):
                go_on()

    One on an event loop awaits the request: ``await firing.cancel``.
    """

    def __init__(self) -> None:
        self._event = threading.Event()

    @property
    def is_requested(self) -> bool:
        """Whether the goal is to be canceled."""
        return self._event.is_set()

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until the goal is to be canceled, or for some seconds; return whether it is."""
        return self._event.wait(timeout)

    def __await__(self) -> Generator[Any, None, None]:
        """Wait on an event loop until the goal is to be canceled."""
        import asyncio  # which takes a while, and most nodes need none

        while not self._event.is_set():
            yield from asyncio.sleep(PERIOD).__await__()

    def set(self) -> None:
        """Let the handlers know; for the server of the action."""
        self._event.set()
