"""``dineros statespace``: how many markings a model reaches, and other exact figures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

from dineros.cli.analysing import (
    HOLDS,
    UNKNOWN,
    exploring,
    load_subject,
    memory_budget,
    memory_option,
    variant_options,
)
from dineros.cli.console import say, say_json
from dineros.cli.options import command, json_option, model_argument, settings_option


@command(
    "dineros statespace sorting.sym.xmi --signals none",
    "dineros statespace sorting.sym.xmi --set BlueObjects.tokens=0 --engine symbolic --json",
)
@model_argument()
@variant_options
@click.option("--reduce", is_flag=True, help="Reduce the net first; counts are those of the reduced net.")
@click.option(
    "--engine",
    type=click.Choice(["auto", "explicit", "symbolic"]),
    default="auto",
    show_default=True,
    help="Explicit search, or decision diagrams.",
)
@memory_option
@settings_option
@json_option
def statespace(
    model: Path,
    signals: str,
    overflow: str,
    reduce: bool,
    engine: str,
    memory: int | None,
    settings: tuple[str, ...],
    as_json: bool,
) -> int:
    """Count the complete state space of a model, exactly.

    Exit status 3 where memory ran out or the net is unbounded; what was seen is printed all the same.
    """
    from dineros.analysis.statespace import state_space

    subject = load_subject(model, settings, signals, overflow)
    net, factor = subject.net, 1
    if reduce:
        from dineros.analysis.reductions import reduce as reduce_net

        reduction = reduce_net(net, {"state_space_size"})
        net, factor = reduction.net, reduction.count_factor
    with exploring() as progress:
        space = state_space(net, engine, memory_budget(memory), progress)  # type: ignore[arg-type]
    if reduce:
        space = replace(space, deadlocks=None)  # those of the reduced net tell nothing about the model
    flattened = subject.flattened is not None
    report = {
        "model": str(model),
        "signals": signals if flattened else None,
        "overflow": overflow if flattened else None,
        "reduced": reduce,
        **space.to_dict(),
    }
    if as_json:
        say_json(report)
    else:
        for name, value in report.items():
            if value not in (None, ""):
                say(f"{name.replace('_', ' '):22} {_shown(name, value)}")
            if name == "states" and space.complete and space.states and reduce:
                say(f"{'states of the model':22} {space.states * factor:,}")
    return HOLDS if space.complete else UNKNOWN


def _shown(name: str, value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if name == "peak_memory_bytes" and isinstance(value, int):
        return f"{value / 2**20:,.0f} MiB"
    if isinstance(value, float):
        return f"{value:.2f}"
    return f"{value:,}" if isinstance(value, int) else str(value)
