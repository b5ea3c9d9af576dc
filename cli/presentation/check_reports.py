"""The report of a check as a page: its pictures and the state spaces are made here."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.cli.console import working

if TYPE_CHECKING:
    from dineros.analysis.witnesses.findings import Finding, Report
    from dineros.metamodel import pn
    from dineros.views.reports.check_report import FindingEntry

SPACE_SECONDS = 20.0
"""Seconds that a state space may take in a report; what takes longer is unknown there."""


def write_check_report(
    report: Report, net: pn.Net, output: Path, model: Path, settings: Sequence[str], memory: int | None
) -> None:
    """Write what a check found as a page, as a whole or not at all."""
    from dineros.metamodel.files.atomic import write_atomically
    from dineros.views.reports.check_report import CheckContent, check_page

    with working("Counting the state spaces"):
        spaces = _spaces(net, memory)
    with working("Drawing"):
        content = CheckContent(
            title=net.name or net.id,
            source=str(model),
            findings=[_entry(finding, str(model)) for finding in report.findings],
            proved=report.proved,
            unknown=[str(unknown) for unknown in report.unknown],
            spaces=spaces,
            settings=tuple(settings),
        )
        write_atomically(output, check_page(content, net).encode())


def _entry(finding: Finding, source: str) -> FindingEntry:
    from dineros.views.reports.check_report import FindingEntry

    view, steps, loop = None, [], None
    if finding.witness is not None and finding.witness.steps:
        from dineros.cli.presentation.traces import witness_builder
        from dineros.views.traces.coding import TraceCoder

        builder = witness_builder(finding.witness, source)
        view = TraceCoder(builder, finding.rule).snapshot()
        steps, loop = [step.text for step in finding.witness.steps], finding.witness.loop
    return FindingEntry(finding.severity, finding.rule, finding.message, finding.elements, view, steps, loop)


def _spaces(net: pn.Net, memory: int | None) -> list[dict[str, Any]]:
    """Count the state space of each signal variant, each in a process of its own."""
    from dineros.analysis.nets.memory import OWN_MEMORY
    from dineros.analysis.sweeps import Grid, sweep
    from dineros.cli.analysing import SIGNALS
    from dineros.metamodel import sym

    is_system = isinstance(net, sym.SystemModel)
    grid = Grid((), SIGNALS if is_system else (None,), ("weighted",) if is_system else (None,), (False,))
    budget = None if memory is None else memory - OWN_MEMORY
    with tempfile.TemporaryDirectory() as folder:
        outcome = sweep(net, grid, Path(folder) / "spaces.csv", memory=budget, timeout=SPACE_SECONDS)
    return [dict(row) for row in outcome.rows]
