"""``dineros find``: how is this reached (paper, Alg. 5)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from dineros.cli.analysing import (
    HOLDS,
    UNKNOWN,
    VIOLATED,
    budget_of,
    exploring,
    load_subject,
    question_engine_option,
    question_options,
    reading_formula,
    write_witness,
)
from dineros.cli.console import say_json
from dineros.cli.models import rules_of
from dineros.cli.options import command, model_argument
from dineros.cli.presentation.answers import say_way

if TYPE_CHECKING:
    from dineros.analysis.explicit import Order


@command(
    "dineros find sorting.sym.xmi --enabled TShowResult",
    "dineros find sorting.sym.xmi --signals none --marking 'Shown >= 1 & StateGet >= 1'",
)
@model_argument()
@click.option("--enabled", metavar="TRANSITION", help="Find a marking that enables a transition.")
@click.option("--marking", metavar="EXPR", help="Find a marking with a property, such as 'Shown >= 2'.")
@click.option(
    "--search",
    "order",
    type=click.Choice(["breadth-first", "depth-first"]),
    default="breadth-first",
    show_default=True,
    help="Breadth first finds a shortest way, depth first often a long one sooner.",
)
@question_engine_option
@click.option(
    "--timeout",
    type=click.FloatRange(min=0, min_open=True),
    metavar="SECONDS",
    help="Give up after so long.",
)
@question_options
def find(
    model: Path,
    enabled: str | None,
    marking: str | None,
    order: Order,
    engine: str,
    timeout: float | None,
    output: Path | None,
    signals: str,
    overflow: str,
    memory: int | None,
    settings: tuple[str, ...],
    as_json: bool,
) -> int:
    """Find a way to a marking: a shortest one, unless the search goes depth first or on a reduced net.

    With --engine tina the way is one that TINA's programs sift and pathto tell, replayed; it may be longer.
    Exit status 0: found; 1: proved unreachable; 3: unknown.
    """
    from dineros.analysis.questions.engines import ENGINES, Enabled, Marking, Question
    from dineros.analysis.witnesses.findings import witness_of

    if (enabled is None) == (marking is None):
        raise click.UsageError("give either --enabled or --marking")
    subject = load_subject(model, settings, signals, overflow)
    question: Question
    if enabled is not None:
        question = Enabled(subject.net, subject.names, enabled, order)
    else:
        assert marking is not None
        question = Marking(subject.net, subject.names, marking, order)
    with exploring() as progress, reading_formula("--marking" if enabled is None else "--enabled"):
        answer = ENGINES[engine].answer(question, budget_of(memory, timeout, progress))
    witness = witness_of(subject, answer.trace) if answer.trace is not None else None
    report = {
        "model": str(model),
        **rules_of(subject.model),
        "goal": f"enabled({enabled})" if enabled is not None else marking,
        "status": answer.status,
        "reason": answer.reason,
        "states": answer.states,
        "witness": witness.to_dict() if witness else None,
    }
    if output is not None and witness is not None:
        write_witness(witness, output, model, settings, str(report["goal"]), answer.status)
    if as_json:
        say_json(report)
    else:
        say_way(answer, str(report["goal"]), witness, model, output)
    return {"reachable": HOLDS, "unreachable": VIOLATED, "unknown": UNKNOWN}[answer.status]
