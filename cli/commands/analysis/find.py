"""``dineros find``: how is this reached (paper, Alg. 5)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dineros.cli.analysing import (
    HOLDS,
    UNKNOWN,
    VIOLATED,
    load_subject,
    question_engine_option,
    question_options,
    reading_formula,
    write_witness,
)
from dineros.cli.console import say_json
from dineros.cli.options import model_argument
from dineros.cli.presentation.answers import say_way
from dineros.cli.searching import search
from dineros.cli.supervising import search_command

if TYPE_CHECKING:
    from dineros.analysis.answers.outcome import Outcome
    from dineros.analysis.explicit import Order


@search_command(
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
    run, goal = search(), f"enabled({enabled})" if enabled is not None else str(marking)

    def say(answer: Outcome) -> int:
        answer = replace(answer, reason=run.reason(answer.reason))
        witness = witness_of(subject, answer.trace) if answer.trace is not None else None
        if output is not None and witness is not None:
            write_witness(witness, output, model, settings, goal, answer.status)
        if as_json:
            say_json(
                {
                    "model": str(model),
                    "goal": goal,
                    "status": answer.status,
                    "reason": answer.reason,
                    "states": answer.states,
                    "witness": witness.to_dict() if witness else None,
                }
            )
        else:
            say_way(answer, goal, witness, model, output)
        return {"reachable": HOLDS, "unreachable": VIOLATED, "unknown": UNKNOWN}[answer.status]

    run.draft(lambda ending: say(run.unknown(ending)))
    subject = load_subject(model, settings, signals, overflow)
    question: Question
    if enabled is not None:
        question = Enabled(subject.net, subject.names, enabled, order)
    else:
        question = Marking(subject.net, subject.names, goal, order)
    with reading_formula("--marking" if enabled is None else "--enabled"):
        answer = ENGINES[engine].answer(question, run.budget())
    with run.answer():
        return say(answer)
