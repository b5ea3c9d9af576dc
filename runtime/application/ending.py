"""Ends a process on request, even if code of the developers does not return.

After a signal, the process has a few seconds to end in order. A handler that neither returns nor can be
abandoned, such as one called while the node is created, must not keep the process alive longer.
"""

from __future__ import annotations

import contextlib
import faulthandler
import logging
import os
import signal
import sys
import threading
from collections.abc import Callable
from types import FrameType
from typing import Any

from dineros.runtime.scheduling.threads import join

SECONDS = 4.5
"""Seconds from the signal to a forced end."""

_LEFT_OVER = 1.0
"""Seconds to report an error while threads of the developers still run."""

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Ending:
    """Handles SIGINT and SIGTERM while its block lasts; for the main thread.

    A separate thread reads the signals, so that they take effect even while the main thread does not reach
    Python's signal handlers.

    Parameters
    ----------
    status : int
        Exit status for a forced end.
    on_signal : callable, optional
        Additional action on the main thread at a signal; by default none.

    Attributes
    ----------
    asked : threading.Event
        Set when a signal asked the process to end.
    """

    def __init__(
        self, status: int = 1, on_signal: Callable[[int, FrameType | None], Any] | None = None
    ) -> None:
        self.asked = threading.Event()
        self._status = status
        self._on_signal = on_signal or (lambda *_: None)
        self._has_ended = threading.Event()
        self._known = set(threading.enumerate())
        self._pipe = (-1, -1)

    def __enter__(self) -> Ending:
        self._pipe = os.pipe()
        os.set_blocking(self._pipe[1], False)
        self._former_pipe = signal.set_wakeup_fd(self._pipe[1], warn_on_full_buffer=False)
        self._former = {number: signal.signal(number, self._on_signal) for number in _SIGNALS}
        self._thread = threading.Thread(target=self._hear, name="dineros ending", daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *exception: object) -> None:
        """Stop handling signals. After a signal, remaining threads no longer keep the process alive."""
        for number, handler in self._former.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(self._former_pipe)
        os.close(self._pipe[1])
        self._has_ended.set()
        join(self._thread)
        os.close(self._pipe[0])
        if any(exception) and self._is_left_over():  # `leave` will not be called
            timer = threading.Timer(_LEFT_OVER, os._exit, (self._status,))
            timer.daemon = True
            timer.start()

    def leave(self, status: int) -> None:
        """End the process with this status if a signal came and threads of the developers still run.

        Call it last. At its exit, Python would wait for some of these threads, and remove objects that others
        use.
        """
        if self._is_left_over():
            logging.shutdown()
            _flush()
            os._exit(status)

    def _is_left_over(self) -> bool:
        # Daemons as well: Python waits at its exit for all threads of `concurrent.futures`.
        return self.asked.is_set() and not self._known.issuperset(threading.enumerate())

    def _hear(self) -> None:
        while heard := os.read(self._pipe[0], 64):
            if any(number in heard for number in _SIGNALS):
                self.asked.set()
                if not self._has_ended.wait(SECONDS):
                    self._force()
                return

    def _force(self) -> None:
        """Print where the threads are stuck, and end the process."""
        with contextlib.suppress(Exception):
            os.write(2, b"was asked to end and still runs; its stack:\n")
            faulthandler.dump_traceback(2)
        flushing = threading.Thread(target=_flush, daemon=True)  # another thread may hold the streams
        flushing.start()
        flushing.join(0.2)
        os._exit(self._status)


def _flush() -> None:
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(Exception):
            stream.flush()
