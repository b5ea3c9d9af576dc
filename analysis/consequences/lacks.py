"""Parts of source code that are never used: the code that uses them may be what the model lacks.

A model of source code can lack code that was not read, or ports whose names are open. Such code may call a
service, send a goal or publish a message. So a part of the model that is never used says little about the
code as long as the model lacks anything: it is a note. It is a fault again where the model lacks nothing.
"""

from __future__ import annotations

from dataclasses import replace

from dineros.analysis.checks import unused
from dineros.analysis.model.assumptions import of_source
from dineros.analysis.witnesses.findings import Report
from dineros.metamodel import pn

RULES = frozenset(
    fault.rule
    for fault in (unused.TOPIC, unused.NOT_CALLED, unused.NO_GOAL, unused.NODE_NET, unused.TRANSITION)
)
"""Faults of parts that are never used."""

WHY = "but the model lacks code that may change this"


def left_to_lacks(model: pn.Net, report: Report) -> Report:
    """Return a report in which unused parts are notes if the model lacks parts of its source."""
    if not of_source(model):
        return report
    findings = [
        finding.as_note(f", {WHY}") if finding.rule in RULES and finding.severity != "note" else finding
        for finding in report.findings
    ]
    return replace(report, findings=findings)
