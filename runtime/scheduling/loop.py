"""The one thread on which a node changes: what other threads want done waits here for its turn."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from typing import TypeVar

from dineros.runtime.scheduling.timers import Timers

T = TypeVar("T")


class Loop:
    """A queue of actions for the node's thread, and its timers.

    A node either runs on a thread of its own (`begin`, `adopt`, `abandon`), or is stepped by whoever holds it
    (``with loop``).

    Parameters
    ----------
    clock : callable
        Returns the time in seconds; it never goes back.
    steady : callable, optional
        Returns the seconds of the machine, where the clock is that of a simulation which others drive, and
        which may stand still. Whoever has such a clock calls `run_actions` when it continues; `wait` does
        not.

    Attributes
    ----------
    timers, steady_timers : Timers
        Those that go by the clock, and those that go by the machine's: the same where the clock is that.
    """

    def __init__(
        self, clock: Callable[[], float] = time.monotonic, steady: Callable[[], float] | None = None
    ) -> None:
        self.clock = clock
        self.timers = Timers(clock)
        self.steady_timers = self.timers if steady is None else Timers(steady)
        self._inbox: deque[Callable[[], None]] = deque()
        self._wake = threading.Event()
        self._is_waiting = False
        self._waker: Callable[[], None] | None = None
        self._lock = threading.RLock()
        self._depth = 0
        self._thread: int | None = None

    @property
    def is_running(self) -> bool:
        """Whether a thread of its own runs it."""
        return self._thread is not None

    @property
    def has_actions(self) -> bool:
        """Whether something waits to be done, timers aside; from any thread."""
        return bool(self._inbox)

    def post(self, action: Callable[[], None]) -> None:
        """Have something done soon, on the node's thread; from any thread."""
        self._inbox.append(action)
        if self._is_waiting:  # set before `wait` looks into the inbox, so that none is missed
            self._wake.set()
        if (waker := self._waker) is not None:
            waker()

    def wake_by(self, waker: Callable[[], None] | None) -> None:
        """Have a function called after each `post`, on the thread that posts; None: none any more.

        For a node whose thread waits for other things as well, and so does not `wait` here.
        """
        self._waker = waker

    def submit(self, action: Callable[[], None]) -> None:
        """Have something done now if nothing else continues, soon otherwise; from any thread."""
        if self._thread is None and self._lock.acquire(blocking=False):
            try:
                if not self._depth and not self._inbox:
                    with self:
                        action()
                    return
            finally:
                self._lock.release()
        self.post(action)

    def ask(self, function: Callable[[], T]) -> Future[T]:
        """Return what will hold what a function finds on the node's thread; from any thread.

        Nothing ever comes of it where the thread ends before it is the function's turn.
        """
        future: Future[T] = Future()

        def answer() -> None:
            try:
                future.set_result(function())
            except BaseException as error:
                future.set_exception(error)

        self.post(answer)
        return future

    def call(self, function: Callable[[], T]) -> T:
        """Return what a function finds on the node's thread; from any thread."""
        if self._thread is None or self._thread == threading.get_ident():
            with self._lock:
                return function()
        future = self.ask(function)
        while True:
            try:
                return future.result(timeout=0.1)
            except TimeoutError:
                if future.done():
                    raise
                if not self.is_running:  # it has ended meanwhile
                    with self._lock:
                        return function()

    def __enter__(self) -> Loop:
        """Begin a step; steps of other threads wait."""
        self._lock.acquire()
        self._depth += 1
        return self

    def __exit__(self, *exception: object) -> None:
        self._depth -= 1
        self._lock.release()

    def run_actions(self) -> bool:
        """Do all that waits and all timers that are due; return whether there was something."""
        inbox = self._inbox
        did = bool(inbox)
        while inbox:
            inbox.popleft()()
        if self.timers and self.timers.run_due():
            did = True
        if self.steady_timers is not self.timers and self.steady_timers.run_due():
            did = True
        return did

    def wait(self, timeout: float | None = None) -> bool:
        """Wait for something to do, a timer included; False: there was none in `timeout` seconds."""
        end = None if timeout is None else self.clock() + timeout
        self._wake.clear()
        self._is_waiting = True
        try:
            due = self.timers.next_time
            until = min((time for time in (end, due) if time is not None), default=None)
            if self._inbox:
                return True
            if until is None:
                self._wake.wait()
            elif (left := until - self.clock()) > 0:
                self._wake.wait(left)
        finally:
            self._is_waiting = False
        due = self.timers.next_time
        return bool(self._inbox) or (due is not None and due <= self.clock())

    def begin(self) -> None:
        """Let the node's thread do things from now on; it is still to `adopt` the loop."""
        with self._lock:
            self._thread = 0

    def adopt(self) -> None:
        """Let the calling thread be the node's own."""
        self._thread = threading.get_ident()

    def abandon(self) -> None:
        """Let it be nobody's thread again."""
        with self._lock:
            self._thread = None
