"""The watchdog: which code of the developers runs on the node's thread, since when, and where it is.

While a plain handler runs, its node does nothing else. A separate thread checks periodically whether a
handler has run for too long, and reports it once, with the handler's stack. A node that is to end need not
wait for the handler: `Watchdog.give_up` detaches it from the node.
"""

from __future__ import annotations

import logging
import sys
import threading
import time
import traceback
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from threading import get_ident
from time import monotonic
from typing import NamedTuple, TypeVar

from dineros.runtime.scheduling.threads import join

LOG = logging.getLogger("dineros.runtime")
LIMIT = 10.0
"""Default time in seconds after which a handler that blocks its node is reported."""

_LONGEST_PERIOD = 1.0
_SHORTEST_PERIOD = 0.02

A = TypeVar("A")
R = TypeVar("R")


class GivenUpError(BaseException):
    """A handler returned after its node has stopped waiting for it; it must not use the node any more.

    It is not an `Exception`, so that only the node's loop catches it.
    """


@dataclass(frozen=True)
class Blocked:
    """Code of the developers that blocks the node's thread.

    Attributes
    ----------
    transition : str or None
        The transition of the handler; None: the selection, or a callback of `Net.on_change`.
    handler : str
        Its name.
    since : float
        Time of the call, in seconds since the epoch.
    stack : str
        Its position when the watchdog checked, as a traceback.
    """

    transition: str | None
    handler: str
    since: float
    stack: str

    def __str__(self) -> str:
        return f"the handler {self.handler} of {self.transition}" if self.transition else self.handler


class _Call(NamedTuple):
    """A call under way; `outer` is the call from within which it was made.

    The thread that takes the item out of `thread` decides how the call ends: the thread that runs it, when it
    returns, or the thread that gives it up. Taking the item is atomic, so that calls need no lock.
    """

    transition: str | None
    handler: str
    begun: float
    outer: _Call | None
    thread: list[int]


class Watchdog:
    """Watches the calls of one node.

    Parameters
    ----------
    name : str
        Name of the node, for messages.
    on_change : callable
        Called when a call is found to block the node, and when that has ended; from any thread.

    Attributes
    ----------
    limit : float or None
        Seconds that a call may take; None: unlimited.
    blocked : Blocked or None
        The call that has taken longer.
    """

    def __init__(self, name: str, on_change: Callable[[], None]) -> None:
        self.limit: float | None = LIMIT
        self.blocked: Blocked | None = None
        self._name = name
        self._on_change = on_change
        self._call: _Call | None = None
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None

    def call(self, function: Callable[[A], R], argument: A, handler: str, transition: str | None = None) -> R:
        """Call a function on the node's thread, and return its result.

        Raises
        ------
        GivenUpError
            The node has stopped waiting for it.
        """
        if self._thread is None and self.limit is not None:
            self._start()
        outer, thread = self._call, [get_ident()]
        self._call = call = _Call(transition, handler, monotonic(), outer, thread)
        try:
            return function(argument)
        finally:
            if not _taken(thread):
                raise GivenUpError
            self._call = outer
            if self.blocked is not None:
                self._unblock(call)

    def _unblock(self, call: _Call) -> None:
        was_blocked, self.blocked = self.blocked, None
        LOG.warning("%s has returned after %.1f s", was_blocked, monotonic() - call.begun)
        self._on_change()

    def give_up(self) -> tuple[str | None, str] | None:
        """Detach the running call from the node: its thread ends when the call returns.

        Returns
        -------
        tuple of str or None
            Transition and name of the abandoned call; None: no call is running.
        """
        while (innermost := self._call) is not None:
            if _taken(innermost.thread):
                break
            if self._call is innermost:  # it is returning at this moment
                time.sleep(0)
        else:
            return None
        call = innermost.outer
        while call is not None:  # the outer calls have not returned either
            _taken(call.thread)
            call = call.outer
        self._call = None
        self.blocked = None
        return innermost.transition, innermost.handler

    def close(self) -> None:
        """End the watching thread; the next `call` starts a new one."""
        thread, self._thread = self._thread, None
        if thread is not None:
            self._closing.set()
            if thread is not threading.current_thread():
                join(thread, _LONGEST_PERIOD)

    def _start(self) -> None:
        self._closing = threading.Event()
        self._thread = threading.Thread(
            target=_watch, args=(weakref.ref(self), self._closing), name="dineros watchdog", daemon=True
        )
        self._thread.start()

    def look(self, known: _Call | None) -> _Call | None:
        """Report the running call if it has run for too long and was not reported yet.

        Returns
        -------
        _Call or None
            The call that has been reported.
        """
        call, limit = self._call, self.limit
        if call is None or call is known or limit is None or monotonic() < call.begun + limit:
            return known
        self._report(call)
        return call

    @property
    def period(self) -> float:
        """Seconds between checks: short enough to report in time, long enough to cost little."""
        limit = _LONGEST_PERIOD if self.limit is None else self.limit / 4
        return min(_LONGEST_PERIOD, max(_SHORTEST_PERIOD, limit))

    def _report(self, call: _Call) -> None:
        seconds, running = monotonic() - call.begun, tuple(call.thread)
        if not running:  # it has just returned
            return
        blocked = Blocked(call.transition, call.handler, time.time() - seconds, _stack_of(running[0]))
        self.blocked = blocked
        if not call.thread:  # it has returned meanwhile, perhaps before it was marked as blocked
            self.blocked = None
            return
        LOG.error(
            "%s has blocked the node %s for %.1f s (make it async, or use thread=True):\n%s",
            blocked,
            self._name,
            seconds,
            blocked.stack,
        )
        self._on_change()


def _taken(item: list[int]) -> bool:
    """Remove the only item of a list; return whether it was there."""
    try:
        item.pop()
    except IndexError:
        return False
    return True


def _watch(watched: weakref.ref[Watchdog], closing: threading.Event) -> None:
    """Check periodically until the watchdog is closed, or is garbage because its node was never closed."""
    known: _Call | None = None
    period = _SHORTEST_PERIOD
    while not closing.wait(period):
        watchdog = watched()
        if watchdog is None:
            return
        known, period = watchdog.look(known), watchdog.period
        del watchdog  # this thread must not keep it alive


def _stack_of(thread: int) -> str:
    """Return the stack of a thread, beginning with the developers' function."""
    frame = sys._current_frames().get(thread)
    if frame is None:
        return ""
    stack = list(traceback.walk_stack(frame))[::-1]  # the outermost first
    own = [number for number, (each, _) in enumerate(stack) if each.f_code is Watchdog.call.__code__]
    shown = traceback.StackSummary.extract(iter(stack[own[-1] + 1 if own else 0 :]))
    return "".join(shown.format()).rstrip()
