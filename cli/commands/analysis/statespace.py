"""``dineros statespace``: how many markings a model reaches, and other exact figures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dineros.cli.analysing import (
    HOLDS,
    UNKNOWN,
    budget_options,
    load_subject,
    say_witness,
    variant_options,
)
from dineros.cli.console import say, say_json
from dineros.cli.models import rules_of
from dineros.cli.options import json_option, model_argument, settings_option
from dineros.cli.orders import cache_option, orders_beside
from dineros.cli.presentation.evidence import confirm_option, say_confirmation
from dineros.cli.quick_start import start_quickly
from dineros.cli.searching import search
from dineros.cli.supervising import search_command

if TYPE_CHECKING:
    from dineros.analysis.evidence.confirmation import Confirmation
    from dineros.analysis.questions.state_space import StateSpace

_OF_THE_REDUCED_NET = ("places", "transitions")
_OF_THE_REST = (
    "states",
    "arcs",
    "deadlocks",
    "max_tokens_in_place",
    "max_tokens_in_marking",
    "engine",
    "complete",
    "reason",
)


@search_command(
    "dineros statespace sorting.sym.xmi --signals none",
    "dineros statespace sorting.sym.xmi --set BlueObjects.tokens=0 --engine symbolic --json",
)
@model_argument()
@variant_options
@click.option("--reduce", is_flag=True, help="Count on a smaller net; what that does not keep is left out.")
@click.option(
    "--engine",
    type=click.Choice(["auto", "explicit", "symbolic", "tina"]),
    default="auto",
    show_default=True,
    help="Explicit search, decision diagrams, or TINA where it is on the PATH.",
)
@click.option(
    "--search",
    "order",
    type=click.Choice(["breadth-first", "depth-first"]),
    default="breadth-first",
    show_default=True,
    help="How the explicit engine goes; counts are the same.",
)
@confirm_option
@budget_options
@cache_option
@settings_option
@json_option
def statespace(
    model: Path,
    signals: str,
    overflow: str,
    reduce: bool,
    engine: str,
    order: str,
    confirm: bool,
    timeout: float | None,
    memory: int | None,
    no_cache: bool,
    settings: tuple[str, ...],
    as_json: bool,
) -> int:
    """Count the complete state space of a model, exactly.

    Exit status 3 where time or memory ran out, and what was seen is printed, or where the net is unbounded:
    then the firings are printed that make places grow for ever. Where places that nothing takes from, such as
    counters and logs, may be all that grows, the state space of the rest is counted: of the net without them.
    """
    if order == "depth-first" and engine != "explicit":
        raise click.UsageError("--search depth-first goes with --engine explicit")
    start_quickly()
    orders = orders_beside(model, no_cache)
    from dineros.analysis.questions.reduced_space import reduced_state_space
    from dineros.analysis.questions.state_space import state_space, unfinished

    subject, run = load_subject(model, settings, signals, overflow), search()
    net = subject.net
    confirmation: Confirmation | None = None
    count = reduced_state_space if reduce else state_space

    def say_space(space: StateSpace) -> int:
        flattened = subject.flattened is not None
        report = {
            "model": str(model),
            "signals": signals if flattened else None,
            "overflow": overflow if flattened else None,
            **rules_of(subject.model),
            "reduced": reduce,
            **replace(space, reason=run.reason(space.reason)).to_dict(),
            **({"reduced_states": space.reduced_states} if reduce else {}),
        }
        if confirm:
            report["confirmation"] = confirmation.to_dict() if confirmation else None
        pumping = None
        if space.pumping is not None:
            from dineros.analysis.witnesses.findings import pumping_witness

            pumping = pumping_witness(subject, space.pumping)
            report["pumping"] = pumping.to_dict()
        if space.rest is not None:
            rest = replace(space.rest, reason=run.reason(space.rest.reason)).to_dict()
            report["rest"] = {"without": list(space.without), **{name: rest[name] for name in _OF_THE_REST}}
        if as_json:
            say_json(report)
        for name, value in report.items() if not as_json else ():
            if value not in (None, "") and name not in ("pumping", "rest", "confirmation"):
                of_which = " (of the reduced net)" if reduce and name in _OF_THE_REDUCED_NET else ""
                say(f"{name.replace('_', ' '):22} {_shown(name, value)}{of_which}")
        if pumping is not None and not as_json:
            say_witness(pumping)
        if space.rest is not None and not as_json:
            _say_rest(report["rest"])
        if confirmation is not None:
            say_confirmation(confirmation, as_json)
        return HOLDS if space.complete else UNKNOWN

    def so_far(ending: str) -> int:
        seen = run.last.count if run.last is not None and run.last.unit == "markings" else None
        return say_space(unfinished(net, engine, seen, ending, run.limits.spent))

    run.draft(so_far)
    budget = run.budget()
    space = count(net, engine, budget, orders, order)  # type: ignore[arg-type]
    if confirm and space.complete:
        from dineros.analysis.evidence.confirmation import confirm_counts

        run.stage("confirming the counts")
        confirmation = confirm_counts(net, space, budget)
        if confirmation.agrees is False:
            space = replace(space, complete=False, reason=str(confirmation))
    with run.answer():
        return say_space(space)


def _say_rest(rest: dict[str, object]) -> None:
    """Print what a net has without the places that only grow."""
    without = ", ".join(str(place) for place in rest["without"])  # type: ignore[attr-defined]
    say(f"the rest, without what nothing takes from ({without}):")
    for name, value in rest.items():
        if name != "without" and value not in (None, ""):
            say(f"  {name.replace('_', ' '):21} {_shown(name, value)}")


def _shown(name: str, value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if name == "peak_memory_bytes" and isinstance(value, int):
        return f"{value / 2**20:,.0f} MiB"
    if isinstance(value, float):
        return f"{value:.2f}"
    return f"{value:,}" if isinstance(value, int) else str(value)
