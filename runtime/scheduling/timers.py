"""Timers: actions at a later time, on the thread of the node's loop."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable


class Timer:
    """An action at a time; without an action, nothing happens."""

    __slots__ = ("action",)

    def __init__(self, action: Callable[[], None] | None = None) -> None:
        self.action = action

    def cancel(self) -> None:
        """Cancel the action."""
        self.action = None


IDLE = Timer()
"""Placeholder for a timer that is not set."""


class Timers:
    """A queue of timers.

    Parameters
    ----------
    clock : callable
        Returns the time in seconds; it never goes back.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._queue: list[tuple[float, int, Timer]] = []
        self._numbers = itertools.count()

    @property
    def now(self) -> float:
        """The time by the clock."""
        return self._clock()

    def call_later(self, delay: float, action: Callable[[], None]) -> Timer:
        """Call an action after a delay in seconds."""
        timer = Timer(action)
        heapq.heappush(self._queue, (self._clock() + delay, next(self._numbers), timer))
        return timer

    def __bool__(self) -> bool:
        """Whether there are any."""
        return bool(self._queue)

    @property
    def next_time(self) -> float | None:
        """Time of the next timer, by the clock; None: there is none."""
        while self._queue and self._queue[0][2].action is None:
            heapq.heappop(self._queue)
        return self._queue[0][0] if self._queue else None

    @property
    def seconds_left(self) -> float | None:
        """Seconds until the next timer; None: there is none."""
        due = self.next_time
        return None if due is None else max(0.0, due - self._clock())

    def run_due(self) -> bool:
        """Run all timers that are due; return whether there were any."""
        did = False
        while (time := self.next_time) is not None and time <= self._clock():
            action = heapq.heappop(self._queue)[2].action
            if action is not None:
                did = True
                action()
        return did
