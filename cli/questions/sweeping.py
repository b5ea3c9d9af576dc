"""Counts the points of a sweep within the budget, and prints the stored progress if it ends early."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.analysing import UNKNOWN
from dineros.cli.models import load_named
from dineros.cli.presentation.sweeps import say_begun_sweep
from dineros.cli.searching import search

if TYPE_CHECKING:
    from dineros.analysis.sweeps import Grid, Outcome, Progress
    from dineros.metamodel import pn


@dataclass(frozen=True)
class Sweeping:
    """The options for counting the points of a sweep."""

    model: Path
    settings: tuple[str, ...]
    """`model`, `settings`: the model's file, and its changes before features are varied."""
    engine: str
    """Who counts a point."""
    workers: int | None
    """Points at a time on this machine; one for each processor unless given."""
    scheduler: str | None
    """Address of a Dask scheduler whose workers count instead."""
    point_timeout: float | None
    """Seconds for one point."""
    as_json: bool
    """Whether what is kept of a sweep that ends early is printed as JSON."""

    def count(self, net: pn.Net, grid: Grid, table: Path) -> Outcome:
        """Count all points, and write the table.

        Raises
        ------
        DinerosError
            See `dineros.analysis.sweeps.sweep`; of a setting, it names the model.
        SweepInterrupt
            By Ctrl-C.
        """
        from dineros.analysis.sweeps import Progress, SweepError, SweepInterrupt, sweep
        from dineros.analysis.sweeps.sweep import journal_path
        from dineros.metamodel.errors import DinerosError, Location
        from dineros.metamodel.files.programs import is_program

        run, far = search(), Progress(0, 0, 0, 0)
        run.stage("counting")

        def so_far(ending: str) -> int:
            say_begun_sweep(far, self.model, journal_path(table), ending, self.as_json)
            return UNKNOWN

        def tell(progress: Progress) -> None:
            nonlocal far
            if not far.points:
                run.draft(so_far)
            far = progress
            run.far(str(progress))

        workers, memory = self._shares(run.limits.memory)
        try:
            return sweep(
                (lambda values: load_named(self.model, [*self.settings, *values]))
                if is_program(self.model)
                else net,
                grid,
                table,
                engine=self.engine,
                memory=memory,
                timeout=self.point_timeout,
                workers=workers,
                scheduler=self.scheduler,
                progress=tell,
            )
        except DinerosError as error:
            if not isinstance(error, SweepError):  # a setting is not in a file; its model is
                error.location = error.location or Location(self.model)
            raise
        except SweepInterrupt as interrupt:
            far = interrupt.progress
            raise

    def _shares(self, memory: int | None) -> tuple[int | None, int | None]:
        """Return the number of points counted in parallel, and the bytes that each may use."""
        from dineros.analysis.nets.memory import OWN_MEMORY
        from dineros.analysis.sweeps import share_of_memory

        if memory is None:
            return self.workers, None
        if self.scheduler is not None:
            return self.workers, memory - OWN_MEMORY
        return share_of_memory(memory, self.workers or os.cpu_count() or 1)
