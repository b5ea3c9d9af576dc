"""What the commands that analyse share: the net to analyse, budgets, progress, answers and exit statuses."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from dineros.cli.console import say, warn
from dineros.cli.models import load, refuse_invalid, say_rules
from dineros.cli.options import (
    invocation,
    json_option,
    middleware_option,
    settings_option,
    trace_option,
)

if TYPE_CHECKING:
    from dineros.analysis.answers.budget import Budget, Progress, ProgressCallback
    from dineros.analysis.model.subject import Subject
    from dineros.analysis.witnesses.findings import Witness
    from dineros.analysis.witnesses.first_cause import Cause
    from dineros.metamodel import pn

F = TypeVar("F", bound=Callable[..., Any])

WATCHED_SHARE = 0.9
"""Part of the free memory that a process may take unless told otherwise, of which engines take less."""

HOLDS, VIOLATED, UNKNOWN = 0, 1, 3
SIGNALS = ("none", "fully-enabled", "input-enabled", "io-enabled")
OVERFLOW = ("weighted", "inhibitor")
QUIET_COMPILATION = "DINEROS_QUIET_COMPILATION"
"""Environment variable that keeps the line away which says that engines are compiled."""

_CLEAR = "\r\033[K"
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
            self.fail(f"{value!r} is no amount of memory, such as 4G", param, ctx)
        from dineros.analysis.nets.memory import LEAST_FOR_SEARCH, OWN_MEMORY

        if amount < OWN_MEMORY + LEAST_FOR_SEARCH:
            least = f"give {(OWN_MEMORY + LEAST_FOR_SEARCH) >> 20}M or more"
            need = f"the program itself needs {OWN_MEMORY >> 20} MiB"
            self.fail(f"{value!r} is too little, as {need}: {least}", param, ctx)
        return amount


def variant_options(function: F) -> F:
    """Add `--middleware`, `--signals` and `--overflow`: how a system model is flattened first."""
    for option in (
        click.option(
            "--overflow",
            type=click.Choice(OVERFLOW),
            default="weighted",
            show_default=True,
            help="How a full queue drops.",
        ),
        click.option(
            "--signals",
            type=click.Choice(SIGNALS),
            default="input-enabled",
            show_default=True,
            help="When a signal may change.",
        ),
        middleware_option,
    ):
        function = option(function)
    return function


def memory_option(function: F) -> F:
    """Add `--memory`, in bytes; by default 70 % of what is free. The process is kept within it."""
    option = click.option(
        "--memory",
        type=Memory(),
        metavar="SIZE",
        callback=_keep_within,
        help="Memory that the process may use, such as 4G; default: 70 % of what is free.",
    )
    return option(function)


def _keep_within(context: click.Context, _: click.Parameter, given: int | None) -> int | None:
    """Watch over the memory of the process until the command ends; also over what no engine counts."""
    from dineros.analysis.nets.memory import (
        OWN_ADDRESSES,
        free_memory,
        mappable_memory,
        resident_memory,
        watched_memory,
    )
    from dineros.metamodel.errors import BudgetError

    if not context.resilient_parsing:
        if mappable_memory() < OWN_ADDRESSES:
            raise BudgetError(
                f"the limits of this process leave {mappable_memory() >> 20} MiB to map, "
                f"and the program itself needs {OWN_ADDRESSES >> 20} MiB",
                hint="raise the limit, see 'ulimit -a'",
            )
        budget = given if given is not None else resident_memory() + int(free_memory() * WATCHED_SHARE)
        context.with_resource(watched_memory(budget))
    return given


def question_engine_option(function: F) -> F:
    """Add `--engine`: who answers a question."""
    option = click.option(
        "--engine",
        type=click.Choice(["auto", "tina"]),
        default="auto",
        show_default=True,
        help="The engines of DiNeROS, or TINA where it is on the PATH.",
    )
    return option(function)


def question_options(function: F) -> F:
    """Add the options of commands that ask one question about a net and show how it comes about."""
    for option in (json_option, settings_option, memory_option, variant_options, trace_option):
        function = option(function)
    return function


def budget_of(
    memory: int | None, seconds: float | None = None, progress: ProgressCallback | None = None
) -> Budget:
    """Return what a question may cost."""
    from dineros.analysis.answers.budget import Budget

    return Budget(memory_budget(memory), seconds=seconds, progress=progress)


def memory_budget(given: int | None) -> int:
    """Return the bytes an engine may use: of what is given, what the process itself does not need.

    Raises
    ------
    MemoryBudgetError
        The model has taken it all.
    """
    from dineros.analysis.nets.memory import (
        DEFAULT_SHARE,
        ENGINE_ADDRESSES,
        ENGINE_MEMORY,
        LEAST_FOR_SEARCH,
        OWN_MEMORY,
        MemoryBudgetError,
        free_memory,
        mappable_memory,
        resident_memory,
    )

    if given is None:
        budget, left = resident_memory() + free_memory(), int(free_memory() * DEFAULT_SHARE)
    else:
        budget, left = given, given - max(OWN_MEMORY, resident_memory() + ENGINE_MEMORY)
    left = min(left, mappable_memory() - ENGINE_ADDRESSES)
    if left < LEAST_FOR_SEARCH:
        raise MemoryBudgetError(budget)
    return left


def load_subject(path: Path, settings: Sequence[str], signals: str, overflow: str) -> Subject:
    """Read a model, refuse an invalid one, flatten it where it is a system model, and compile it."""
    from dineros.analysis.model.subject import subject_of
    from dineros.metamodel.errors import DinerosError, Location

    model = load_valid(path, settings)
    try:
        return subject_of(model, signals, overflow)  # type: ignore[arg-type]
    except DinerosError as error:
        error.location = error.location or Location(path)
        raise


def load_valid(path: Path, settings: Sequence[str]) -> pn.Net:
    """Read a model, change it, and refuse it where it is not valid."""
    model = load(path, settings)
    refuse_invalid(model, path)
    say_rules(model, path)
    return model


@contextmanager
def reading_formula(option: str) -> Iterator[None]:
    """Let errors of a formula, or of a name, say which option it was given to.

    Raises
    ------
    DinerosError
        The formula cannot be read, or names something unknown.
    """
    from dineros.analysis.logic.language.errors import FormulaError
    from dineros.metamodel.errors import DinerosError

    try:
        yield
    except FormulaError as error:
        where = f"{option}, column {error.column}" if error.column else option
        raise DinerosError(f"{where}: {error.message}", hint=error.hint) from None


@contextmanager
def exploring() -> Iterator[Callable[[Progress], None]]:
    """Show how far an engine is, on terminals only, and what was seen when it is interrupted.

    The value is the callback for the engine. A first run, which compiles the engines, says so.
    """
    shown = sys.stderr.isatty() and invocation().verbosity >= 0
    began = time.monotonic()
    last: list[Any] = [None, began]

    def tell(progress: Progress) -> None:
        last[0], now = progress, time.monotonic()
        if shown and now - last[1] >= 0.5:
            last[1] = now
            sys.stderr.write(f"\r\033[K{progress}")
            sys.stderr.flush()

    try:
        with _announcing_compilation():
            yield tell
    except KeyboardInterrupt:
        after = f"interrupted after {time.monotonic() - began:.1f} s"
        click.echo(f"{_CLEAR if shown else ''}{after}: {last[0] or 'nothing seen yet'}", err=True)
        raise
    finally:
        if shown:
            sys.stderr.write(_CLEAR)
            sys.stderr.flush()


@contextmanager
def _announcing_compilation() -> Iterator[None]:
    """Say once, unless `-q` is given, that kernels are compiled, as soon as the first one is.

    Numba keeps them for later runs. Who compares what is printed sets `QUIET_COMPILATION`.
    """
    if invocation().verbosity < 0 or os.environ.get(QUIET_COMPILATION):
        yield
        return
    from numba.core import event

    class Announcer(event.Listener):
        said = False

        def on_start(self, _: event.Event) -> None:
            if not self.said:
                warn("compiling the engines, once after an installation; this takes up to a minute")
            Announcer.said = True

        def on_end(self, _: event.Event) -> None:
            """Nothing to say."""

    with event.install_listener("numba:compile", Announcer()):
        yield


def say_witness(witness: Witness) -> None:
    """Print a witness, a line per firing."""
    for number, step in enumerate(witness.steps, 1):
        if witness.loop is not None and number - 1 == witness.loop:
            say("  for ever:")
        say(f"  {number:3}  {step.text}")


def write_witness(
    witness: Witness,
    output: Path,
    model: Path,
    settings: Sequence[str],
    asked: str,
    verdict: str,
    cause: Cause | None = None,
) -> None:
    """Write a witness as a trace (`docs/records.md`), as a whole or not at all."""
    from dineros.analysis.witnesses.records import witness_records
    from dineros.metamodel.records import write_records

    records = witness_records(
        witness, source=str(model), settings=settings, asked=asked, verdict=verdict, cause=cause
    )
    write_records(output, records)
