"""The budget of a question: time and memory, of which each stage gets a share.

The clock limits the whole question. Stages count the time of the processor, too, so that each has its share
on a busy machine.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Literal

DEFAULT_MEMORY = 2 << 30
"""Default memory for decision diagrams, in bytes."""


STRETCH, MOST_STRETCHED = 4, 0.5
"""Times its share that a stage may take by the clock on a busy machine, up to this part of the time left.

A larger share is one by the clock, so that the rest stays for what follows.
"""

RAN_OUT = {"time": "time ran out", "memory": "memory ran out"}
"""Reasons of unknown answers in reports, by the names that engines use."""


@dataclass(frozen=True)
class Progress:
    """The progress of an engine.

    Attributes
    ----------
    unit : {"markings", "states", "nodes", "steps"}
        The unit of `count`; nodes are those of a decision diagram, steps those of a run.
    count : int
        The number found so far.
    memory_bytes : int
        Bytes of its tables.
    rate : float or None
        Number found per second; None if it is not meaningful.
    at_least : int
        Number of markings that exist at least, if a diagram knows it.
    """

    unit: Literal["markings", "states", "nodes", "steps"]
    count: int
    memory_bytes: int
    rate: float | None = None
    at_least: int = 0

    def __str__(self) -> str:
        rate = [f"{self.rate:,.0f}/s"] if self.rate else []
        return ", ".join([f"{self.count:,} {self.unit}", *rate, f"{self.memory_bytes / 2**20:,.0f} MiB"])


ProgressCallback = Callable[[Progress], None]
StageCallback = Callable[[str], None]


class BudgetExceededError(Exception):
    """A limit was exceeded; the text names it. Callers of the analysis get an ``unknown`` answer instead."""


class _Processor:
    """The seconds of the processor; a forked process continues those of its parent."""

    def __init__(self) -> None:
        self._earlier = self._at_fork = 0.0
        os.register_at_fork(before=self._note, after_in_child=self._continue)

    def seconds(self) -> float:
        """Return the seconds so far."""
        return time.process_time() + self._earlier

    def _note(self) -> None:
        self._at_fork = self.seconds()

    def _continue(self) -> None:
        self._earlier = self._at_fork


processor_seconds = _Processor().seconds


@dataclass(frozen=True)
class Budget:
    """Limits of a question, and callbacks for its progress; None: no limit.

    The clock runs once the budget has `begun`. Stages get shares of the rest, and all of them end with the
    whole budget. A stage ends when its share has passed by the clock and on the processor, and at the latest
    after `STRETCH` times its share by the clock; see `MOST_STRETCHED`.

    Attributes
    ----------
    memory_bytes : int
        Bytes of an engine's own tables, including copies made while they grow.
    states : int
        Maximum number of stored states; states represented by a diagram do not count.
    seconds : float
        Wall-clock time from the beginning.
    progress : callable
        Called a few times a second; an exception raised in it ends the work; after KeyboardInterrupt the
        engine returns an answer if it has one.
    stages : callable
        Called with the name of each stage of the work when it begins; see `stage`.
    cores : int or None
        Processors for the threads of an engine; None: all that the process may use.
    started, deadline : float or None
        Values of `time.perf_counter` at the beginning, and at the end of the time limit.
    share_ends : tuple of float, or None
        Of a stage: values of `time.perf_counter` and `processor_seconds` when its share has passed.

    Examples
    --------
    >>> whole = Budget(memory_bytes=1 << 30, seconds=60).begun()
    >>> stage = whole.share(time=0.1, memory=0.5)
    >>> stage.memory_bytes == 1 << 29, stage.deadline < whole.deadline
    (True, True)
    """

    memory_bytes: int | None = None
    states: int | None = None
    seconds: float | None = None
    progress: ProgressCallback | None = field(default=None, compare=False, repr=False)
    stages: StageCallback | None = field(default=None, compare=False, repr=False)
    cores: int | None = field(default=None, compare=False, repr=False)
    started: float | None = field(default=None, compare=False, repr=False)
    deadline: float | None = field(default=None, compare=False, repr=False)
    share_ends: tuple[float, float] | None = field(default=None, compare=False, repr=False)

    def begun(self) -> Budget:
        """Return the budget with its clock running; the same object if it runs already."""
        if self.started is not None:
            return self
        now = time.perf_counter()
        return replace(self, started=now, deadline=None if self.seconds is None else now + self.seconds)

    def share(
        self,
        time: float = 1.0,
        memory: float = 1.0,
        *,
        most_bytes: int | None = None,
        most_states: int | None = None,
    ) -> Budget:
        """Return the budget of a stage, with its clock running.

        Parameters
        ----------
        time, memory : float
            Shares of the remaining time, and of the memory.
        most_bytes, most_states : int, optional
            Upper limits of the stage.
        """
        whole = self.begun()
        bytes_of_share = None if self.memory_bytes is None else int(self.memory_bytes * memory)
        stage = replace(
            whole,
            memory_bytes=_smaller(bytes_of_share, most_bytes),
            states=_smaller(self.states, most_states),
        )
        left = whole.left
        if left is None or time == 1:
            return stage
        return stage._stage(left * time)

    def at_most(self, seconds: float) -> Budget:
        """Return the budget of a stage limited to this number of seconds and to the remaining time."""
        left = self.left
        if left is not None and left <= seconds:
            return self.begun()
        return self._stage(max(0.0, seconds))

    def part(self, part: float) -> Budget:
        """Return the budget of a stage limited to a part of the whole time, and to the remaining time."""
        return self.begun() if self.seconds is None else self.at_most(part * self.seconds)

    def _stage(self, seconds: float) -> Budget:
        """Return the budget of a stage with this number of seconds from now."""
        now, most = time.perf_counter(), STRETCH * seconds
        if self.deadline is not None:
            left = self.deadline - now
            most = min(left, max(seconds, min(most, MOST_STRETCHED * left)))
        return replace(
            self,
            started=now,
            seconds=seconds,
            deadline=now + most,
            share_ends=(now + seconds, processor_seconds() + seconds),
        )

    def unless_limited(self, seconds: float) -> Budget:
        """Return the budget with this number of seconds from now, if it has no limit of time."""
        return self.begun() if self.left is not None else self.at_most(seconds)

    @property
    def memory(self) -> int:
        """Bytes for decision diagrams."""
        return DEFAULT_MEMORY if self.memory_bytes is None else self.memory_bytes

    @property
    def workers(self) -> int:
        """Threads that an engine may start."""
        return processors() if self.cores is None else self.cores

    @property
    def spent(self) -> float:
        """Seconds since the beginning."""
        return 0.0 if self.started is None else time.perf_counter() - self.started

    @property
    def left(self) -> float | None:
        """Remaining seconds; None: no limit."""
        if self.deadline is None:
            return self.seconds
        now = time.perf_counter()
        left = max(0.0, self.deadline - now)
        if self.share_ends is None:
            return left
        by_clock, by_processor = self.share_ends
        return min(left, max(0.0, by_clock - now, by_processor - processor_seconds()))

    @property
    def is_over(self) -> bool:
        """Whether the time is over."""
        return self.left == 0

    def check_time(self) -> None:
        """Raise `BudgetExceededError` if the time is over."""
        if self.is_over:
            raise BudgetExceededError(RAN_OUT["time"])

    def check_memory(self, needed: int) -> None:
        """Raise `BudgetExceededError` if tables of `needed` bytes would be too large."""
        if self.memory_bytes is not None and needed > self.memory_bytes:
            more = f"more than {self.memory_bytes / 2**20:.0f} MiB needed"
            raise BudgetExceededError(f"{RAN_OUT['memory']}: {more}")

    def stage(self, name: str) -> None:
        """Report the current stage, such as ``bounds of places``."""
        if self.stages is not None:
            self.stages(name)

    def report(self, progress: Progress) -> None:
        """Report progress; raise `BudgetExceededError` if the time is over or there are too many states."""
        if self.progress is not None:
            self.progress(progress)
        is_of_states = progress.unit in ("markings", "states")
        if self.states is not None and is_of_states and progress.count > self.states:
            raise BudgetExceededError(f"states: more than {self.states}")
        self.check_time()


UNLIMITED = Budget()
"""No limits except those of the engines themselves."""


def processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _smaller(one: int | None, other: int | None) -> int | None:
    return min((number for number in (one, other) if number is not None), default=None)
