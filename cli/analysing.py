"""Common parts of the commands that analyse: options, the analysed net, witnesses and exit statuses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.console import say
from dineros.cli.models import errors_of, load_named, refuse_invalid, rules_of, say_rules
from dineros.cli.options import (
    Adds,
    choice_option,
    flag,
    json_option,
    model_path_option,
    output_option,
    settings_option,
    together,
    value_option,
    variant_options,
)
from dineros.cli.searching import search

if TYPE_CHECKING:
    from dineros.analysis.model.subject import Subject
    from dineros.analysis.symbolic.order_cache import OrderCache
    from dineros.analysis.witnesses.first_cause import Cause
    from dineros.analysis.witnesses.witness import Step, Witness
    from dineros.metamodel import pn

HOLDS, VIOLATED, UNKNOWN = 0, 1, 3
STATUSES = {
    **dict.fromkeys(("holds", "conforms", "reachable"), HOLDS),
    **dict.fromkeys(("violated", "unreachable"), VIOLATED),
    "unknown": UNKNOWN,
}
"""Exit status of each answer."""

engine_option: Adds = choice_option(
    "--engine", ("auto", "tina"), "The engines of DiNeROS, or TINA if it is on the PATH."
)
"""The options that select who answers a question."""

certificate_option: Adds = model_path_option(
    "--certificate FILE",
    "Write the proof of an answer (.json), for 'dineros certify': by structure, induction, or times.",
)

confirm_option: Adds = flag(
    "--confirm", "Decide answers about all markings again, by another engine or another order of levels."
)

scheduler_option: Adds = value_option(
    "--scheduler ADDRESS", "Use the workers of this Dask scheduler, such as tcp://10.0.0.1:8786."
)

cache_option: Adds = flag(
    "--no-cache",
    "Do not read or write orders of decision diagrams in .dineros/ in the model's folder; with "
    "--source, read all code again.",
)

trace_option = output_option("Write the trace to this file (JSON Lines).", metavar="TRACE")

question_options = together(
    engine_option,
    certificate_option,
    confirm_option,
    scheduler_option,
    trace_option,
    variant_options,
    settings_option,
    json_option,
)
"""Options of commands that decide one question about a net and show a witness."""


def search_order_option(help: str) -> Adds:
    """Add `--search`, passed as `order`: the order of the explicit search."""
    return choice_option("--search", ("breadth-first", "depth-first"), help, into="order")


def orders_beside(model: Path, no_cache: bool) -> OrderCache | None:
    """Return the orders of levels that are stored next to a model."""
    if no_cache:
        return None
    from dineros.analysis.symbolic.order_cache import OrderCache

    return OrderCache(model)


def load_subject(path: Path, settings: Sequence[str], signals: str, overflow: str) -> Subject:
    """Read a model, reject an invalid one, flatten it if it is a system model, and compile it."""
    from dineros.analysis.model.subject import subject_of

    model = load_valid(path, settings)
    search().stage("flattening")
    with errors_of(path):
        return subject_of(model, signals, overflow)  # type: ignore[arg-type]


def variant_fields(subject: Subject, model: Path, signals: str, overflow: str) -> dict[str, object]:
    """Return for JSON a model, the variants by which it was flattened, if it was, and its rules."""
    flattened = subject.flattened is not None
    return {
        "model": str(model),
        "signals": signals if flattened else None,
        "overflow": overflow if flattened else None,
        **rules_of(subject.model),
    }


def load_valid(path: Path, settings: Sequence[str]) -> pn.Net:
    """Read a model, change it, and reject it if it is invalid."""
    search().stage("reading the model")
    model = load_named(path, settings)
    refuse_invalid(model, path)
    say_rules(model, path)
    return model


@contextmanager
def reading_formula(option: str) -> Iterator[None]:
    """Add the option to errors of a formula or of a name.

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
    """Print a witness, a line per firing; repetitions are printed once."""
    loop = len(witness.steps) if witness.loop is None else witness.loop
    _say_steps(witness.steps[:loop], 0)
    if witness.loop is not None:
        say("  forever:")
        _say_steps(witness.steps[loop:], loop)
    say_disorder(witness)


def say_disorder(witness: Witness) -> None:
    """Print that a run needs messages out of order, if it does, because it may then be impossible."""
    if witness.disorder:
        say(f"  note: {witness.disorder} hands a newer message over before an older one,")
        say("        so this run may be impossible")


def _say_steps(steps: Sequence[Step], before: int) -> None:
    """Print firings that follow a number of others."""
    from dineros.analysis.witnesses.step_rounds import step_rounds

    texts, times = [step.text for step in steps], [step.time for step in steps]
    for found in step_rounds(texts, times, before):
        if found.times > 1:
            say(f"  {found.heading}")
        for number, line in enumerate(found.steps, found.first):
            say(f"  {number:3}  {line}")


def write_witness(
    witness: Witness,
    output: Path,
    model: Path,
    settings: Sequence[str],
    asked: str,
    verdict: str,
    cause: Cause | None = None,
) -> None:
    """Write a witness as a trace (`docs/records.md`), atomically."""
    from dineros.analysis.witnesses.records import witness_records
    from dineros.metamodel.records import write_records

    records = witness_records(
        witness, source=str(model), settings=settings, asked=asked, verdict=verdict, cause=cause
    )
    write_records(output, records)
