"""``dineros warm-up``: compiles the engines before the first question."""

from __future__ import annotations

import os
import time

import click

from dineros.cli.console import summarise, working
from dineros.cli.options import command, value_option


@command("dineros warm-up", "dineros warm-up --processes 1")
@value_option(
    "--processes N",
    "The number of parallel processes; by default one per core, up to eight.",
    type=click.IntRange(min=1, max=64),
)
def warm_up(processes: int | None) -> int:
    """Compile the engines; otherwise the first questions after an installation compile them.

    The compiled code is stored next to the installed package, or in the user's cache folder if that folder
    cannot be written. Each process takes up to 300 MiB. Repeating the command takes no time.
    """
    from dineros.analysis.warm_up import PARTS, is_warm
    from dineros.analysis.warm_up import warm_up as compile_all

    if is_warm():
        summarise("the engines are already compiled")
        return 0
    began = time.monotonic()
    with working("compiling the engines"):
        compile_all(processes or min(len(os.sched_getaffinity(0)), len(PARTS)))
    summarise(f"compiled the engines in {time.monotonic() - began:.0f} s")
    return 0
