"""``dineros warm-up``: compiles the engines before the first question does."""

from __future__ import annotations

import os
import time

import click

from dineros.cli.console import summarise, working
from dineros.cli.options import command


@command("dineros warm-up", "dineros warm-up --processes 1")
@click.option(
    "--processes",
    type=click.IntRange(min=1, max=64),
    metavar="N",
    help="Compile by so many processes side by side; by default one per core, up to eight.",
)
def warm_up(processes: int | None) -> int:
    """Compile the engines, which otherwise the first questions after an installation do.

    What is compiled is kept beside the installed package, or in the user's cache folder where that cannot be
    written. Each process takes up to 300 MiB. Done already, it takes no time.
    """
    from dineros.analysis.warm_up import PARTS, is_warm
    from dineros.analysis.warm_up import warm_up as compile_all

    if is_warm():
        summarise("the engines are compiled already")
        return 0
    began = time.monotonic()
    with working("compiling the engines"):
        compile_all(processes or min(len(os.sched_getaffinity(0)), len(PARTS)))
    summarise(f"compiled the engines in {time.monotonic() - began:.0f} s")
    return 0
