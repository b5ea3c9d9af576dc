"""Time in a net: firing intervals (Merlin's time Petri nets) and the periods of timer callbacks.

A transition with an interval fires only when it has been ready for its earliest time without a break; one
that has been so for its latest time goes before others. The callback of a timer begins at most once in each
period, and a tick that comes before it has begun is gone (rule C1). Ticks come at multiples of the period: a
late one delays no other. They are those of the loop's clock, or of the timers that a transport has, such as
those of rclpy. Both only delay: every marking is one of the net without time.
"""

from __future__ import annotations

import math

from dineros.runtime.nets.engine import Engine
from dineros.runtime.nets.ports import TimerPort
from dineros.runtime.nets.structure import Structure
from dineros.runtime.scheduling.loop import Loop


class Timing:
    """Which of the ready transitions may fire by now."""

    def __init__(self, structure: Structure, loop: Loop) -> None:
        self._loop = loop
        self._intervals = {
            number: interval for number, interval in enumerate(structure.intervals) if interval is not None
        }
        self._ready_since: dict[int, float] = {}
        self._timers = structure.ports.timers
        self._timer_of = {
            number: timer
            for timer, begins in zip(self._timers, structure.timers, strict=True)
            for number in begins
        }
        self._due: set[TimerPort] = set()
        self._is_ticking = False

    def __bool__(self) -> bool:
        """Whether the net has any time in it."""
        return bool(self._intervals or self._timers)

    def of(self, engine: Engine, ready: list[int]) -> list[int]:
        """Return which of some ready transitions may fire now; those that must, if there are any."""
        now = self._loop.clock()
        if not self._is_ticking:
            self._is_ticking = True
            for timer in self._timers:
                self._tick_at(now + timer.period, timer)
        for number, (earliest, _) in self._intervals.items():
            if not engine.is_ready(number):
                self._ready_since.pop(number, None)
            elif number not in self._ready_since:
                self._ready_since[number] = now
                self._loop.timers.call_later(earliest, _nothing)
        may = [each for each in ready if self._has_ticked(each) and self._is_ripe(each, now)]
        must = [each for each in may if self._is_late(each, now)]
        return must or may

    def began(self, number: int) -> None:
        """Note that a transition fires: its time starts anew."""
        self._ready_since.pop(number, None)
        if number in self._timer_of:
            self._due.discard(self._timer_of[number])

    def leave_ticks(self) -> None:
        """Let no timer tick by itself: a transport tells of `ticked`."""
        self._is_ticking = True

    def ticked(self, timer: TimerPort) -> None:
        """Let the callback of a timer begin, once; on the node's thread."""
        self._due.add(timer)

    def _has_ticked(self, number: int) -> bool:
        timer = self._timer_of.get(number)
        return timer is None or timer in self._due

    def _is_ripe(self, number: int, now: float) -> bool:
        interval = self._intervals.get(number)
        return interval is None or now >= self._ready_since[number] + interval[0]

    def _is_late(self, number: int, now: float) -> bool:
        interval = self._intervals.get(number)
        if interval is None or interval[1] is None:
            return False
        return now >= self._ready_since[number] + interval[1]

    def _tick_at(self, due: float, timer: TimerPort) -> None:
        def tick() -> None:
            self.ticked(timer)
            missed = max(0, math.floor((self._loop.clock() - due) / timer.period))
            self._tick_at(due + (missed + 1) * timer.period, timer)

        self._loop.timers.call_later(due - self._loop.clock(), tick)


def _nothing() -> None:
    """Wake the loop up."""
