"""``dineros verify``: temporal logic."""

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
from dineros.cli.options import ModelPath, model_argument
from dineros.cli.orders import cache_option, orders_beside
from dineros.cli.presentation.answers import say_unfairness, say_verdict
from dineros.cli.presentation.evidence import certificate_option, confirm_option, refuse_certificates
from dineros.cli.presentation.property_files import answer_properties, write_formula, write_properties
from dineros.cli.presentation.scheduling import scheduler_option
from dineros.cli.quick_start import start_quickly
from dineros.cli.searching import search
from dineros.cli.stored_properties import verify_stored, write_stored
from dineros.cli.supervising import search_command

if TYPE_CHECKING:
    from dineros.analysis.answers.outcome import Outcome


@search_command(
    "dineros verify sorting.sym.xmi --signals none --ctl 'AG EF (Shown >= 3)'",
    "dineros verify sorting.sym.xmi --signals none --ltl 'G F fired(TSense)'",
    "dineros verify door.sym.xmi Closes",
    "dineros verify sorting.sym.xmi --ctl 'AG EF (Shown >= 3)' --write-properties questions.xml",
)
@model_argument()
@click.argument("property_name", metavar="[PROPERTY]", required=False)
@click.option("--ltl", metavar="FORMULA", help="A formula that all runs must satisfy.")
@click.option("--ctl", metavar="FORMULA", help="A formula that the initial marking must satisfy.")
@click.option(
    "--fair",
    "weak",
    multiple=True,
    metavar="TRANSITION",
    help="Weakly fair, with --ltl: a transition, or all, signals, node:ID, all-but:T1,T2. Repeatable.",
)
@click.option(
    "--strongly-fair",
    "strong",
    multiple=True,
    metavar="TRANSITION",
    help="Strongly fair, with --ltl; the same words. Repeatable.",
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
@cache_option
@question_engine_option
@certificate_option
@confirm_option
@scheduler_option
@question_options
def verify(
    model: Path,
    property_name: str | None,
    ltl: str | None,
    ctl: str | None,
    weak: tuple[str, ...],
    strong: tuple[str, ...],
    properties: tuple[str, ...],
    written: Path | None,
    timeout: float | None,
    engine: str,
    certificate: Path | None,
    confirm: bool,
    scheduler: str | None,
    output: Path | None,
    signals: str,
    overflow: str,
    memory: int | None,
    no_cache: bool,
    settings: tuple[str, ...],
    as_json: bool,
) -> int:
    """Verify a formula of linear (LTL) or branching (CTL) temporal logic, or all of a property file.

    Or a PROPERTY that the model stores, by its id or name: with the signals that it says, under the
    assumptions of the model. Exit status 0 where that is as expected, 1 where not. Without any formula,
    --write-properties writes all that the model stores.

    Atoms are `Shown >= 2`, `A + 2*B < 3`, `enabled(T)`, `fired(T)`, `signal(S)` and `deadlock`. A run that
    ends in a deadlock stays there for ever. Exit status 0: holds; 1: violated; 3: unknown. An answer for
    which no run is found in time stands without one, and says so. With --engine tina, TINA's programs tina
    and selt answer for LTL; the run that selt shows is replayed. --properties takes property files of the
    Model Checking Contest, and the names ReachabilityDeadlock, OneSafe, QuasiLiveness, Liveness and
    StableMarking.
    """
    start_quickly()
    orders = orders_beside(model, no_cache)
    from dineros.analysis.evidence.proving import Asked
    from dineros.analysis.model.fairness import fair_transitions, unfairness
    from dineros.analysis.questions.engines import Branching, Linear, Question
    from dineros.analysis.witnesses.findings import witness_of
    from dineros.metamodel.errors import DinerosError

    if property_name is not None:
        if any(other not in (None, ()) for other in (ltl, ctl, weak, strong, properties, written)):
            alone = "--ltl, --ctl, --fair, --properties and --write-properties"
            raise click.UsageError(f"a property of the model goes with none of {alone}")
        backing = Backing(certificate, confirm)
        return verify_stored(
            model,
            property_name,
            settings,
            overflow,
            orders,
            backing,
            engine=engine,
            scheduler=scheduler,
            output=output,
            as_json=as_json,
        )
    if written is not None and not properties and ltl is None and ctl is None:
        return write_stored(model, settings, overflow, written)
    if properties:
        others = (ltl, ctl, weak, strong, output, confirm or None)
        if engine == "tina" or any(other not in (None, ()) for other in others):
            alone = "--ltl, --ctl, --fair, --engine tina, --confirm and -o"
            raise click.UsageError(f"--properties goes with none of {alone}")
        if certificate is not None and (scheduler is not None or certificate.suffix == ".json"):
            raise click.UsageError("of a property file, --certificate is a folder, and no scheduler's matter")
        if certificate is not None:
            refuse_certificates(certificate, also_folder=True)
        subject = load_subject(model, settings, signals, overflow)
        if written is not None:
            return write_properties(subject, properties, written)
        wanted = None if certificate is None else (certificate, settings)
        variant = signals, overflow
        return answer_properties(subject, model, properties, as_json, scheduler, variant, wanted)
    if scheduler is not None and engine == "tina":
        raise click.UsageError("workers of a scheduler do not ask TINA")
    if (ltl is None) == (ctl is None):
        raise click.UsageError("give either --ltl or --ctl, or --properties")
    if ctl is not None and (weak or strong):
        raise click.UsageError("fairness goes with --ltl")
    if ctl is not None and engine == "tina":
        raise DinerosError(
            "--ctl cannot go with --engine tina: its program selt verifies LTL only",
            hint="leave out --engine, or say it in LTL",
        )
    run, formula, backing = search(), str(ltl or ctl), Backing(certificate, confirm)
    rules: dict[str, object] = {}

    def say(verdict: Outcome) -> int:
        verdict = replace(verdict, reason=run.reason(verdict.reason))
        witness = unfair = None
        if verdict.status == "violated" and verdict.loop and ltl is not None:
            unfair = unfairness(subject, verdict.stem, verdict.loop)
        if verdict.stem or verdict.loop:
            loop = len(verdict.stem) if verdict.loop else None
            witness = witness_of(subject, [*verdict.stem, *verdict.loop], loop)
        if output is not None and witness is not None:
            write_witness(witness, output, model, settings, formula, verdict.status)
        if as_json:
            say_json(
                {
                    "model": str(model),
                    **rules,
                    "formula": formula,
                    "status": verdict.status,
                    "reason": verdict.reason,
                    "by": verdict.by,
                    "states": verdict.states,
                    "seconds": verdict.seconds,
                    "witness": witness.to_dict() if witness else None,
                    "unfair": unfair.to_dict(subject.net.transitions) if unfair else None,
                    **backing.to_dict(),
                }
            )
        else:
            say_verdict(verdict, formula, witness, model, output, is_linear=ltl is not None)
            if unfair is not None and output is None:
                say_unfairness(unfair, subject.net.transitions)
        backing.say(verdict, as_json)
        return {"holds": HOLDS, "violated": VIOLATED, "unknown": UNKNOWN}[verdict.status]

    run.draft(lambda ending: say(run.unknown(ending)))
    subject = load_subject(model, settings, signals, overflow)
    rules.update(rules_of(subject.model))
    if written is not None:
        with run.answer(), reading_formula("--ltl" if ctl is None else "--ctl"):
            return write_formula(subject, model, ltl, ctl, written)
    with reading_formula("--fair"):
        weak = fair_transitions(subject, weak)
    with reading_formula("--strongly-fair"):
        strong = fair_transitions(subject, strong)
    question: Question
    if ltl is not None:
        question = Linear(subject.net, subject.names, ltl, weak, strong)
    else:
        assert ctl is not None
        question = Branching(subject.net, subject.names, ctl, orders)
    with reading_formula("--ltl" if ctl is None else "--ctl"):
        asked = Asked(subject, "ltl" if ltl is not None else "ctl", formula, signals, overflow, settings)
        more = {"weak": weak, "strong": strong}
        verdict = answered(asked, question, run, backing, engine, scheduler, **more)
    with run.answer():
        return say(verdict)
