"""The watchdog: what of the developers' code runs on the node's thread, since when, and where it is.

While a plain handler runs, its node does nothing else. A thread of its own looks from time to time whether
one has run for too long, and says so, once, with the handler's stack. A node that is to end need not wait for
it either: `Watchdog.give_up` cuts it off from the node.
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
"""Seconds after which a handler that blocks its node is named, where nobody says otherwise."""

_LONGEST_PERIOD = 1.0
_SHORTEST_PERIOD = 0.02

A = TypeVar("A")
R = TypeVar("R")


class GivenUpError(BaseException):
    """A handler returned to a node that has not waited for it; nothing of the node may be touched any more.

    No `Exception`: nobody but the node's loop catches it.
    """


@dataclass(frozen=True)
class Blocked:
    """Code of the developers that keeps a node from doing anything else.

    Attributes
    ----------
    transition : str or None
        Whose handler it is; None: the selection, or a callback of `Net.on_change`.
    handler : str
        Its name.
    since : float
        When it was called, in seconds since the epoch.
    stack : str
        Where it was when the watchdog looked, as in a traceback.
    """

    transition: str | None
    handler: str
    since: float
    stack: str

    def __str__(self) -> str:
        return f"the handler {self.handler} of {self.transition}" if self.transition else self.handler


class _Call(NamedTuple):
    """A call under way; `outer` is the one from within which it was made.

    Whoever takes the item out of `thread` decides how it ends: the thread that it runs on, when it returns,
    or who gives it up. Taking it out is one step, so that no lock is needed at each call.
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
        The node's, for its messages.
    on_change : callable
        Called when a call is found to block the node, and when that is over; from any thread.

    Attributes
    ----------
    limit : float or None
        Seconds that a call may take; None: as long as it wants.
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
        """Call a function on the node's thread, and return what it returns.

        Raises
        ------
        GivenUpError
            The node has not waited for it.
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
        """Cut the call that runs now off from the node: its thread ends when it returns.

        Returns
        -------
        tuple of str or None
            Transition and name of what was given up; None: no call runs.
        """
        while (innermost := self._call) is not None:
            if _taken(innermost.thread):
                break
            if self._call is innermost:  # it returns just now: its thread is between two steps
                time.sleep(0)
        else:
            return None
        call = innermost.outer
        while call is not None:  # these have not returned either
            _taken(call.thread)
            call = call.outer
        self._call = None
        self.blocked = None
        return innermost.transition, innermost.handler

    def close(self) -> None:
        """End the thread; the next `call` starts another one."""
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
        """Report the call that runs now where it has run for too long and is not the one known already.

        Returns
        -------
        _Call or None
            The one that is known now.
        """
        call, limit = self._call, self.limit
        if call is None or call is known or limit is None or monotonic() < call.begun + limit:
            return known
        self._report(call)
        return call

    @property
    def period(self) -> float:
        """Seconds until the next look: soon enough to tell in time, and no cost to speak of."""
        limit = _LONGEST_PERIOD if self.limit is None else self.limit / 4
        return min(_LONGEST_PERIOD, max(_SHORTEST_PERIOD, limit))

    def _report(self, call: _Call) -> None:
        seconds, running = monotonic() - call.begun, tuple(call.thread)
        if not running:  # it has just returned
            return
        blocked = Blocked(call.transition, call.handler, time.time() - seconds, _stack_of(running[0]))
        self.blocked = blocked
        if not call.thread:  # it has returned meanwhile, and may not have seen that it was found
            self.blocked = None
            return
        LOG.error(
            "%s has kept the node %s from all else for %.1f s (let it be async, or say thread=True):\n%s",
            blocked,
            self._name,
            seconds,
            blocked.stack,
        )
        self._on_change()


def _taken(item: list[int]) -> bool:
    """Take the only item out of a list; return whether it was there."""
    try:
        item.pop()
    except IndexError:
        return False
    return True


def _watch(watched: weakref.ref[Watchdog], closing: threading.Event) -> None:
    """Look from time to time, until the watchdog is closed; or gone, with a node that nobody closed."""
    known: _Call | None = None
    period = _SHORTEST_PERIOD
    while not closing.wait(period):
        watchdog = watched()
        if watchdog is None:
            return
        known, period = watchdog.look(known), watchdog.period
        del watchdog  # which this thread must not keep alive


def _stack_of(thread: int) -> str:
    """Return the stack of a thread, from the developers' function on."""
    frame = sys._current_frames().get(thread)
    if frame is None:
        return ""
    stack = list(traceback.walk_stack(frame))[::-1]  # the outermost first
    own = [number for number, (each, _) in enumerate(stack) if each.f_code is Watchdog.call.__code__]
    shown = traceback.StackSummary.extract(iter(stack[own[-1] + 1 if own else 0 :]))
    return "".join(shown.format()).rstrip()
