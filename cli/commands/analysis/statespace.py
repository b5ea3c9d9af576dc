"""``dineros statespace``: how many markings a model reaches, and other exact figures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

from dineros.cli.analysing import (
    HOLDS,
    UNKNOWN,
    budget_of,
    exploring,
    load_subject,
    memory_option,
    say_witness,
    variant_options,
)
from dineros.cli.console import say, say_json
from dineros.cli.models import rules_of
from dineros.cli.options import command, json_option, model_argument, settings_option
from dineros.cli.orders import cache_option, orders_beside
from dineros.cli.quick_start import start_quickly


@command(
    "dineros statespace sorting.sym.xmi --signals none",
    "dineros statespace sorting.sym.xmi --set BlueObjects.tokens=0 --engine symbolic --json",
)
@model_argument()
@variant_options
@click.option("--reduce", is_flag=True, help="Reduce the net first; counts are those of the reduced net.")
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
@memory_option
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
    memory: int | None,
    no_cache: bool,
    settings: tuple[str, ...],
    as_json: bool,
) -> int:
    """Count the complete state space of a model, exactly.

    Exit status 3 where memory ran out, and what was seen is printed, or where the net is unbounded: then the
    firings are printed that make places grow for ever.
    """
    if order == "depth-first" and engine != "explicit":
        raise click.UsageError("--search depth-first goes with --engine explicit")
    start_quickly()
    orders = orders_beside(model, no_cache)
    from dineros.analysis.questions.state_space import state_space

    subject = load_subject(model, settings, signals, overflow)
    net, factor = subject.net, 1
    if reduce:
        from dineros.analysis.reductions import reduce as reduce_net

        reduction = reduce_net(net, {"state_space_size"})
        net, factor = reduction.net, reduction.count_factor
    with exploring() as progress:
        budget = budget_of(memory, progress=progress)
        space = state_space(net, engine, budget, orders, order)  # type: ignore[arg-type]
    if reduce:
        space = replace(space, deadlocks=None)  # those of the reduced net tell nothing about the model
    flattened = subject.flattened is not None
    report = {
        "model": str(model),
        "signals": signals if flattened else None,
        "overflow": overflow if flattened else None,
        **rules_of(subject.model),
        "reduced": reduce,
        **space.to_dict(),
    }
    pumping = None
    if space.pumping is not None and not reduce:
        from dineros.analysis.witnesses.findings import pumping_witness

        pumping = pumping_witness(subject, space.pumping)
        report["pumping"] = pumping.to_dict()
    if as_json:
        say_json(report)
    else:
        for name, value in report.items():
            if value not in (None, "") and name != "pumping":
                say(f"{name.replace('_', ' '):22} {_shown(name, value)}")
            if name == "states" and space.complete and space.states and reduce:
                say(f"{'states of the model':22} {space.states * factor:,}")
        if pumping is not None:
            say_witness(pumping)
    return HOLDS if space.complete else UNKNOWN


def _shown(name: str, value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if name == "peak_memory_bytes" and isinstance(value, int):
        return f"{value / 2**20:,.0f} MiB"
    if isinstance(value, float):
        return f"{value:.2f}"
    return f"{value:,}" if isinstance(value, int) else str(value)
