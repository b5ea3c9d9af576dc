"""How long handlers take, and which of them take longer than they declare (``budget=``)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from dineros.runtime.firing.handlers import Handler


@dataclass(slots=True)
class HandlerTime:
    """What one handler of one transition has taken, in seconds of the machine.

    Attributes
    ----------
    transition : int
        Number of the transition.
    handler : str
        Its name.
    budget : float or None
        Seconds that it declares to take at most.
    calls : int
        How often it has run.
    total, last : float
        In all, and the last time.
    longest : float
        Since `Durations.forget_longest`.
    slow : int
        How often it took longer than its budget.
    """

    transition: int
    handler: str
    budget: float | None
    calls: int = 0
    total: float = 0.0
    last: float = 0.0
    longest: float = 0.0
    slow: int = 0


class Durations:
    """The times of all handlers of a node; on its thread. A transition without handlers costs nothing."""

    def __init__(self) -> None:
        self._times: dict[tuple[int, str], HandlerTime] = {}

    def note(self, transition: int, handler: Handler, seconds: float) -> None:
        """Note that a handler has run for so long, whatever came of it."""
        key = transition, handler.name
        time = self._times.get(key)
        if time is None:
            time = self._times[key] = HandlerTime(transition, handler.name, handler.budget)
        time.calls += 1
        time.total += seconds
        time.last = seconds
        time.longest = max(time.longest, seconds)
        if handler.budget is not None:
            time.budget = handler.budget  # another handler may have taken its name
            time.slow += seconds > handler.budget

    def __iter__(self) -> Iterator[HandlerTime]:
        return iter(self._times.values())

    def forget_longest(self) -> None:
        """Begin a new stretch for `HandlerTime.longest`."""
        for time in self._times.values():
            time.longest = 0.0
