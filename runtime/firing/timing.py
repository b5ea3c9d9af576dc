"""Time in a net: firing intervals (Merlin's time Petri nets) and the periods of timer callbacks.

A transition with an interval has a clock, which starts when the transition becomes ready. After another
firing, the clock continues if the transition stays ready while tokens are taken and after tokens are put: a
read arc does not reset it, a loop does. The transition fires when its clock is within the interval; if it has
reached the latest bound, the transition fires before others. A priority applies while the higher transition
could fire.

The callback of a timer begins at most once in each period, and a tick before the callback has begun is lost
(rule C1). Ticks come at multiples of the period: a late tick delays no other. They come from the loop's
clock, or from timers of the transport, such as those of rclpy. Time only delays firings: every reachable
marking is also reachable in the net without time.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from random import Random

from dineros.runtime.nets.engine import Engine
from dineros.runtime.nets.ports import TimerPort
from dineros.runtime.nets.structure import Structure
from dineros.runtime.scheduling.loop import Loop


class Timing:
    """Determines which ready transitions may fire now.

    Attributes
    ----------
    draws : Random or None
        Draws the moment of firing uniformly from the interval. If None, a transition fires at its earliest
        time; so does a transition with priority, for which others would otherwise wait past their latest
        times.
    """

    def __init__(
        self, structure: Structure, loop: Loop, on_strike: Callable[[str, float, int], object]
    ) -> None:
        self.draws: Random | None = None
        self._loop = loop
        self._intervals = {
            number: interval for number, interval in enumerate(structure.intervals) if interval is not None
        }
        self._above = {above for all_above in structure.superiors for above in all_above}
        self._since: dict[int, float] = {}
        self._ripe_at: dict[int, float] = {}
        self._timers = structure.ports.timers
        self._timer_of = {
            number: timer
            for timer, begins in zip(self._timers, structure.timers, strict=True)
            for number in begins
        }
        self._due: set[TimerPort] = set()
        self._is_ticking = False
        self._on_strike = on_strike

    def __bool__(self) -> bool:
        """Whether the net has any intervals or timers."""
        return bool(self._intervals or self._timers)

    @property
    def deadline(self) -> float | None:
        """Time at which some transition has to fire at the latest; None: there is no such time."""
        latest = (self._latest(number) for number in self._since)
        return min((each for each in latest if each is not None), default=None)

    def of(self, engine: Engine, ready: list[int]) -> list[int]:
        """Return which ready transitions may fire now; if some must fire now, only those."""
        self.observe(engine)
        if not self._is_ticking:
            self._is_ticking = True
            now = self._loop.clock()
            for timer in self._timers:
                self._tick_at(now + timer.period, timer)
        may = [
            each
            for each in ready
            if self._has_ticked(each)
            and self._is_ripe(each)
            and not engine.is_overridden(each, self._could_fire)
        ]
        now = self._loop.clock()
        must = [each for each in may if (latest := self._latest(each)) is not None and now >= latest]
        return must or may

    def observe(self, engine: Engine) -> None:
        """Start the clocks of newly ready transitions; stop clocks of those that were not always ready."""
        if not self._intervals:
            return
        broken = engine.note_breaks()
        for number in broken:
            self._stop(number)
        broken.clear()
        for number, (earliest, latest) in self._intervals.items():
            if not engine.is_ready(number):
                self._stop(number)
            elif number not in self._since:
                self._start(number, earliest, latest)

    def _start(self, number: int, earliest: float, latest: float | None) -> None:
        now = self._loop.clock()
        wait = earliest
        if self.draws is not None and latest is not None and number not in self._above:
            wait = self.draws.uniform(earliest, latest)
        self._since[number] = now
        self._ripe_at[number] = now + wait
        self._loop.timers.call_later(wait, _nothing)

    def _stop(self, number: int) -> None:
        self._since.pop(number, None)

    def began(self, number: int) -> None:
        """Notice that a transition fires: its clock restarts."""
        self._stop(number)
        if number in self._timer_of:
            self._due.discard(self._timer_of[number])

    def leave_ticks(self) -> None:
        """Disable automatic ticks: the transport calls `ticked`."""
        self._is_ticking = True

    def ticked(self, timer: TimerPort, moment: float | None = None, missed: int = 0) -> None:
        """Let the callback of a timer begin once; on the node's thread.

        Parameters
        ----------
        timer : TimerPort
            The timer.
        moment : float, optional
            Time of the tick, by the node's clock; by default now.
        missed : int
            Number of further ticks since then.
        """
        self._due.add(timer)
        self._on_strike(timer.callback, self._loop.clock() if moment is None else moment, missed)

    def _has_ticked(self, number: int) -> bool:
        timer = self._timer_of.get(number)
        return timer is None or timer in self._due

    def _is_ripe(self, number: int) -> bool:
        if number not in self._intervals:
            return True
        return number in self._since and self._loop.clock() >= self._ripe_at[number]

    def _could_fire(self, number: int) -> bool:
        """Return whether an enabled transition may fire by time; if in flight, it is firing already."""
        return number not in self._since or self._is_ripe(number)

    def _latest(self, number: int) -> float | None:
        interval = self._intervals.get(number)
        if interval is None or interval[1] is None or number not in self._since:
            return None
        return self._since[number] + interval[1]

    def _tick_at(self, due: float, timer: TimerPort) -> None:
        def tick() -> None:
            missed = max(0, math.floor((self._loop.clock() - due) / timer.period))
            self.ticked(timer, due, missed)
            self._tick_at(due + (missed + 1) * timer.period, timer)

        self._loop.timers.call_later(due - self._loop.clock(), tick)


def _nothing() -> None:
    """Do nothing; its timer wakes the loop up."""
