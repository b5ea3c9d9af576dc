"""A clock for budgets in tests: a busy machine, and compilation, do not use up their time.

The time of a budget is that of the processor without what Numba compiles. It is never more than the time of
the wall, and never less than a tenth of it, so that a budget also ends while the process waits.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from numba.core import event

from dineros.analysis.answers import budget as budgets

SLOWEST = 0.1
"""Least share of the time of the wall."""


class OwnTime(event.Listener):
    """A clock, in place of the module `time` in the module of budgets; a forked process continues it."""

    def __init__(self) -> None:
        self._shown = time.perf_counter()
        self._begin()
        os.register_at_fork(after_in_child=self._begin)

    def _begin(self) -> None:
        self._wall, self._processor = time.perf_counter(), time.process_time()
        self._compiling = 0

    def perf_counter(self) -> float:
        """Return the seconds of this clock."""
        wall, processor = time.perf_counter(), time.process_time()
        passed = wall - self._wall
        worked = 0.0 if self._compiling else min(processor - self._processor, passed)
        self._shown += max(worked, passed * SLOWEST)
        self._wall, self._processor = wall, processor
        return self._shown

    process_time = perf_counter

    def advance(self, seconds: float) -> None:
        """Let time pass without a wait."""
        self._shown += seconds

    def on_start(self, _: event.Event) -> None:
        """Stop for a compilation; compilations may be nested."""
        self.perf_counter()
        self._compiling += 1

    def on_end(self, _: event.Event) -> None:
        """Continue after a compilation."""
        self.perf_counter()
        self._compiling -= 1


CLOCK = OwnTime()


@contextmanager
def of_budgets() -> Iterator[None]:
    """Let the budgets of this process count its own time."""
    with pytest.MonkeyPatch.context() as patch, event.install_listener("numba:compile", CLOCK):
        patch.setattr(budgets, "time", CLOCK)
        yield
