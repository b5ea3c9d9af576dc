"""Runs a search in a child process; the parent enforces `--timeout` and `--memory`.

It watches the clock, the memory of all processes together and Ctrl-C; if the search does not end in time,
it stops the search and prints the answers found until then.
"""

from __future__ import annotations

import os
import re
import signal
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from functools import partial
from types import FrameType
from typing import Any

import click

from dineros.analysis.answers.apart import Apart, ApartDiedError, Tell, is_end
from dineros.analysis.answers.processes import PROCESSES, running_seconds
from dineros.analysis.nets.memory import (
    MemoryBudgetError,
    memory_of_process,
    resident_memory,
    watched_memory,
)
from dineros.cli.failures import UNKNOWN, failed
from dineros.cli.options import ExampleCommand, command, invocation
from dineros.cli.searching import INTERRUPTED, MEMORY, TIME, WHY, Limits, Pieces, Search, Whereabouts, use
from dineros.metamodel.errors import BudgetError, printable

LOOK_SECONDS = 0.02, 0.1
"""Least and most seconds between two checks of the memory; the more of it is free, the fewer."""
FASTEST = 4 << 30
"""Bytes that one processor allocates in a second at most."""
SHOWN_SECONDS, SAID_SECONDS = 0.5, 10.0
"""Seconds between two progress reports: on a terminal, and otherwise with `-v`."""
SAY_SECONDS = "DINEROS_SAY_SECONDS"
"""Environment variable: progress interval in seconds when standard error is not a terminal."""
ASKED, ENDED = (1.01, 0.05), (1.04, 0.1)
"""When a search is asked to end that continues, and when it is ended: times what it may take, plus seconds.

A search is promised to end within ten per cent more than its time, and half a second at least; what is left
then is for printing what was answered.
"""
PATIENCE = 1.0
"""Seconds that an interrupted search has to end."""
MARGIN = 0.02
"""Share of the memory that is reserved for allocations between two checks."""


_LIMITS = "dineros.limits"

_UNITS = {"k": 1 << 10, "m": 1 << 20, "g": 1 << 30}


class Memory(click.ParamType[int]):
    """An amount of memory: bytes, or a number with K, M or G."""

    name = "memory"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Return bytes."""
        if isinstance(value, int):
            return value
        text = str(value).strip().lower().removesuffix("ib").removesuffix("b")
        factor = _UNITS.get(text[-1:], 1)
        try:
            amount = int(float(text[:-1] if factor > 1 else text) * factor)
        except (ValueError, OverflowError):
            self.fail(f"{value!r} is not an amount of memory, such as 4G", param, ctx)
        from dineros.analysis.nets.memory import LEAST_FOR_SEARCH, OWN_MEMORY

        if amount < OWN_MEMORY + LEAST_FOR_SEARCH:
            least = f"give {(OWN_MEMORY + LEAST_FOR_SEARCH) >> 20}M or more"
            need = f"the program itself needs {OWN_MEMORY >> 20} MiB"
            self.fail(f"{value!r} is too little, as {need}: {least}", param, ctx)
        return amount


class SearchCommand(ExampleCommand):
    """A command that searches: it has `--timeout` and `--memory`, and obeys them."""

    timeout_help = "End after this time, with the answers so far."
    reports_interrupts = True

    def own_options(self) -> list[click.Option]:
        """Return `--timeout`, in seconds, `--memory`, in bytes, and the standard ones."""
        timeout = click.Option(
            ["--timeout"],
            type=click.FloatRange(min=0, min_open=True),
            metavar="SECONDS",
            help=self.timeout_help,
        )
        memory = click.Option(
            ["--memory"],
            type=Memory(),
            metavar="SIZE",
            help="Memory limit for all processes, such as 4G; default: 70 % of the free memory.",
        )
        return [timeout, memory, *super().own_options()]

    def invoke(self, ctx: click.Context) -> int:
        """Run it, in a child process if this one is its own; if it ends early, print the answers found."""
        is_alone = invocation().is_alone
        began = time.monotonic() - (running_seconds() if is_alone else 0.0)
        limits = Limits(began, ctx.params.pop("timeout"), ctx.params.pop("memory"))
        if self.serves(ctx.params):
            ctx.meta[_LIMITS] = limits
            return int(ExampleCommand.invoke(self, ctx) or 0)

        def work(search: Search) -> int:
            use(search)
            try:
                with search:
                    return int(ExampleCommand.invoke(self, ctx) or 0)
            except BudgetError as error:
                status = search.end(error.message)
                if status is None:
                    raise
                return status

        try:
            return Watch(limits).run(work) if is_alone else _here(limits, work)
        except _InterruptedError as interrupted:
            if not self.reports_interrupts:
                raise KeyboardInterrupt from None
            click.echo(f"dineros: {interrupted}", err=True)
            return UNKNOWN

    def serves(self, params: Mapping[str, Any]) -> bool:
        """Return whether the command runs until it is stopped: then its limits apply only to reading."""
        return False


class ReadingCommand(SearchCommand):
    """A command that reads files: at a limit, it ends and writes nothing."""

    timeout_help = "End after this time."
    reports_interrupts = False


class ServingCommand(ReadingCommand):
    """A command that may serve a page; then it reads its files `within_limits`."""

    timeout_help = "End after this time. If a page is served, this limits only the reading of files."

    def serves(self, params: Mapping[str, Any]) -> bool:
        """Return whether no file is written, so that a page is shown."""
        return params.get("output") is None and params.get("follow", True)


@contextmanager
def within_limits() -> Iterator[None]:
    """Keep the reading of a command that serves a page within its limits, in this process.

    Raises
    ------
    BudgetError
        Time or memory ran out.
    """
    limits: Limits | None = click.get_current_context().meta.get(_LIMITS)
    if limits is None:  # another process watches over this one
        yield
        return
    with watched_memory(memory_of_process(limits.memory), limits.left):
        yield


search_command = partial(command, cls=SearchCommand)
"""Registers a function as the searching subcommand of its name; see `dineros.cli.options.command`."""

reading_command = partial(command, cls=ReadingCommand)
"""Registers a function as the reading subcommand of its name."""

serving_command = partial(command, cls=ServingCommand)
"""Registers a function as the reading subcommand of its name that may serve a page."""


def _here(limits: Limits, work: Callable[[Search], int]) -> int:
    """Runs the search in this process (when embedded); the time limit is checked between stages only."""
    search = Search(limits)
    try:
        with watched_memory(memory_of_process(limits.memory)):
            return work(search)
    except KeyboardInterrupt:
        if search.end(INTERRUPTED) is None:
            raise _InterruptedError(search.at.ending(INTERRUPTED, limits)) from None
        return UNKNOWN


class _InterruptedError(Exception):
    """A command was interrupted, and has nothing to print but where it was."""


class Watch:
    """Watches a search."""

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.memory = memory_of_process(limits.memory)
        self.at = Whereabouts()
        self.cause = ""
        self._draft: tuple[Pieces, int] | None = None
        self._signals = 0
        self._end_at: float | None = None
        self._ask_at: float | None = None
        if limits.seconds is not None:
            self._ask_at, self._end_at = (limits.seconds * factor + more for factor, more in (ASKED, ENDED))
        self._looked, self._wait = 0.0, LOOK_SECONDS[0]
        self._is_terminal = sys.stderr.isatty()
        self._is_shown = invocation().verbosity >= (0 if self._is_terminal else 1)
        asked = os.environ.get(SAY_SECONDS, "")
        self._pause = float(asked) if _SECONDS.fullmatch(asked) else SAID_SECONDS
        self._shown = 0.0
        self._has_line = False

    def run(self, work: Callable[[Search], int]) -> int:
        """Run a search in a child process, and print its output; return the exit status."""
        debug = invocation().debug

        def apart(tell: Tell) -> int:
            invocation().is_watched = True
            search = Search(self.limits, tell)
            with search.relay.on(), nullcontext() if PROCESSES.is_dir() else watched_memory(self.memory):
                try:
                    return work(search)
                except click.exceptions.Exit as finished:
                    return finished.exit_code
                except (Exception, KeyboardInterrupt) as error:
                    if isinstance(error, Exception) and not is_end(error):
                        return failed(error, debug)
                    search.refresh(is_last=True)
                    raise KeyboardInterrupt from None

        with Apart(apart) as process, self._counting_signals():
            while not process.is_over:
                for kind, value in process.messages(self._wait):
                    self._take(kind, value)
                    self._look(process)
                self._look(process)
                self.show()
            self._clear()
            return self._status(process)

    def _status(self, process: Apart) -> int:
        try:
            status = int(process.value())
        except KeyboardInterrupt:
            return self._print_draft(self.cause or INTERRUPTED)
        except ApartDiedError as died:
            if self.cause or died.signal == signal.SIGKILL:
                return self._print_draft(self.cause or f"{MEMORY}, the system says,")
            self._print_draft(str(died))
            raise
        return UNKNOWN if self.cause == INTERRUPTED else status

    def _print_draft(self, cause: str) -> int:
        """Print the answers found, for a search that has ended without its answer."""
        ending = self.at.ending(cause, self.limits)
        if self._draft is None:
            if cause == INTERRUPTED:
                raise _InterruptedError(ending)
            error = MemoryBudgetError(self.memory)
            more = f"; {error.limit} ({error.hint})" if cause == MEMORY else ""
            self._print([(True, f"dineros: {ending}{more}\n")])
            return UNKNOWN
        pieces, status = self._draft
        self._print([(is_error, text.replace(WHY, ending)) for is_error, text in pieces])
        return UNKNOWN if cause == INTERRUPTED else status

    def _take(self, kind: str, value: Any) -> None:
        match kind:
            case "stage":
                self.at = Whereabouts(value)
            case "progress":
                self.at.progress = value
            case "draft":
                self._draft = value
            case "printed":
                self._print(value)
            case "answer":
                self._draft = None
                self._print(value)

    # what was promised

    def _look(self, process: Apart) -> None:
        """Stop the search, or request its end, if it would exceed its limits."""
        now = self.limits.spent
        if now - self._looked >= self._wait:
            self._looked = now
            most = int(self.memory * (1 - MARGIN)) - resident_memory()
            free = most - process.tree.memory(most)
            if free < 0:
                self._end(process, MEMORY)
            least, longest = LOOK_SECONDS
            self._wait = min(max(free / (FASTEST * (os.cpu_count() or 1)), least), longest)
        if self._signals and self.cause != INTERRUPTED:
            self.cause = INTERRUPTED
            self._ask_at, self._end_at = now, now + PATIENCE
        if self._end_at is not None and (now >= self._end_at or self._signals > 1):
            self._end(process, self.cause or TIME)
        elif self._ask_at is not None and now >= self._ask_at:
            self._ask_at, self.cause = None, self.cause or TIME
            process.ask_to_end()

    def _end(self, process: Apart, cause: str) -> None:
        self.cause, self._ask_at, self._end_at = cause, None, None
        process.end()

    @contextmanager
    def _counting_signals(self) -> Iterator[None]:
        """Count Ctrl-C and SIGTERM, which `timeout` and the like send; a shell may have them ignored."""

        def count(_: int, __: FrameType | None) -> None:
            self._signals += 1

        before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
        for number, handler in before.items():
            if handler is not signal.SIG_IGN:
                signal.signal(number, count)
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    # what is seen of it

    def show(self) -> None:
        """Show the stage of the search: on terminals repeatedly in one line, else in occasional lines."""
        now = self.limits.spent
        if not self._is_shown or now - self._shown < (SHOWN_SECONDS if self._is_terminal else self._pause):
            return
        self._shown = now if self._is_terminal else now - now % self._pause
        if self._is_terminal:
            sys.stderr.write(f"{_CLEAR}{printable(str(self.at))}")
            self._has_line = True
        else:
            sys.stderr.write(f"{now:.0f} s: {printable(str(self.at))}\n")
        sys.stderr.flush()

    def _clear(self) -> None:
        if self._has_line:
            self._has_line = False
            sys.stderr.write(_CLEAR)
            sys.stderr.flush()

    def _print(self, pieces: Pieces) -> None:
        self._clear()
        for is_error, text in pieces:
            stream = sys.stderr if is_error else sys.stdout
            stream.write(text)
            stream.flush()


_SECONDS = re.compile(r"[1-9][0-9]?|0\.[1-9]")
_CLEAR = "\r\033[K"
