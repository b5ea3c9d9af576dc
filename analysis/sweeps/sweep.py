"""Runs a sweep from the grid to the table, and continues it after an interruption."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from dineros.analysis.sweeps.cluster import cluster_answers
from dineros.analysis.sweeps.grid import Grid, Point, SweepError, model_of
from dineros.analysis.sweeps.journal import Journal
from dineros.analysis.sweeps.point import Figures, Job
from dineros.analysis.sweeps.tables import Row, Value, write_table, writer_for
from dineros.analysis.sweeps.workers import local_figures
from dineros.metamodel import pn
from dineros.metamodel.errors import Location, ModelFileError

ENOUGH = 64 << 20
"""Minimum memory of an engine for one point, in bytes; with less, fewer points are counted in parallel."""
WATCHER = 32 << 20
"""Memory of a supervising process, in bytes."""


@dataclass(frozen=True)
class Progress:
    """Progress of a sweep: points done, all points, points of earlier runs, points without an answer."""

    done: int
    points: int
    resumed: int
    unknown: int

    def __str__(self) -> str:
        unknown = f", {self.unknown} unknown" if self.unknown else ""
        return f"{self.done} of {self.points} points{unknown}"


class SweepInterrupt(KeyboardInterrupt):
    """A sweep was interrupted.

    Parameters
    ----------
    progress : Progress
        The progress stored in its journal for the next run.
    """

    def __init__(self, progress: Progress) -> None:
        super().__init__()
        self.progress = progress


@dataclass(frozen=True)
class Outcome:
    """The result of a sweep.

    Attributes
    ----------
    rows : tuple of dict
        The table, in the order of the grid.
    resumed : int
        Number of points that an earlier run had finished.
    unknown : int
        Number of points without a complete state space.
    """

    rows: tuple[Row, ...]
    resumed: int
    unknown: int


def journal_path(output: Path) -> Path:
    """Return the path of a sweep's journal."""
    return output.with_name(f"{output.name}.partial.jsonl")


def sweep(
    model: pn.Net | Callable[[Sequence[str]], pn.Net],
    grid: Grid,
    output: Path,
    *,
    engine: str = "auto",
    memory: int | None = None,
    timeout: float | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Callable[[Progress], None] | None = None,
) -> Outcome:
    """Count the state spaces of a grid of models, and write them as a table.

    Each finished point is stored in a journal next to the output, synchronised to the disk. The same sweep
    continues after an earlier run that ended in any way, and removes the journal after writing the output.

    Parameters
    ----------
    model : pn.Net or callable
        The model; or a function that returns it for values of parameters, such as ``["robots=3"]``
        (`dineros.metamodel.files.programs.ModelProgram.model`).
    output : Path
        A ``.csv`` or ``.parquet`` file, written completely at the end.
    engine : {"auto", "explicit", "symbolic"}
        See `dineros.analysis.questions.state_space`.
    memory : int, optional
        Memory of an engine for one point, in bytes; by default an equal share of 70 % of the free memory, and
        on a cluster the engine's default.
    timeout : float, optional
        Seconds for one point.
    workers : int, optional
        Number of points counted in parallel on this machine; by default the number of processors.
    scheduler : str, optional
        Address of a Dask scheduler whose workers count the points instead.
    progress : callable, optional
        Called after each point.

    Raises
    ------
    SweepError
        The grid does not fit the model, the journal belongs to another sweep, or the cluster is unavailable.
    DinerosError
        A setting does not fit the model, or a file cannot be written.
    SweepInterrupt
        Raised on Ctrl-C while there is a journal.
    """
    writer_for(output)
    _refuse_output(output)
    points = list(grid)
    texts = _texts(model, points)
    grid.check(texts[points[0].parameters])
    every = "".join(texts.values())
    with _journal(output, every, grid, engine, [memory, timeout]) as journal, _interruptible(journal, points):
        now = _progress(journal.finished, points)
        local = min(workers or os.cpu_count() or 1, len(points) - now.done)
        budget = memory if memory is not None or scheduler is not None else _share_of_memory(local)
        jobs = [
            Job(texts[point.parameters], point, engine, budget, timeout)
            for point in points
            if point.key not in journal.finished
        ]
        tell = progress or (lambda _: None)
        tell(now)
        # Closed at once after an error: processes and connections end before it is reported.
        counted = local_figures(jobs, local) if scheduler is None else cluster_answers(jobs, scheduler)
        with closing(counted):
            for job, figures in counted:
                journal.add(job.point, figures)
                now = replace(now, done=now.done + 1, unknown=now.unknown + (not figures.complete))
                tell(now)
        rows = tuple(_row(point, journal.finished[point.key]) for point in points)
        write_table(rows, output)
        journal.remove()
    return Outcome(rows, now.resumed, now.unknown)


def _texts(
    model: pn.Net | Callable[[Sequence[str]], pn.Net], points: list[Point]
) -> dict[tuple[str, ...], str]:
    """Return the models, as XMI, of all combinations of parameter values in the points."""
    from dineros.metamodel.files.xmi import xmi_bytes

    texts: dict[tuple[str, ...], str] = {}
    for point in points:
        if point.parameters in texts:
            continue
        if isinstance(model, pn.Net):
            if point.parameters:
                raise SweepError(
                    f"{point.parameters[0].partition('=')[0]} is not a feature of an element",
                    hint="write ELEMENT.FEATURE; parameters are those of a program with a function build",
                )
            made = model
        else:
            made = model(point.parameters)
        texts[point.parameters] = xmi_bytes(made).decode()
        if point.parameters:
            model_of(replace(point, settings=()), texts[point.parameters])
    return texts


def _journal(output: Path, model: str, grid: Grid, engine: str, limits: list[float | None]) -> Journal:
    path = journal_path(output)
    try:
        return Journal(path, model, grid, engine, limits)
    except OSError as error:
        raise ModelFileError(f"cannot be written: {error.strerror}", location=Location(path)) from None


def _progress(finished: dict[str, Figures], points: list[Point]) -> Progress:
    """Return the progress of a sweep that begins with the points of earlier runs."""
    done = [finished[point.key] for point in points if point.key in finished]
    return Progress(len(done), len(points), len(done), sum(not figures.complete for figures in done))


@contextmanager
def _interruptible(journal: Journal, points: list[Point]) -> Iterator[None]:
    """On an interrupt, report the points that are actually stored in the file."""
    resumed = _progress(journal.finished, points).resumed
    try:
        yield
    except KeyboardInterrupt:
        if not journal.path.exists():  # the table has been written
            raise
        kept = replace(_progress(journal.kept(), points), resumed=resumed)
        raise SweepInterrupt(kept) from None


def share_of_memory(memory: int, workers: int) -> tuple[int, int]:
    """Return the number of points to count in parallel, and the memory of an engine for each, in bytes.

    Parameters
    ----------
    memory : int
        Memory of this process and its child processes, in bytes.
    workers : int
        Maximum number of points in parallel.

    Raises
    ------
    MemoryBudgetError
        There is not enough memory for one point.
    """
    from dineros.analysis.nets.memory import (
        LEAST_FOR_SEARCH,
        OWN_MEMORY,
        MemoryBudgetError,
        resident_memory,
    )

    left = memory - max(OWN_MEMORY, resident_memory() + WATCHER)
    fit = max(1, min(workers, left // (OWN_MEMORY + ENOUGH)))
    if left // fit < OWN_MEMORY + LEAST_FOR_SEARCH:
        raise MemoryBudgetError(memory)
    return fit, left // fit - OWN_MEMORY


def _share_of_memory(workers: int) -> int:
    from dineros.analysis.nets.memory import DEFAULT_SHARE, free_memory

    return int(free_memory() * DEFAULT_SHARE) // max(workers, 1)


def _refuse_output(output: Path) -> None:
    """Check before a long computation that a file can be written."""
    if output.is_dir():
        raise ModelFileError("is a directory", location=Location(output), hint="name a file")
    if not output.parent.is_dir():
        raise ModelFileError(
            f"cannot be written: there is no folder {str(output.parent)!r}",
            location=Location(output),
            hint="create the folder first",
        )


def _row(point: Point, figures: Figures) -> Row:
    settings: dict[str, Value] = {feature: _value(value) for feature, value in point.settings}
    return {**point.columns(), **settings, **asdict(figures)}


def _value(text: str) -> Value:
    """Return integers as numbers."""
    return int(text) if re.fullmatch(r"[+-]?[0-9]{1,18}", text) else text
