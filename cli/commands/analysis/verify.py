"""``dineros verify``: temporal logic."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from dineros.cli.analysing import cache_option, orders_beside, question_options
from dineros.cli.options import model_argument, model_path_option, value_option, values_option
from dineros.cli.questions.asking import Asking
from dineros.cli.questions.property_files import answer_properties, write_stored
from dineros.cli.questions.timed import time_option
from dineros.cli.questions.verifying import verify_formula, verify_stored
from dineros.cli.quick_start import start_quickly
from dineros.cli.supervising import search_command
from dineros.metamodel.errors import DinerosError


@search_command(
    "dineros verify sorting.sym.xmi --signals none --ctl 'AG EF (Shown >= 3)'",
    "dineros verify sorting.sym.xmi --signals none --ltl 'G F fired(TSense)'",
    "dineros verify door.sym.xmi Closes",
    "dineros verify race.net --time --ltl 'G (b == 0)'",
    "dineros verify race.net --time --ctl 'AF (a >= 1)'",
    "dineros verify sorting.sym.xmi --ctl 'AG EF (Shown >= 3)' --write-properties questions.xml",
)
@model_argument()
@click.argument("property_name", metavar="[PROPERTY]", required=False)
@value_option("--ltl FORMULA", "A formula that all runs must satisfy.")
@value_option("--ctl FORMULA", "A formula that the initial marking must satisfy.")
@values_option(
    "--fair TRANSITION",
    "Weakly fair, with --ltl: a transition, or all, signals, node:ID, all-but:T1,T2. Repeatable.",
    into="weak",
)
@values_option(
    "--strongly-fair TRANSITION", "Strongly fair, with --ltl; the same values. Repeatable.", into="strong"
)
@values_option(
    "--properties FILE.xml",
    "Answer a property file of the Model Checking Contest, or one of its global questions; repeatable.",
)
@model_path_option(
    "--write-properties FILE.xml",
    "Write the questions as a property file of the contest, instead of answering them.",
    into="written",
)
@cache_option
@time_option("Decide for the runs of the net with its firing intervals.")
@question_options
def verify(
    property_name: str | None,
    ltl: str | None,
    ctl: str | None,
    weak: tuple[str, ...],
    strong: tuple[str, ...],
    properties: tuple[str, ...],
    written: Path | None,
    no_cache: bool,
    **options: Any,
) -> int:
    """Verify a formula of linear (LTL) or branching (CTL) temporal logic, or all of a property file.

    Or verify a PROPERTY that the model stores, by its id or name, with the property's signals and under the
    assumptions of the model. The exit status is 0 if the answer is the expected one, 1 if not. Without any
    formula, --write-properties writes all properties of the model.

    Atoms are `Shown >= 2`, `A + 2*B < 3`, `enabled(T)`, `fired(T)`, `signal(S)` and `deadlock`. A run that
    ends in a deadlock stays in that marking forever. Exit status 0: holds; 1: violated; 3: unknown. If no run
    is found in time for an answer, the answer is given without one, and says so. With --engine tina, TINA's
    programs tina and selt answer LTL; the run of selt is replayed. --properties takes property files of the
    Model Checking Contest, and the names ReachabilityDeadlock, OneSafe, QuasiLiveness, Liveness and
    StableMarking.
    """
    start_quickly(options["model"])
    asking = Asking(**options)
    orders = orders_beside(asking.model, no_cache)
    if property_name is not None:
        if any(other not in (None, ()) for other in (ltl, ctl, weak, strong, properties, written)):
            alone = "--ltl, --ctl, --fair, --properties and --write-properties"
            raise click.UsageError(f"a property of the model cannot be combined with {alone}")
        return verify_stored(asking, property_name, orders)
    if written is not None and not properties and ltl is None and ctl is None:
        return write_stored(asking.model, asking.settings, asking.overflow, written)
    if properties:
        others = (ltl, ctl, weak, strong, asking.output)
        if asking.engine == "tina" or any(other not in (None, ()) for other in others):
            alone = "--ltl, --ctl, --fair, --engine tina and -o"
            raise click.UsageError(f"--properties cannot be combined with {alone}")
        return answer_properties(asking, properties, written)
    asking.refuse_tina_on_workers()
    if (ltl is None) == (ctl is None):
        raise click.UsageError("give either --ltl or --ctl, or --properties")
    if ltl is not None:
        return verify_formula(asking, "ltl", ltl, written, weak=weak, strong=strong)
    if weak or strong:
        raise click.UsageError("--fair requires --ltl")
    if asking.engine == "tina":
        raise DinerosError(
            "--ctl cannot be combined with --engine tina: its program selt verifies LTL only",
            hint="omit --engine, or write the formula in LTL",
        )
    return verify_formula(asking, "ctl", str(ctl), written, orders=orders)
