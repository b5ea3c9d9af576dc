"""Things to do later, on the thread of the node's loop."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable


class Timer:
    """Something to do at a time; without an action, nothing."""

    __slots__ = ("action",)

    def __init__(self, action: Callable[[], None] | None = None) -> None:
        self.action = action

    def cancel(self) -> None:
        """Do nothing when the time comes."""
        self.action = None


IDLE = Timer()
"""What stands where there is nothing to wait for."""


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
        """Do something after a delay in seconds."""
        timer = Timer(action)
        heapq.heappush(self._queue, (self._clock() + delay, next(self._numbers), timer))
        return timer

    def __bool__(self) -> bool:
        """Whether there are any."""
        return bool(self._queue)

    @property
    def next_time(self) -> float | None:
        """When the next timer is due, by the clock; None without one."""
        while self._queue and self._queue[0][2].action is None:
            heapq.heappop(self._queue)
        return self._queue[0][0] if self._queue else None

    @property
    def seconds_left(self) -> float | None:
        """Seconds until the next timer is due; None without one."""
        due = self.next_time
        return None if due is None else max(0.0, due - self._clock())

    def run_due(self) -> bool:
        """Do all that is due; return whether something was."""
        did = False
        while (time := self.next_time) is not None and time <= self._clock():
            action = heapq.heappop(self._queue)[2].action
            if action is not None:
                did = True
                action()
        return did
