"""Reports of a command during its search: stage, progress, and the output if it has to stop now."""

from __future__ import annotations

import io
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self, TextIO

import click

from dineros.analysis.answers.budget import RAN_OUT
from dineros.cli.console import SEARCH, warn
from dineros.cli.options import invocation

if TYPE_CHECKING:
    from dineros.analysis.answers.budget import Budget, Progress
    from dineros.analysis.answers.outcome import Outcome

QUIET_COMPILATION = "DINEROS_QUIET_COMPILATION"
"""Environment variable that suppresses the line about the compilation of engines."""

TIME, MEMORY, INTERRUPTED = RAN_OUT["time"], RAN_OUT["memory"], "interrupted"
"""Reasons of an early end of a search, for reports."""

TELL_SECONDS = 0.2
"""Seconds between two progress messages of an engine."""
RENDERING = 0.02
"""Share of the time for preparing the output of an early end."""

FOLLOW_SECONDS = 5.0
"""Seconds after which answers are printed as they come."""
FOLLOW_AFTER = "DINEROS_FOLLOW_SECONDS"
"""Environment variable that changes this time, for programs that compare outputs."""

_NO_STAGE = "the beginning"

Pieces = list[tuple[bool, str]]
"""The output in order: whether it is on standard error, and the text."""


@dataclass(frozen=True)
class Limits:
    """The limits of a search: seconds, and bytes of all processes; and its start (`time.monotonic`)."""

    began: float
    seconds: float | None
    memory: int | None

    @property
    def spent(self) -> float:
        """Seconds since the beginning."""
        return time.monotonic() - self.began

    @property
    def left(self) -> float | None:
        """Seconds that are left; None without a limit."""
        return None if self.seconds is None else max(0.0, self.seconds - self.spent)


@dataclass
class Whereabouts:
    """The position of a search: its stage and the progress there."""

    stage: str = _NO_STAGE
    progress: str = ""

    def __str__(self) -> str:
        return f"{self.stage}{f' ({self.progress})' if self.progress else ''}"

    def ending(self, cause: str, limits: Limits) -> str:
        """Return why a search has ended, when and where."""
        return f"{cause} after {limits.spent:.1f} s, at {self}"


class Search:
    """The search of a command, in the searching process.

    `tell`: sends messages, pairs of a kind and a value, to the watching process. Without it, no process
    watches, and output is printed immediately.
    """

    def __init__(self, limits: Limits, tell: Callable[[tuple[str, Any]], None] | None = None) -> None:
        self.limits, self.at = limits, Whereabouts()
        self._tell = tell
        self.last: Progress | None = None
        self._render: Callable[[str], int] | None = None
        self._draft: tuple[Pieces, int] | None = None
        self._told = self._rendering = 0.0
        self._follow: Callable[[], None] | None = None
        self._follow_after = _seconds(os.environ.get(FOLLOW_AFTER, ""), FOLLOW_SECONDS)
        self._open = ExitStack()
        self.relay = Relay(lambda pieces: self._say("printed", pieces))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._open.close()

    # where it is

    def budget(self) -> Budget:
        """Return the budget of the engines; from now on, their compilation is announced.

        Raises
        ------
        MemoryBudgetError
            The model has used all of it.
        """
        from dineros.analysis.answers.budget import Budget
        from dineros.analysis.nets.memory import memory_for_engines

        self._open.enter_context(_announcing_compilation(self.stage, lambda: self.at.stage))
        memory = memory_for_engines(self.limits.memory)
        return Budget(memory, seconds=self.limits.left, progress=self.progress, stages=self.stage)

    def time(self) -> Budget:
        """Return the budget of work without tables of its own: time."""
        from dineros.analysis.answers.budget import Budget

        return Budget(seconds=self.limits.left, progress=self.progress, stages=self.stage)

    def stage(self, name: str) -> None:
        """Report the current stage."""
        self.at = Whereabouts(name)
        self._say("stage", name)
        self.refresh()

    def progress(self, progress: Progress) -> None:
        """Report the progress of an engine."""
        self.last = progress
        self.far(str(progress))

    def far(self, progress: str) -> None:
        """Report the progress of the stage in words, at a readable rate."""
        self.at.progress = progress
        now = time.monotonic()
        if now - self._told >= TELL_SECONDS:
            self._told = now
            self._say("progress", self.at.progress)
            self.refresh()

    def reason(self, why: str) -> str:
        """Return why an answer is unknown: for a limit, also when and where it was reached."""
        if why == INTERRUPTED and self.limits.left == 0.0:
            why = TIME  # who watches has asked an engine to end that looked too late
        return self.at.ending(why, self.limits) if why.startswith((TIME, MEMORY, INTERRUPTED)) else why

    def unknown(self, ending: str) -> Outcome:
        """Return the answer to a question that the search did not reach."""
        from dineros.analysis.answers.outcome import Outcome

        states = self.last.count if self.last is not None and self.last.unit != "nodes" else None
        return Outcome("unknown", states=states, seconds=self.limits.spent, reason=ending)

    # what is printed

    def draft(self, render: Callable[[str], int]) -> None:
        """Set the output for a search that ends without its answer.

        `render`: prints all answers found so far; gets the reason of the end, and returns the exit status.
        """
        self._render = render
        self.refresh()

    def follow(self, tell: Callable[[], None]) -> None:
        """Set the function that prints answers as they come, if the search takes longer than a few seconds.

        `tell`: prints new answers on standard error.
        """
        self._follow = tell

    @contextmanager
    def answer(self) -> Iterator[None]:
        """Treat the output of this block as the answer: it is printed as a whole, without a later draft."""
        with self.relay.held() as pieces:
            yield
        self._render = self._draft = self._follow = None
        self._say("answer", pieces)

    def refresh(self, *, is_last: bool = False) -> None:
        """Send the watching process the output for the case that the search ends here.

        `is_last`: whether it does; otherwise the message is skipped if it would take too much time.
        """
        if self._follow is not None and not is_last and self.limits.spent >= self._follow_after:
            self._follow()
        if self._tell is None or self._render is None:
            return
        if not is_last and self._rendering > RENDERING * self.limits.spent:
            return
        began, why = time.monotonic(), f"ending-{os.getpid()}-{time.monotonic_ns()}"
        with self.relay.held() as pieces:
            status = self._render(why)
        self._rendering += time.monotonic() - began
        told = [(is_error, text.replace(why, WHY)) for is_error, text in pieces]
        if (told, status) != self._draft:
            self._draft = told, status
            self._say("draft", self._draft)

    def end(self, cause: str) -> int | None:
        """Print the answers found so far, for a search that ends here; None if there are none."""
        if self._render is None:
            return None
        render, self._render = self._render, None
        return render(self.at.ending(cause, self.limits))

    def _say(self, kind: str, value: Any) -> None:
        if self._tell is not None:
            self._tell((kind, value))


def _seconds(text: str, default: float) -> float:
    """Return a number of seconds, whole and of up to four digits."""
    return float(text) if text.isdecimal() and len(text) <= 4 else default


WHY = "\N{OBJECT REPLACEMENT CHARACTER}"
"""Placeholder in a draft for the reason of the end, which only the watching process knows."""


class Relay:
    """Standard output and standard error of a watched search: the watching process prints."""

    def __init__(self, tell: Callable[[Pieces], None]) -> None:
        self._tell = tell
        self._held: Pieces | None = None
        self._is_on = False

    @contextmanager
    def on(self) -> Iterator[None]:
        """Collect all output."""
        self._is_on = True
        output, errors = _Stream(self, False, sys.stdout), _Stream(self, True, sys.stderr)
        with redirect_stdout(output), redirect_stderr(errors):
            yield

    @contextmanager
    def held(self) -> Iterator[Pieces]:
        """Collect the output, which is the value. Prints as usual if it is not active."""
        if not self._is_on:
            yield []
            return
        before, self._held = self._held, []
        try:
            yield self._held
        finally:
            self._held = before

    def print(self, is_error: bool, text: str) -> None:
        """Forward a text."""
        if self._held is not None:
            self._held.append((is_error, text))
        else:
            self._tell([(is_error, text)])


class _Stream(io.TextIOBase):
    """A stream that forwards its text."""

    encoding = "utf-8"

    def __init__(self, relay: Relay, is_error: bool, shown: TextIO) -> None:
        self._relay, self._is_error, self._shown = relay, is_error, shown

    def write(self, text: str) -> int:
        if not isinstance(text, str):  # click asks by such a try whether a stream takes bytes
            raise TypeError("takes text")
        if text:
            self._relay.print(self._is_error, text)
        return len(text)

    def isatty(self) -> bool:
        return self._shown.isatty()

    def fileno(self) -> int:
        return self._shown.fileno()

    def writable(self) -> bool:
        return True


def search() -> Search:
    """Return the search of the running command."""
    found: Search = click.get_current_context().meta[SEARCH]
    return found


def use(one: Search) -> None:
    """Set the search of the running command."""
    click.get_current_context().meta[SEARCH] = one


@contextmanager
def _announcing_compilation(tell: Callable[[str], None], now: Callable[[], str]) -> Iterator[None]:
    """Print once, unless `-q` is given, that kernels are compiled, when the first one is; it is a stage.

    Numba keeps them for later runs. Programs that compare outputs set `QUIET_COMPILATION`.
    """
    from numba.core import event

    is_quiet = invocation().verbosity < 0 or bool(os.environ.get(QUIET_COMPILATION))

    class Announcer(event.Listener):
        said, before = is_quiet, _NO_STAGE

        def on_start(self, _: event.Event) -> None:
            if now() != COMPILING:
                self.before = now()
                tell(COMPILING)
            if not self.said:
                warn("compiling the engines, once after an installation; this takes up to a minute")
            Announcer.said = True

        def on_end(self, _: event.Event) -> None:
            tell(self.before)

    with event.install_listener("numba:compile", Announcer()):
        yield


COMPILING = "compiling the engines"
