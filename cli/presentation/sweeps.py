"""Prints the result of a sweep: figures, text and JSON."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.console import say, say_json, summarise
from dineros.cli.presentation.answers import assumes_field, say_assumes, say_times, times_fields
from dineros.metamodel.errors import counted

if TYPE_CHECKING:
    from dineros.analysis.sweeps import Outcome, Progress
    from dineros.metamodel import pn

_FIGURES = (".svg", ".png", ".pdf")


def table_and_figures(output: Path) -> tuple[Path, Path | None]:
    """Return the table and the figures to write for the requested file.

    Raises
    ------
    DinerosError
        The table of figures would overwrite a file that is not a table of theirs.
    """
    from dineros.metamodel.errors import DinerosError, Location

    if output.suffix.lower() not in _FIGURES:
        return output, None
    table = output.with_suffix(".csv")
    if table.exists() and not output.exists():
        raise DinerosError(
            f"already exists, and the table of {output.name} would overwrite it",
            location=Location(table),
            hint="choose another name for the figures, or move the existing file",
        )
    return table, output


def write_figures(figures: Path, outcome: Outcome, net: pn.Net) -> None:
    """Write how the counts grow, as a picture."""
    from dineros.metamodel.files.atomic import write_atomically
    from dineros.views.reports.sweep_figures import sweep_figures

    write_atomically(figures, sweep_figures(outcome.rows, figures.suffix.lower(), title=net.name or net.id))


def say_sweep(
    outcome: Outcome, net: pn.Net, model: Path, output: Path, figures: Path | None, as_json: bool
) -> None:
    """Print the counts, and the written files."""
    from dineros.analysis.model.assumptions import of_source
    from dineros.analysis.model.times import left_out_times

    times, assumes = left_out_times(net), of_source(net)
    if as_json:
        say_json(
            {
                "model": str(model),
                "output": str(output),
                "figures": None if figures is None else str(figures),
                "points": len(outcome.rows),
                "resumed": outcome.resumed,
                "unknown": outcome.unknown,
                **times_fields(times, False),
                **assumes_field(assumes),
            }
        )
        return
    resumed = f", {outcome.resumed} of them from the interrupted run" if outcome.resumed else ""
    unknown = f"; {outcome.unknown} unknown" if outcome.unknown else ""
    if times is not None:
        say_times(times, times.of_counts)
    say_assumes(assumes)
    written = f"{output}, {figures}" if figures is not None else f"{output}"
    summarise(f"{model} -> {written}: {counted(len(outcome.rows), 'point')}{resumed}{unknown}")


def say_begun_sweep(progress: Progress, model: Path, journal: Path, ending: str, as_json: bool) -> None:
    """Print the progress of a sweep that has ended early, the reason, and how to continue."""
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
    summarise(f"{model}: {kept}; run the same command again to continue")
