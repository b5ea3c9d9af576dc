"""How far a sweep is, and what came of it, as text and as JSON."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.console import say_json, summarise, warn
from dineros.cli.options import invocation

if TYPE_CHECKING:
    from dineros.analysis.sweeps import Outcome, Progress


def say_sweep(outcome: Outcome, model: Path, output: Path, figures: Path | None) -> None:
    """Print what was counted, and the files that were written."""
    resumed = f", {outcome.resumed} of them from the interrupted run" if outcome.resumed else ""
    unknown = f"; {outcome.unknown} unknown" if outcome.unknown else ""
    points = f"{len(outcome.rows)} point{'' if len(outcome.rows) == 1 else 's'}"
    written = f"{output}, {figures}" if figures is not None else f"{output}"
    summarise(f"{model} -> {written}: {points}{resumed}{unknown}")


def say_sweep_as_json(outcome: Outcome, model: Path, output: Path, figures: Path | None) -> None:
    """Print the same as one JSON object."""
    say_json(
        {
            "model": str(model),
            "output": str(output),
            "figures": None if figures is None else str(figures),
            "points": len(outcome.rows),
            "resumed": outcome.resumed,
            "unknown": outcome.unknown,
        }
    )


@contextmanager
def sweep_progress() -> Iterator[Callable[[Progress], None]]:
    """Show a bar on terminals; where the sweep is interrupted, say what is kept and how it goes on."""
    from dineros.analysis.sweeps import SweepInterrupt

    shown = sys.stderr.isatty() and invocation().verbosity >= 0
    try:
        if not shown:
            yield lambda _: None
            return
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
        from rich.progress import Progress as Bar

        columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
        with Bar(*columns, console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task("points", total=None)

            def tell(progress: Progress) -> None:
                unknown = f"points, {progress.unknown} unknown" if progress.unknown else "points"
                bar.update(task, completed=progress.done, total=progress.points, description=unknown)

            yield tell
    except SweepInterrupt as interrupt:
        done = f"{interrupt.progress.done} of {interrupt.progress.points} points done"
        warn(f"interrupted: {done} and kept; run the same command again to go on")
        raise
