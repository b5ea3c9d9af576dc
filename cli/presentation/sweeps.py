"""What came of a sweep, as text and as JSON."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.console import say, say_json, summarise
from dineros.metamodel.errors import counted

if TYPE_CHECKING:
    from dineros.analysis.sweeps import Outcome, Progress


def say_sweep(outcome: Outcome, model: Path, output: Path, figures: Path | None, as_json: bool) -> None:
    """Print what was counted, and the files that were written."""
    if as_json:
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
        return
    resumed = f", {outcome.resumed} of them from the interrupted run" if outcome.resumed else ""
    unknown = f"; {outcome.unknown} unknown" if outcome.unknown else ""
    written = f"{output}, {figures}" if figures is not None else f"{output}"
    summarise(f"{model} -> {written}: {counted(len(outcome.rows), 'point')}{resumed}{unknown}")


def say_begun_sweep(progress: Progress, model: Path, journal: Path, ending: str, as_json: bool) -> None:
    """Print what is counted of a sweep that has ended early, why it has, and how it goes on."""
    if as_json:
        say_json(
            {
                "model": str(model),
                "output": None,
                "journal": str(journal),
                "points": progress.points,
                "done": progress.done,
                "resumed": progress.resumed,
                "unknown": progress.points - progress.done + progress.unknown,
                "reason": ending,
            }
        )
        return
    say(f"unknown: all other points: {ending}", "magenta")
    kept = f"{progress.done} of {progress.points} points done and kept in {journal}"
    summarise(f"{model}: {kept}; run the same command again to go on")
