"""Evidence on the command line: the options that ask for it, and what is said of it."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from dineros.cli.console import note, summarise, warn
from dineros.cli.options import ModelPath
from dineros.metamodel.errors import counted

if TYPE_CHECKING:
    from dineros.analysis.answers.budget import Budget
    from dineros.analysis.answers.outcome import Outcome
    from dineros.analysis.evidence.confirmation import Confirmation
    from dineros.analysis.evidence.proving import Asked
    from dineros.analysis.questions.engines import Question
    from dineros.analysis.witnesses.findings import Report

F = TypeVar("F", bound=Callable[..., Any])

SHARE = 0.3
"""Part of the time in which a certificate is looked for before any engine is asked."""

SECONDS = 30.0
"""The same where no time is given."""


def certificate_option(function: F) -> F:
    """Add `--certificate`, a file to write, passed as `certificate`."""
    help = "Write what an answer by structure or induction rests on (.json), for 'dineros certify'."
    return click.option("--certificate", type=ModelPath(), metavar="FILE", help=help)(function)


def confirm_option(function: F) -> F:
    """Add `--confirm`: have an answer that rests on all markings decided again."""
    help = "Have another engine, or another order, decide again what rests on all markings."
    return click.option("--confirm", is_flag=True, help=help)(function)


def certified(asked: Asked, output: Path, budget: Budget) -> Outcome | None:
    """Answer a question by structure or induction and write the certificate; None where that does not do."""
    from dineros.analysis.answers.budget import Budget
    from dineros.analysis.answers.outcome import Outcome
    from dineros.analysis.evidence.proving import certify
    from dineros.cli.outputs import refuse_output
    from dineros.metamodel.files.atomic import write_atomically

    refuse_output(output, [".json"])
    began = time.perf_counter()
    found = certify(asked, Budget(seconds=SECONDS if budget.seconds is None else SHARE * budget.seconds))
    if found is None:
        return None
    write_atomically(output, json.dumps(found, indent=1, ensure_ascii=False).encode() + b"\n")
    return Outcome(
        str(found["answer"]), seconds=time.perf_counter() - began, reason=f"by {facts_text(found['facts'])}"
    )


def say_certificate(output: Path, answer: Outcome, is_written: bool, as_json: bool) -> None:
    """Say that a certificate was written, or why there is none."""
    if is_written and not as_json:
        summarise(f"certificate: {output}")
    elif not is_written:
        shown = "a run" if answer.stem or answer.loop else "all markings"
        if answer.evidence is not None:
            shown = f"{answer.by}, with more facts or steps than were tried for it"
        reason = "nothing is answered" if answer.status == "unknown" else f"the answer rests on {shown}"
        warn(f"{output} is not written: {reason}")


def facts_text(facts: Sequence[Mapping[str, Any]]) -> str:
    """Return what a certificate holds, in words."""
    weights, traps = (sum(kind in fact for fact in facts) for kind in ("weights", "trap"))
    inductive = [fact for fact in facts if "clauses" in fact]
    parts = [counted(weights, "weighting") + " of places"] if weights else []
    parts += [counted(traps, "marked trap")] if traps else []
    parts += [
        counted(len(fact["clauses"]), "clause")
        + (f" by induction over {counted(fact['steps'], 'step')}" if fact["steps"] > 1 else " by induction")
        for fact in inductive
    ]
    return ", ".join(parts) or "the formula alone"


def confirmed(question: Question, answer: Outcome, budget: Budget) -> tuple[Outcome, Confirmation | None]:
    """Have others decide an answer that rests on all markings; unknown where they disagree."""
    from dataclasses import replace

    from dineros.analysis.evidence.confirmation import confirm_answer, rests_on_markings

    if not rests_on_markings(answer):
        return answer, None
    confirmation = confirm_answer(question, answer, budget)
    if confirmation.agrees is False:
        answer = replace(answer, status="unknown", reason=str(confirmation))
    return answer, confirmation


def confirmed_report(report: Report, budget: Budget) -> Confirmation | None:
    """Have others count the markings that a check rests on, and put into the report what they say."""
    from dineros.analysis.answers.outcome import Outcome
    from dineros.analysis.evidence.confirmation import confirm_space

    if report.space is None:
        return None
    confirmation = confirm_space(report.space, budget)
    if confirmation.agrees:
        report.proved.append(f"all markings are as {' and '.join(confirmation.by)} found them")
    else:
        question = "what rests on all markings" if confirmation.agrees is False else "whether others agree"
        is_fault = confirmation.agrees is False
        report.unknown.append(Outcome.left_open(question, str(confirmation), may_be_fault=is_fault))
    return confirmation


def say_confirmation(confirmation: Confirmation | None, as_json: bool = False) -> None:
    """Say who confirmed an answer, on standard error where nobody did or JSON is printed."""
    if confirmation is None:
        note("nothing to confirm: the answer does not rest on all markings")
    elif confirmation.agrees is False:
        warn(f"ERROR: {confirmation} (one of them is wrong: please report it, with the model)")
    elif confirmation.agrees is None:
        warn(str(confirmation))
    elif not as_json:
        summarise(str(confirmation))
