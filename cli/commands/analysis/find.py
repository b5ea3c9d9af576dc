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
from dineros.cli.asking import Backing, answered
from dineros.cli.console import say_json
from dineros.cli.models import rules_of
from dineros.cli.options import model_argument
from dineros.cli.presentation.answers import say_way
from dineros.cli.presentation.evidence import certificate_option, confirm_option
from dineros.cli.presentation.scheduling import scheduler_option
from dineros.cli.quick_start import start_quickly
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
@certificate_option
@confirm_option
@scheduler_option
@question_options
def find(
    model: Path,
    enabled: str | None,
    marking: str | None,
    order: Order,
    engine: str,
    timeout: float | None,
    certificate: Path | None,
    confirm: bool,
    scheduler: str | None,
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
    start_quickly()
    from dineros.analysis.evidence.proving import Asked
    from dineros.analysis.questions.engines import Enabled, Marking, Question
    from dineros.analysis.witnesses.findings import witness_of

    if (enabled is None) == (marking is None):
        raise click.UsageError("give either --enabled or --marking")
    if scheduler is not None and engine == "tina":
        raise click.UsageError("workers of a scheduler do not ask TINA")
    run, goal = search(), f"enabled({enabled})" if enabled is not None else str(marking)
    backing, rules = Backing(certificate, confirm), dict[str, object]()

    def say(answer: Outcome) -> int:
        answer = replace(answer, reason=run.reason(answer.reason))
        witness = witness_of(subject, answer.trace) if answer.trace is not None else None
        if output is not None and witness is not None:
            write_witness(witness, output, model, settings, goal, answer.status)
        if as_json:
            say_json(
                {
                    "model": str(model),
                    **rules,
                    "goal": goal,
                    "status": answer.status,
                    "reason": answer.reason,
                    "by": answer.by,
                    "states": answer.states,
                    "witness": witness.to_dict() if witness else None,
                    **backing.to_dict(),
                }
            )
        else:
            say_way(answer, goal, witness, model, output)
        backing.say(answer, as_json)
        return {"reachable": HOLDS, "unreachable": VIOLATED, "unknown": UNKNOWN}[answer.status]

    run.draft(lambda ending: say(run.unknown(ending)))
    subject = load_subject(model, settings, signals, overflow)
    rules.update(rules_of(subject.model))
    question: Question
    if enabled is not None:
        question = Enabled(subject.net, subject.names, enabled, order)
    else:
        question = Marking(subject.net, subject.names, goal, order)
    with reading_formula("--marking" if enabled is None else "--enabled"):
        kind, text = ("enabled", enabled) if enabled is not None else ("marking", goal)
        asked = Asked(subject, kind, text, signals, overflow, settings)
        answer = answered(asked, question, run, backing, engine, scheduler, order=order)
    with run.answer():
        return say(answer)
