"""``dineros verify``: temporal logic."""

from __future__ import annotations

from pathlib import Path

import click

from dineros.cli.analysing import (
    HOLDS,
    UNKNOWN,
    VIOLATED,
    count,
    exploring,
    load_subject,
    memory_budget,
    question_engine_option,
    question_options,
    reading_formula,
    say_witness,
    write_witness,
)
from dineros.cli.console import say, say_json, summarise, warn
from dineros.cli.options import ModelPath, command, model_argument
from dineros.cli.orders import cache_option, orders_beside
from dineros.cli.property_files import answer_properties, write_formula, write_properties
from dineros.cli.quick_start import start_quickly


@command(
    "dineros verify sorting.sym.xmi --signals none --ctl 'AG EF (Shown >= 3)'",
    "dineros verify sorting.sym.xmi --signals none --ltl 'G F fired(TSense)'",
    "dineros verify net.pnml --properties CTLFireability.xml --properties Liveness",
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
    "--properties",
    multiple=True,
    metavar="FILE.xml",
    help="Answer a property file of the Model Checking Contest, or one of its global questions; repeatable.",
)
@click.option(
    "--write-properties",
    "written",
    type=ModelPath(),
    metavar="FILE.xml",
    help="Write what is asked as a property file of the contest, instead of answering it.",
)
@click.option(
    "--timeout",
    type=click.FloatRange(min=0, min_open=True),
    metavar="SECONDS",
    help="Give up after so long; with --properties, so long for each of them, all together.",
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
    properties: tuple[str, ...],
    written: Path | None,
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
    """Verify a formula of linear (LTL) or branching (CTL) temporal logic, or all of a property file.

    Atoms are `Shown >= 2`, `A + 2*B < 3`, `enabled(T)`, `fired(T)`, `signal(S)` and `deadlock`. A run that
    ends in a deadlock stays there for ever. Exit status 0: holds; 1: violated; 3: unknown. An answer for
    which no run is found in time stands without one, and says so. With --engine tina, TINA's programs tina
    and selt answer for LTL; the run that selt shows is replayed. --properties takes property files of the
    Model Checking Contest, and the names ReachabilityDeadlock, OneSafe, QuasiLiveness, Liveness and
    StableMarking.
    """
    start_quickly()
    orders = orders_beside(model, no_cache)
    from dineros.analysis.logic.ctl.checking import check_ctl
    from dineros.analysis.logic.ltl.verification import verify_ltl
    from dineros.analysis.logic.verdicts.budget import Budget
    from dineros.analysis.witnesses.findings import witness_of
    from dineros.metamodel.errors import DinerosError

    if properties:
        if ltl is not None or ctl is not None or weak or strong or engine == "tina" or output is not None:
            raise click.UsageError(
                "--properties goes with none of --ltl, --ctl, --fair, --engine tina and -o"
            )
        subject = load_subject(model, settings, signals, overflow)
        if written is not None:
            return write_properties(subject, properties, written)
        return answer_properties(subject, model, properties, timeout, memory_budget(memory), as_json)
    if (ltl is None) == (ctl is None):
        raise click.UsageError("give either --ltl or --ctl, or --properties")
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
    if written is not None:
        with reading_formula("--ltl" if ctl is None else "--ctl"):
            return write_formula(subject, model, ltl, ctl, written)
    limit = memory_budget(memory)
    budget = Budget(limit, seconds=timeout)
    with exploring() as progress, reading_formula("--ltl" if ctl is None else "--ctl"):
        if ltl is not None and engine == "tina":
            from dineros.analysis import tina

            verdict = tina.verify(subject.net, ltl, subject.names, weak, strong, timeout, limit)
        elif ltl is not None:
            verdict = verify_ltl(subject.net, ltl, subject.names, weak, strong, budget, progress)
        else:
            assert ctl is not None
            verdict = check_ctl(subject.net, ctl, subject.names, budget, progress, orders=orders)
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
        spent = f"{count(verdict.states, 'state')}, {verdict.seconds:.1f} s"
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
