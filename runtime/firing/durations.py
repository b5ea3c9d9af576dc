"""How long handlers take, and which of them take longer than they declare (``budget=``)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from dineros.runtime.firing.handlers import Handler


@dataclass(slots=True)
class HandlerTime:
    """What one handler of one transition has taken, in seconds of the machine.

    Attributes
    ----------
    transition : str
        Id of the transition.
    handler : str
        Its name.
    budget : float or None
        Seconds that it declares to take at most.
    calls : int
        How often it has run.
    total : float
        In all.
    longest : float
        Since `Durations.forget_longest`.
    slow : int
        How often it took longer than its budget.
    """

    transition: str
    handler: str
    budget: float | None
    calls: int = 0
    total: float = 0.0
    longest: float = 0.0
    slow: int = 0

    @property
    def mean(self) -> float:
        """What it takes on average."""
        return self.total / max(1, self.calls)


class Durations:
    """The times of all handlers of a node; on its thread. A transition without handlers costs nothing."""

    def __init__(self, transitions: Sequence[str]) -> None:
        self._transitions = transitions
        self._times: dict[tuple[int, str], HandlerTime] = {}

    def note(self, transition: int, handler: Handler, seconds: float) -> None:
        """Note that a handler has run for so long, whatever came of it."""
        key = transition, handler.name
        time = self._times.get(key)
        if time is None:
            time = self._times[key] = HandlerTime(self._transitions[transition], handler.name, handler.budget)
        time.calls += 1
        time.total += seconds
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
