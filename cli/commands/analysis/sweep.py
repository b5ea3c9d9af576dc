"""``dineros sweep``: state spaces over a grid of models, as a table (the paper's Figs 15 to 17)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dineros.cli.analysing import HOLDS, UNKNOWN, load_valid
from dineros.cli.options import (
    OVERFLOW,
    SIGNALS,
    choice_option,
    json_option,
    middleware_option,
    model_argument,
    output_option,
    settings_option,
    value_option,
)
from dineros.cli.presentation.sweeps import say_sweep, table_and_figures, write_figures
from dineros.cli.questions.sweeping import Sweeping
from dineros.cli.searching import search
from dineros.cli.supervising import search_command

if TYPE_CHECKING:
    from dineros.metamodel import pn

_REDUCED = {"no": (False,), "yes": (True,), "both": (False, True)}


def _names(known: tuple[str, ...]) -> Callable[..., tuple[str, ...] | None]:
    """Return a callback for an option with known names, separated by commas, or ``all``."""

    def read(context: click.Context, option: click.Parameter, value: str | None) -> tuple[str, ...] | None:
        if value is None or value == "all":
            return known if value else None
        names = [name.strip() for name in value.split(",")]
        for name in names:
            if name not in known:
                raise click.BadParameter(f"{name!r} is not one of {', '.join(known)}, all", context, option)
        return tuple(dict.fromkeys(names))

    return read


@search_command(
    "dineros sweep sorting.sym.xmi --vary RedObjects.tokens=0..1 --signals none -o red.csv",
    "dineros sweep sorting.sym.xmi --vary RedObjects.tokens,BlueObjects.tokens=0,1 -o two.parquet",
    "dineros sweep sorting.sym.xmi --vary RedObjects.tokens=0..1 --signals none -o figures.svg",
)
@model_argument()
@value_option(
    "--vary ELEMENT.FEATURE[,..]=VALUES",
    "Values as 0..10, 0..10..2 or 1,2,5; repeatable; features before one '=' take the same value. Of a "
    "program as MODEL, a parameter of its function build, such as robots=1..5.",
    multiple=True,
    required=True,
)
@value_option(
    "--signals all|NAME,..",
    f"Signal variants: {', '.join(SIGNALS)}.",
    callback=_names(SIGNALS),
    show_default="input-enabled",
)
@value_option(
    "--overflow all|NAME,..",
    f"Overflow variants: {', '.join(OVERFLOW)}.",
    callback=_names(OVERFLOW),
    show_default="weighted",
)
@click.option(
    "--reduced",
    type=click.Choice(list(_REDUCED)),
    default="no",
    show_default=True,
    help="Count the nets as they are, reduced ones, or both.",
)
@choice_option("--engine", ("auto", "explicit", "symbolic"), "Explicit search, or decision diagrams.")
@output_option(
    "The table to write (.csv, .parquet); or figures (.svg, .png, .pdf) with the table as .csv.",
    required=True,
)
@value_option(
    "--workers N",
    "Number of points that are counted in parallel.",
    type=click.IntRange(1),
    show_default="one for each processor",
)
@value_option("--scheduler ADDRESS", "Use the workers of this Dask scheduler, such as tcp://10.0.0.1:8786.")
@value_option(
    "--point-timeout SECONDS", "Give up a point after this time.", type=click.FloatRange(0, min_open=True)
)
@middleware_option
@settings_option
@json_option
def sweep(
    model: Path,
    vary: tuple[str, ...],
    signals: tuple[str, ...] | None,
    overflow: tuple[str, ...] | None,
    reduced: str,
    engine: str,
    output: Path,
    workers: int | None,
    scheduler: str | None,
    point_timeout: float | None,
    settings: tuple[str, ...],
    as_json: bool,
) -> int:
    """Count the state spaces of a grid of models, and write a table with a row for each.

    Finished points are stored in OUT.partial.jsonl at once: after an interruption, or when --timeout has
    ended the command, run it again to continue. The exit status is 3 if a point stays unknown; the column
    `error` has the reason. Simultaneous points share the memory; if --memory is too small for all of them,
    fewer run at a time. With --scheduler, --memory is for one point, by default 2G.
    """
    from dineros.analysis.sweeps import Axis, Grid

    if workers is not None and scheduler is not None:
        raise click.UsageError("--workers counts processes of this machine; a scheduler has its own workers")
    axes = tuple(Axis.parse(text) for text in vary)
    net = load_valid(model, settings)
    table, figures = table_and_figures(output)
    grid = Grid(axes, *_variants(net, signals, overflow), _REDUCED[reduced])
    sweeping = Sweeping(model, settings, engine, workers, scheduler, point_timeout, as_json)
    outcome = sweeping.count(net, grid, table)
    if figures is not None:
        write_figures(figures, outcome, net)
    with search().answer():
        say_sweep(outcome, net, model, table, figures, as_json)
    return UNKNOWN if outcome.unknown else HOLDS


def _variants(
    net: pn.Net, signals: tuple[str, ...] | None, overflow: tuple[str, ...] | None
) -> tuple[tuple[str | None, ...], tuple[str | None, ...]]:
    """Return the requested variants; a plain net has none."""
    from dineros.metamodel import sym

    if isinstance(net, sym.SystemModel):
        return signals or ("input-enabled",), overflow or ("weighted",)
    if signals or overflow:
        raise click.UsageError("--signals and --overflow require a system model; this is a plain net")
    return (None,), (None,)
