"""``dineros statespace``: counts the markings that a model reaches, with other exact figures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dineros.cli.analysing import (
    HOLDS,
    UNKNOWN,
    cache_option,
    confirm_option,
    load_subject,
    orders_beside,
    search_order_option,
    variant_fields,
)
from dineros.cli.options import (
    choice_option,
    flag,
    json_option,
    model_argument,
    settings_option,
    variant_options,
)
from dineros.cli.presentation.state_spaces import say_state_space
from dineros.cli.questions.timed import count_with_time, time_option
from dineros.cli.quick_start import start_quickly
from dineros.cli.searching import search
from dineros.cli.supervising import search_command

if TYPE_CHECKING:
    from dineros.analysis.evidence.confirmation import Confirmation
    from dineros.analysis.portfolio.count import StateSpace
    from dineros.analysis.timed.classes import Kind


@search_command(
    "dineros statespace sorting.sym.xmi --signals none",
    "dineros statespace sorting.sym.xmi --set BlueObjects.tokens=0 --engine symbolic --json",
    "dineros statespace race.net --time --classes M",
)
@model_argument()
@variant_options
@flag("--reduce", "Count on a reduced net; counts that the reduction does not preserve are omitted.")
@choice_option(
    "--engine",
    ("auto", "explicit", "symbolic", "tina", "classes", "integer"),
    "Explicit search, decision diagrams, or TINA if it is on the PATH; with --time: state classes, or "
    "time as a counter, which counts markings.",
)
@time_option("Count with the firing intervals of the net: its state classes.")
@click.option(
    "--classes",
    "construction",
    type=click.Choice(["W", "M", "S", "E", "A"]),
    help="With --time: linear classes by equality (W, the default) or inclusion (M), strong classes by "
    "equality (S, the default with priorities) or inclusion (E), atomic classes (A).",
)
@search_order_option("The search order of the explicit engine; the counts do not depend on it.")
@confirm_option
@cache_option
@settings_option
@json_option
def statespace(
    model: Path,
    signals: str,
    overflow: str,
    reduce: bool,
    engine: str,
    timed: bool,
    construction: Kind | None,
    order: str,
    confirm: bool,
    no_cache: bool,
    settings: tuple[str, ...],
    as_json: bool,
) -> int:
    """Count the complete state space of a model, exactly.

    The exit status is 3 if time or memory ran out; the partial count is printed. It is also 3 if the net is
    unbounded; the growing places and the firings are printed. If only places grow from which no transition
    takes tokens, such as counters and logs, the state space of the net without them is counted.
    """
    if order == "depth-first" and engine != "explicit":
        raise click.UsageError("--search depth-first requires --engine explicit")
    if timed:
        start_quickly(model)
        if reduce or engine not in ("auto", "classes", "integer", "tina"):
            raise click.UsageError(
                "--time requires --engine classes, integer or tina, and cannot be combined with --reduce"
            )
        if engine == "integer" and construction is not None:
            raise click.UsageError(
                "--engine integer builds no state classes, so it cannot be combined with --classes"
            )
        return count_with_time(model, settings, signals, overflow, construction, engine, confirm, as_json)
    if engine in ("classes", "integer") or construction is not None:
        raise click.UsageError("--classes and --engine classes or integer require --time")
    start_quickly(model)
    orders = orders_beside(model, no_cache)
    from dineros.analysis.questions.reduced_space import reduced_state_space
    from dineros.analysis.questions.state_space import state_space, unfinished

    subject, run = load_subject(model, settings, signals, overflow), search()
    net = subject.net
    count = reduced_state_space if reduce else state_space
    asked = {**variant_fields(subject, model, signals, overflow), "reduced": reduce}
    confirmed: list[Confirmation | None] = [None] if confirm else []

    def say(space: StateSpace) -> int:
        say_state_space(space, subject, asked, confirmed, as_json)
        return HOLDS if space.complete else UNKNOWN

    def so_far(ending: str) -> int:
        seen = run.last.count if run.last is not None and run.last.unit == "markings" else None
        return say(unfinished(net, engine, seen, ending, run.limits.spent))

    run.draft(so_far)
    budget = run.budget()
    space = count(net, engine, budget, orders, order)  # type: ignore[arg-type]
    if confirm and space.complete:
        from dineros.analysis.evidence.confirmation import confirm_counts

        run.stage("confirming the counts")
        confirmed[0] = confirmation = confirm_counts(net, space, budget)
        if confirmation.agrees is False:
            space = replace(space, complete=False, reason=str(confirmation))
    rest = space.rest
    if rest is not None:
        rest = replace(rest, reason=run.reason(rest.reason))
    with run.answer():
        return say(replace(space, reason=run.reason(space.reason), rest=rest))
