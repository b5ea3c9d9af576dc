"""Run times of handlers, and which handlers exceed their declared time (``budget=``)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from dineros.runtime.firing.handlers import Handler


@dataclass(slots=True)
class HandlerTime:
    """Run times of one handler of one transition, in seconds of real time.

    Attributes
    ----------
    transition : str
        Id of the transition.
    handler : str
        Name of the handler.
    budget : float or None
        Declared maximum, in seconds.
    calls : int
        Number of runs.
    total : float
        Sum of all runs.
    longest : float
        Longest run since the last `Durations.forget_longest`.
    slow : int
        Number of runs longer than the budget.
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
        """Average run time."""
        return self.total / max(1, self.calls)


class Durations:
    """Run times of all handlers of a node; on its thread. A transition without handlers needs no entry."""

    def __init__(self, transitions: Sequence[str]) -> None:
        self._transitions = transitions
        self._times: dict[tuple[int, str], HandlerTime] = {}

    def note(self, transition: int, handler: Handler, seconds: float) -> None:
        """Record a run of a handler that took this time, even if it failed."""
        key = transition, handler.name
        time = self._times.get(key)
        if time is None:
            time = self._times[key] = HandlerTime(self._transitions[transition], handler.name, handler.budget)
        time.calls += 1
        time.total += seconds
        time.longest = max(time.longest, seconds)
        if handler.budget is not None:
            time.budget = handler.budget  # another handler may have been registered under its name
            time.slow += seconds > handler.budget

    def __iter__(self) -> Iterator[HandlerTime]:
        return iter(self._times.values())

    def forget_longest(self) -> None:
        """Reset `HandlerTime.longest` of all handlers."""
        for time in self._times.values():
            time.longest = 0.0
