"""What a question may cost: one budget of time and memory, of which each stage gets a share."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Literal

DEFAULT_MEMORY = 2 << 30
"""Bytes that diagrams may take where nobody says how many."""


RAN_OUT = {"time": "time ran out", "memory": "memory ran out"}
"""Why an answer is not known, as reports say it, by what engines call it."""


@dataclass(frozen=True)
class Progress:
    """How far an engine is.

    Attributes
    ----------
    unit : {"markings", "states", "nodes", "steps"}
        What it counts; nodes are those of a decision diagram, steps those of a run.
    count : int
        How many it has.
    memory_bytes : int
        Bytes of its tables.
    rate : float or None
        How many it finds a second; None where that says nothing.
    """

    unit: Literal["markings", "states", "nodes", "steps"]
    count: int
    memory_bytes: int
    rate: float | None = None

    def __str__(self) -> str:
        rate = [f"{self.rate:,.0f}/s"] if self.rate else []
        return ", ".join([f"{self.count:,} {self.unit}", *rate, f"{self.memory_bytes / 2**20:,.0f} MiB"])


ProgressCallback = Callable[[Progress], None]
StageCallback = Callable[[str], None]


class BudgetExceededError(Exception):
    """A limit was hit; says which. Never leaves the analysis: answers become ``unknown``."""


@dataclass(frozen=True)
class Budget:
    """Limits of a question, and who is told how far its answer is; None: no limit.

    The clock runs once it has `begun`. Stages get shares of what is left then, and all of them end with the
    whole.

    Attributes
    ----------
    memory_bytes : int
        Bytes of an engine's own tables, copies made while they grow included.
    states : int
        States stored; those that a diagram stands for do not count.
    seconds : float
        Wall-clock time from the beginning on.
    progress : callable
        Called a few times a second; an exception raised in it ends the work, KeyboardInterrupt with an answer
        where the engine has one.
    stages : callable
        Told the name of each stage of the work as it begins; see `stage`.
    started, deadline : float or None
        Where `time.perf_counter` stood at the beginning, and where time is up.

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
    started: float | None = field(default=None, compare=False, repr=False)
    deadline: float | None = field(default=None, compare=False, repr=False)

    def begun(self) -> Budget:
        """Return the budget with its clock running; the same one if it runs already."""
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
        """Return the budget of a stage; its clock runs.

        Parameters
        ----------
        time, memory : float
            Parts of the time that is left, and of the memory.
        most_bytes, most_states : int, optional
            What it may have at most, however much there is.
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
        return replace(stage, started=None, seconds=left * time).begun()

    def at_most(self, seconds: float) -> Budget:
        """Return the budget of a stage that may take so many seconds, and no more than is left."""
        left = self.left
        if left is not None and left <= seconds:
            return self.begun()
        return replace(self, started=None, seconds=max(0.0, seconds)).begun()

    @property
    def memory(self) -> int:
        """Bytes that diagrams may take."""
        return DEFAULT_MEMORY if self.memory_bytes is None else self.memory_bytes

    @property
    def spent(self) -> float:
        """Seconds since the beginning."""
        return 0.0 if self.started is None else time.perf_counter() - self.started

    @property
    def left(self) -> float | None:
        """Seconds that are left; None without a limit."""
        if self.deadline is None:
            return self.seconds
        return max(0.0, self.deadline - time.perf_counter())

    @property
    def is_over(self) -> bool:
        """Whether time is up."""
        return self.left == 0

    def check_time(self) -> None:
        """Raise `BudgetExceededError` when time is up."""
        if self.is_over:
            raise BudgetExceededError(RAN_OUT["time"])

    def check_memory(self, needed: int) -> None:
        """Raise `BudgetExceededError` when tables of `needed` bytes would be too large."""
        if self.memory_bytes is not None and needed > self.memory_bytes:
            more = f"more than {self.memory_bytes / 2**20:.0f} MiB needed"
            raise BudgetExceededError(f"{RAN_OUT['memory']}: {more}")

    def stage(self, name: str) -> None:
        """Tell what is done now, such as ``bounds of places``."""
        if self.stages is not None:
            self.stages(name)

    def report(self, progress: Progress) -> None:
        """Tell how far an engine is; raise `BudgetExceededError` when time is up or states are too many."""
        if self.progress is not None:
            self.progress(progress)
        is_of_states = progress.unit in ("markings", "states")
        if self.states is not None and is_of_states and progress.count > self.states:
            raise BudgetExceededError(f"states: more than {self.states}")
        self.check_time()


UNLIMITED = Budget()
"""No limit but those that an engine has by itself."""


def _smaller(one: int | None, other: int | None) -> int | None:
    return min((number for number in (one, other) if number is not None), default=None)
