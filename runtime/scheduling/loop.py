"""The loop of a node's thread, the only thread that changes the node; other threads queue actions here."""

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

    A node either runs on its own thread (`begin`, `adopt`, `abandon`), or its owner steps it (``with loop``).

    Parameters
    ----------
    clock : callable
        Returns the time in seconds; it never goes back.
    steady : callable, optional
        Returns the machine's time in seconds, if `clock` is the time of an external simulation, which may
        stand still. The owner of such a clock calls `run_actions` when its time advances; `wait` does not.

    Attributes
    ----------
    timers, steady_timers : Timers
        Timers by `clock` and by the machine's time; the same object without `steady`.
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
        """Whether it runs on its own thread."""
        return self._thread is not None

    @property
    def has_actions(self) -> bool:
        """Whether actions wait, not counting timers; from any thread."""
        return bool(self._inbox)

    def post(self, action: Callable[[], None]) -> None:
        """Queue an action for the node's thread; from any thread."""
        self._inbox.append(action)
        if self._is_waiting:  # set before `wait` reads the inbox, so that no action is missed
            self._wake.set()
        if (waker := self._waker) is not None:
            waker()

    def wake_by(self, waker: Callable[[], None] | None) -> None:
        """Call a function after each `post`, on the posting thread; None: stop calling one.

        For a node whose thread also waits for other things and therefore does not `wait` here.
        """
        self._waker = waker

    def submit(self, action: Callable[[], None]) -> None:
        """Run an action now if the node is idle, else soon on the node's thread; from any thread."""
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
        """Return a future for the result of a function on the node's thread; from any thread.

        If the thread ends before it has called the function, the future never gets a result.
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
        """Return the result of a function on the node's thread; from any thread."""
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
                if not self.is_running:  # it has ended in the meantime
                    with self._lock:
                        return function()

    def __enter__(self) -> Loop:
        """Begin a step; steps on other threads wait."""
        self._lock.acquire()
        self._depth += 1
        return self

    def __exit__(self, *exception: object) -> None:
        self._depth -= 1
        self._lock.release()

    def run_actions(self) -> bool:
        """Run all queued actions and due timers; return whether there were any."""
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
        """Wait for an action or a timer; False: there was none within `timeout` seconds."""
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
        """Reserve the loop for the node's own thread, which has yet to `adopt` it."""
        with self._lock:
            self._thread = 0

    def adopt(self) -> None:
        """Make the calling thread the node's own thread."""
        self._thread = threading.get_ident()

    def abandon(self) -> None:
        """Release the loop from its thread."""
        with self._lock:
            self._thread = None
