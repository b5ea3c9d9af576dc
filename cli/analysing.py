"""What the commands that analyse share: the net to analyse, budgets, progress, answers and exit statuses."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from dineros.cli.console import say
from dineros.cli.models import load_named, refuse_invalid, say_rules
from dineros.cli.options import json_option, middleware_option, settings_option, trace_option
from dineros.cli.searching import search

if TYPE_CHECKING:
    from dineros.analysis.model.subject import Subject
    from dineros.analysis.witnesses.findings import Witness
    from dineros.analysis.witnesses.first_cause import Cause
    from dineros.metamodel import pn

F = TypeVar("F", bound=Callable[..., Any])

HOLDS, VIOLATED, UNKNOWN = 0, 1, 3
SIGNALS = ("none", "fully-enabled", "input-enabled", "io-enabled")
OVERFLOW = ("weighted", "inhibitor")
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


def budget_options(function: F) -> F:
    """Add `--timeout`, in seconds, and `--memory`, in bytes: what `dineros.cli.supervising` keeps."""
    for option in (
        click.option(
            "--memory",
            type=Memory(),
            metavar="SIZE",
            help="Memory that all processes may use, such as 4G; default: 70 % of what is free.",
        ),
        click.option(
            "--timeout",
            type=click.FloatRange(min=0, min_open=True),
            metavar="SECONDS",
            help="End after so long, with what is answered until then.",
        ),
    ):
        function = option(function)
    return function


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
    for option in (json_option, settings_option, budget_options, variant_options, trace_option):
        function = option(function)
    return function


def load_subject(path: Path, settings: Sequence[str], signals: str, overflow: str) -> Subject:
    """Read a model, refuse an invalid one, flatten it where it is a system model, and compile it."""
    from dineros.analysis.model.subject import subject_of
    from dineros.metamodel.errors import DinerosError, Location

    model = load_valid(path, settings)
    search().stage("flattening")
    try:
        return subject_of(model, signals, overflow)  # type: ignore[arg-type]
    except DinerosError as error:
        error.location = error.location or Location(path)
        raise


def load_valid(path: Path, settings: Sequence[str]) -> pn.Net:
    """Read a model, change it, and refuse it where it is not valid."""
    search().stage("reading the model")
    model = load_named(path, settings)
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
