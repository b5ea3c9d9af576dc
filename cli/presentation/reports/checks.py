"""The report of a check as a page, with pictures and state spaces."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.cli.outputs import write_page
from dineros.cli.presentation.traces import witness_picture
from dineros.cli.searching import Limits, search

if TYPE_CHECKING:
    from dineros.analysis.witnesses.findings import Finding, Report
    from dineros.metamodel import pn
    from dineros.views.reports.check_report import FindingEntry

SPACE_SECONDS = 20.0
"""Limit of the seconds of a state space in a report; longer ones are unknown there."""
LEAST_SECONDS, DRAWING_SECONDS = 0.01, 2.0
"""Its least seconds, and the seconds kept for the pictures if the time is limited."""


def write_check_report(
    report: Report, net: pn.Net, output: Path, model: Path, settings: Sequence[str], folders: Sequence[Path]
) -> None:
    """Write the findings of a check as a page, atomically; a line reports missing pictures.

    Lines of source code are shown from the current folder, or from the given ones.
    """
    from dineros.analysis.witnesses.code_lines import CodeLines
    from dineros.views.reports.check_report import CheckContent, check_page
    from dineros.views.reports.excerpts import Excerpts

    search().stage("counting the state spaces")
    spaces = _spaces(net, search().limits)
    search().stage("drawing")
    lines, excerpts = CodeLines(net), Excerpts(folders or [Path()])
    content = CheckContent(
        title=net.name or net.id,
        source=str(model),
        findings=[
            replace(_entry(finding, str(model)), code=excerpts.of(lines.of(finding)))
            for finding in report.findings
        ],
        proved=report.proved,
        assumed=report.assumed,
        unknown=[str(unknown) for unknown in report.unknown],
        spaces=spaces,
        settings=tuple(settings),
        accepted=_accepted(report),
        notes=_notes(report, net),
    )
    write_page(output, *check_page(content, net), "pictures")


def _notes(report: Report, net: pn.Net) -> list[str]:
    """Return the notes of the page on assumptions, and on times, which the state spaces ignore."""
    from dineros.analysis.model.times import left_out_times

    left_out = left_out_times(net)
    text = report.text_of_times(left_out)
    counts = [] if left_out is None else [left_out.of_counts]
    if report.times is not None and counts:
        counts = [f"the state spaces below leave them out; {counts[0]}"]
    assumes = [f"assumes: {each}" for each in report.assumes]
    return [*assumes, "; ".join([text, *counts])] if text else assumes


def _accepted(report: Report) -> list[tuple[str, str, str]]:
    """Return message, rule and reason of each finding that does not count."""
    found = [(each.finding, f"suppressed: {each.why}") for each in report.suppressed]
    found += [(finding, "known from the baseline") for finding in report.known]
    return [(finding.message, finding.rule, why) for finding, why in found]


def _entry(finding: Finding, source: str) -> FindingEntry:
    from dineros.views.reports.check_report import FindingEntry

    view, steps, times, loop = None, [], [], None
    if finding.witness is not None and finding.witness.steps:
        found = finding.witness
        view = witness_picture(found, source, finding.rule)
        steps, times = [step.text for step in found.steps], [step.time for step in found.steps]
        loop = found.loop
    return FindingEntry(
        finding.severity,
        finding.rule,
        finding.message,
        finding.elements,
        view,
        steps,
        loop,
        finding.shown_consequences,
        times=times,
    )


def _spaces(net: pn.Net, limits: Limits) -> list[dict[str, Any]]:
    """Count the state space of each signal variant, in separate processes, within the remaining budget."""
    from dineros.analysis.sweeps import Grid, share_of_memory, sweep
    from dineros.cli.options import SIGNALS
    from dineros.metamodel import sym

    is_system = isinstance(net, sym.SystemModel)
    grid = Grid((), SIGNALS if is_system else (None,), ("weighted",) if is_system else (None,), (False,))
    workers, memory = os.cpu_count() or 1, None
    if limits.memory is not None:
        workers, memory = share_of_memory(limits.memory, workers)
    seconds = SPACE_SECONDS
    if limits.left is not None:
        rounds = -(-len(list(grid)) // workers)
        seconds = max(LEAST_SECONDS, min(seconds, (limits.left - DRAWING_SECONDS) / rounds))
    with tempfile.TemporaryDirectory() as folder:
        outcome = sweep(
            net, grid, Path(folder) / "spaces.csv", memory=memory, timeout=seconds, workers=workers
        )
    return [dict(row) for row in outcome.rows]
