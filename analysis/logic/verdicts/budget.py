"""What a question may cost, and what was spent when it ran out."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Budget:
    """Limits of a search; None: no limit.

    Attributes
    ----------
    memory_bytes : int
        Bytes of the search's own tables, copies made while they grow included.
    states : int
        States stored.
    seconds : float
        Wall-clock time.
    """

    memory_bytes: int | None = None
    states: int | None = None
    seconds: float | None = None


@dataclass(frozen=True)
class Progress:
    """How far a search is: states stored, states a second, bytes of its tables."""

    states: int
    rate: float
    memory_bytes: int


ProgressCallback = Callable[[Any], None]


class BudgetExceededError(Exception):
    """A limit was hit; says which. Never leaves this package: answers become ``unknown``."""


@dataclass
class Meter:
    """Watches a budget while a search runs.

    Attributes
    ----------
    budget : Budget
    progress : callable, optional
        Called a few times a second.
    """

    budget: Budget
    progress: ProgressCallback | None = None
    started: float = field(default_factory=time.perf_counter)

    @property
    def seconds(self) -> float:
        """Seconds since the start."""
        return time.perf_counter() - self.started

    def check_memory(self, needed: int) -> None:
        """Raise `BudgetExceededError` when tables of `needed` bytes would be too large."""
        limit = self.budget.memory_bytes
        if limit is not None and needed > limit:
            raise BudgetExceededError(f"memory: more than {limit / 2**20:.0f} MiB needed")

    def report(self, states: int, memory_bytes: int, progress: Any = None) -> None:
        """Show progress and raise `BudgetExceededError` when time is up or there are too many states.

        An engine that has more to say than states and memory gives its own `progress`.
        """
        seconds = self.seconds
        if self.progress is not None:
            self.progress(progress or Progress(states, states / max(seconds, 1e-9), memory_bytes))
        if self.budget.states is not None and states > self.budget.states:
            raise BudgetExceededError(f"states: more than {self.budget.states}")
        self.check_time()

    def check_time(self) -> None:
        """Raise `BudgetExceededError` when time is up."""
        if self.budget.seconds is not None and self.seconds > self.budget.seconds:
            raise BudgetExceededError(f"time: more than {self.budget.seconds:g} s")
