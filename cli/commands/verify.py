"""``dineros verify``: temporal logic."""

from __future__ import annotations

from pathlib import Path

import click

from dineros.cli.analysing import (
    HOLDS,
    UNKNOWN,
    VIOLATED,
    budget_of,
    count,
    exploring,
    load_subject,
    question_engine_option,
    question_options,
    reading_formula,
    say_witness,
    write_witness,
)
from dineros.cli.console import say, say_json, summarise, warn
from dineros.cli.options import command, model_argument
from dineros.cli.orders import cache_option, orders_beside
from dineros.cli.quick_start import start_quickly


@command(
    "dineros verify sorting.sym.xmi --signals none --ctl 'AG EF (Shown >= 3)'",
    "dineros verify sorting.sym.xmi --signals none --ltl 'G F fired(TSense)'",
)
@model_argument()
@click.option("--ltl", metavar="FORMULA", help="A formula that all runs must satisfy.")
@click.option("--ctl", metavar="FORMULA", help="A formula that the initial marking must satisfy.")
@click.option(
    "--fair", "weak", multiple=True, metavar="TRANSITION", help="Weakly fair; repeatable; with --ltl."
)
@click.option(
    "--strongly-fair",
    "strong",
    multiple=True,
    metavar="TRANSITION",
    help="Strongly fair; repeatable; with --ltl.",
)
@click.option(
    "--timeout",
    type=click.FloatRange(min=0, min_open=True),
    metavar="SECONDS",
    help="Give up after so long.",
)
@cache_option
@question_engine_option
@question_options
def verify(
    model: Path,
    ltl: str | None,
    ctl: str | None,
    weak: tuple[str, ...],
    strong: tuple[str, ...],
    timeout: float | None,
    engine: str,
    output: Path | None,
    signals: str,
    overflow: str,
    memory: int | None,
    no_cache: bool,
    settings: tuple[str, ...],
    as_json: bool,
) -> int:
    """Verify a formula of linear (LTL) or branching (CTL) temporal logic.

    Atoms are `Shown >= 2`, `A + 2*B < 3`, `enabled(T)`, `fired(T)`, `signal(S)` and `deadlock`. A run that
    ends in a deadlock stays there for ever. Exit status 0: holds; 1: violated; 3: unknown. An answer for
    which no run is found in time stands without one, and says so. With --engine tina, TINA's programs tina
    and selt answer for LTL; the run that selt shows is replayed.
    """
    start_quickly()
    orders = orders_beside(model, no_cache)
    from dineros.analysis.questions.engines import ENGINES, Branching, Linear, Question
    from dineros.analysis.witnesses.findings import witness_of
    from dineros.metamodel.errors import DinerosError

    if (ltl is None) == (ctl is None):
        raise click.UsageError("give either --ltl or --ctl")
    if ctl is not None and (weak or strong):
        raise click.UsageError("fairness goes with --ltl")
    if ctl is not None and engine == "tina":
        raise DinerosError(
            "--ctl cannot go with --engine tina: its program selt verifies LTL only",
            hint="leave out --engine, or say it in LTL",
        )
    subject = load_subject(model, settings, signals, overflow)
    for option, names in (("--fair", weak), ("--strongly-fair", strong)):
        with reading_formula(option):
            for name in names:
                subject.names.transitions(name)
    question: Question
    if ltl is not None:
        question = Linear(subject.net, subject.names, ltl, weak, strong)
    else:
        assert ctl is not None
        question = Branching(subject.net, subject.names, ctl, orders)
    with exploring() as progress, reading_formula("--ltl" if ctl is None else "--ctl"):
        verdict = ENGINES[engine].answer(question, budget_of(memory, timeout, progress))
    witness = None
    if verdict.stem or verdict.loop:
        loop = len(verdict.stem) if verdict.loop else None
        witness = witness_of(subject, [*verdict.stem, *verdict.loop], loop)
    report = {
        "model": str(model),
        "formula": ltl or ctl,
        "status": verdict.status,
        "reason": verdict.reason,
        "states": verdict.states,
        "seconds": verdict.seconds,
        "witness": witness.to_dict() if witness else None,
    }
    if output is not None and witness is not None:
        write_witness(witness, output, model, settings, str(ltl or ctl), verdict.status)
    if as_json:
        say_json(report)
    else:
        reason = f" ({verdict.reason})" if verdict.reason else ""
        spent = f"{count(verdict.states or 0, 'state')}, {verdict.seconds:.1f} s"
        say(f"{verdict.status}: {ltl or ctl}{reason}; {spent}")
        if output is not None and not witness:
            warn(f"{output} is not written: there is no run to show")
        elif witness and output is not None:
            summarise(f"{model} -> {output}: {count(len(witness.steps), 'step')}")
        elif witness:
            say_witness(witness)
            if ltl is not None and witness.loop is None:
                say("  then nothing is enabled any more")
    return {"holds": HOLDS, "violated": VIOLATED, "unknown": UNKNOWN}[verdict.status]
