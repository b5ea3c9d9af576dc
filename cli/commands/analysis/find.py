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
from dineros.cli.options import command, model_argument
from dineros.cli.presentation.answers import say_way
from dineros.cli.presentation.evidence import (
    certificate_option,
    certified,
    confirm_option,
    confirmed,
    say_certificate,
    say_confirmation,
)
from dineros.cli.presentation.scheduling import answer_on_workers, scheduler_option
from dineros.cli.quick_start import start_quickly

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
    from dineros.analysis.questions.engines import ENGINES, Enabled, Marking, Question
    from dineros.analysis.witnesses.findings import witness_of

    if (enabled is None) == (marking is None):
        raise click.UsageError("give either --enabled or --marking")
    if scheduler is not None and engine == "tina":
        raise click.UsageError("workers of a scheduler do not ask TINA")
    subject = load_subject(model, settings, signals, overflow)
    question: Question
    if enabled is not None:
        question = Enabled(subject.net, subject.names, enabled, order)
    else:
        assert marking is not None
        question = Marking(subject.net, subject.names, marking, order)
    with exploring() as progress, reading_formula("--marking" if enabled is None else "--enabled"):
        budget, proved = budget_of(memory, timeout, progress).begun(), None
        kind, text = ("enabled", enabled) if enabled is not None else ("marking", str(marking))
        if certificate is not None:
            from dineros.analysis.evidence.proving import Asked

            asked = Asked(subject, kind, text, signals, overflow, settings)
            proved = certified(asked, certificate, budget)
        if proved is not None:
            answer = proved
        elif scheduler is not None:
            asked_of = {"kind": kind, "text": text, "signals": signals, "overflow": overflow, "order": order}
            answer = answer_on_workers(subject, scheduler, asked_of, memory, timeout)
        else:
            answer = ENGINES[engine].answer(question, budget)
        confirmation = None
        if confirm and proved is None:
            answer, confirmation = confirmed(question, answer, budget)
    witness = witness_of(subject, answer.trace) if answer.trace is not None else None
    report = {
        "model": str(model),
        "goal": f"enabled({enabled})" if enabled is not None else marking,
        "status": answer.status,
        "reason": answer.reason,
        "by": answer.by,
        "states": answer.states,
        "witness": witness.to_dict() if witness else None,
    }
    if certificate is not None:
        report["certificate"] = str(certificate) if proved else None
    if confirm:
        report["confirmation"] = confirmation.to_dict() if confirmation else None
    if output is not None and witness is not None:
        write_witness(witness, output, model, settings, str(report["goal"]), answer.status)
    if as_json:
        say_json(report)
    else:
        say_way(answer, str(report["goal"]), witness, model, output)
    if certificate is not None:
        say_certificate(certificate, answer, proved is not None, as_json)
    if confirm:
        say_confirmation(confirmation, as_json)
    return {"reachable": HOLDS, "unreachable": VIOLATED, "unknown": UNKNOWN}[answer.status]
