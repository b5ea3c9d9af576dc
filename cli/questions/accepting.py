"""``dineros check --baseline`` and ``--write-baseline``, and the suppressions of the model."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.options import Adds, model_path_option, together
from dineros.cli.outputs import refuse_output

if TYPE_CHECKING:
    from dineros.analysis.witnesses.findings import Report
    from dineros.metamodel import pn

baseline_options: Adds = together(
    model_path_option(
        "--baseline FILE",
        "Report only what is not in FILE: a baseline, or the JSON or SARIF of an earlier check.",
    ),
    model_path_option(
        "--write-baseline FILE", "Write the findings to a baseline (.json); they count as known."
    ),
)


class Acceptance:
    """The accepted findings of a model: by its suppressions, and by baselines.

    Parameters
    ----------
    baseline : Path or None
        The known findings.
    written : Path or None
        The baseline to write.

    Raises
    ------
    DinerosError
        The baseline cannot be read, or a baseline cannot be written there.
    """

    def __init__(self, net: pn.Net, baseline: Path | None, written: Path | None) -> None:
        from dineros.analysis.acceptance.baseline import Baseline
        from dineros.analysis.acceptance.suppressions import Suppressions

        if written is not None:
            refuse_output(written, [".json"], "of a baseline")
        self._suppressions = Suppressions(net)
        self._baseline = Baseline.read(baseline) if baseline is not None else None
        self._written = written

    def apply(self, report: Report) -> Report:
        """Return a report in which accepted findings are separate, with the worst findings first."""
        from dineros.analysis.timed_checks.faults import TIMED_FAULTS
        from dineros.analysis.witnesses.findings import worst_first

        report = self._suppressions.apply(report, TIMED_FAULTS)
        report = self._baseline.apply(report) if self._baseline is not None else report
        return report.with_accepted(worst_first(report.findings), report.suppressed, report.known)

    def write(self, report: Report) -> Report:
        """Write the baseline, if requested; return the report compared with it."""
        from dineros.analysis.acceptance.baseline import Baseline, to_baseline
        from dineros.metamodel.files.atomic import write_atomically

        if self._written is None:
            return report
        content = to_baseline(report)
        text = json.dumps(content, indent=2, ensure_ascii=False) + "\n"
        write_atomically(self._written, text.encode())
        report.findings, report.known = [*report.findings, *report.known], []
        return Baseline.of(content).apply(report)
