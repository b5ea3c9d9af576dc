"""What code shows against proofs on its model: callbacks and programs that never continue there.

The model lets a callback end that waits for its own thread by a rate or a lock. Then what is proved on the
model rests on an assumption that the code contradicts.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.witnesses.findings import Finding, Report

NEVER_CONTINUE = {"code-waits-for-itself", "code-waits-unspun", "code-never-starts", "code-gives-none"}
"""Rules of code that never continues after a call, or never answers."""
_ON_THE_MODEL = {"callback-deadlock", "callback-never-ends"}


def contradicted(report: Report, of_code: Iterable[Finding]) -> Report:
    """Return a report in which proofs are assumed if code never continues, and the model does not show it.

    Parameters
    ----------
    report : Report
        The report on the model.
    of_code : iterable of Finding
        The faults of its code.
    """
    blocked = [each for each in of_code if each.rule in NEVER_CONTINUE and each.severity == "error"]
    if not blocked or not report.proved or any(each.rule in _ON_THE_MODEL for each in report.findings):
        return report
    reason = f"the proofs assume that the code continues, but {blocked[0].message}"
    outcome = Outcome.left_open("what holds if code never continues", reason)
    assumed = [*report.assumed, *report.proved]
    return replace(report, proved=[], assumed=assumed, unknown=[*report.unknown, outcome])
