"""Ending a process that was told to end, also where code of the developers does not return.

Who is told by a signal has a few seconds to end in order. A handler that neither returns nor can be cut off,
such as one that is called while the node is made, must not keep the process for longer.
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
"""From the signal to the end by force."""

_LEFT_OVER = 1.0
"""Seconds that an error has for being told, where threads of the developers are left over."""

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Ending:
    """Hears SIGINT and SIGTERM as long as its block lasts; to be used on the main thread.

    The signals are read by a thread of its own, so that they count also while the main thread does not come
    to Python's signal handlers.

    Parameters
    ----------
    status : int
        The exit status where the process has to be ended by force.
    on_signal : callable, optional
        What the signals do on the main thread besides; by default nothing.

    Attributes
    ----------
    asked : threading.Event
        Set when the process is told to end.
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
        """Hear no more. Where it was told to end, threads that were left over keep the process no longer."""
        for number, handler in self._former.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(self._former_pipe)
        os.close(self._pipe[1])
        self._has_ended.set()
        join(self._thread)
        os.close(self._pipe[0])
        if any(exception) and self._is_left_over():  # nobody will come to `leave`
            timer = threading.Timer(_LEFT_OVER, os._exit, (self._status,))
            timer.daemon = True
            timer.start()

    def leave(self, status: int) -> None:
        """End the process with this status where it was told to end and threads of the developers still run.

        To be called last, when all that is to be done is done. Python would wait at its exit for some of
        these threads, and take down under others what they use.
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
        """Say where everything hangs, and end."""
        with contextlib.suppress(Exception):
            os.write(2, b"told to end, and does not end by itself; it is at\n")
            faulthandler.dump_traceback(2)
        flushing = threading.Thread(target=_flush, daemon=True)  # somebody may hold the streams
        flushing.start()
        flushing.join(0.2)
        os._exit(self._status)


def _flush() -> None:
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(Exception):
            stream.flush()
