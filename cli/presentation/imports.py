"""Prints the result, findings and assumptions of an import: as text, as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.cli.console import SEVERITIES, note, say, say_json, summarise, warn
from dineros.metamodel.errors import counted

if TYPE_CHECKING:
    from dineros.analysis.witnesses.findings import Finding
    from dineros.observation.importing.building import Imported
    from dineros.observation.systems import ObservedSystem


@dataclass(frozen=True)
class ImportReport:
    """The report of an import."""

    system: ObservedSystem
    imported: Imported
    findings: Sequence[Finding]
    """Faults that are visible from ports."""
    output: Path
    given: Path
    """`output`, `given`: the model, and the file of what is given."""
    is_given_written: bool
    """Whether that file is new."""


def print_import(report: ImportReport, as_json: bool) -> None:
    """Print the result of an import."""
    if as_json:
        say_json(_as_json(report))
        return
    imported = report.imported
    for finding in report.findings:
        say(f"{finding.severity}: {finding.message} [{finding.rule}]", SEVERITIES.get(finding.severity))
        if finding.lines:
            say(f"    at {', '.join(finding.lines)}")
    for line in imported.left_out:
        warn(f"left out: {line}")
    for name in imported.unused:
        warn(f"{report.given}: what is given of {name} is not used: it was not seen")
    for assumed in imported.assumed:
        note(f"assumed: {assumed}")
    if imported.assumed:
        written = "says how to say it" if report.is_given_written else "can say it"
        warn(f"assumed: {_kinds(report)}; {report.given} {written}")
    summarise(f"{report.system.source} -> {report.output}: {_counts(report)}, {len(report.findings)} found")


def _counts(report: ImportReport) -> str:
    from dineros.metamodel import sym

    kinds = (
        (sym.TopicChannel, "topic"),
        (sym.ServiceChannel, "service"),
        (sym.ActionChannel, "action"),
    )
    channels = report.imported.model.channels
    counts = [(sum(isinstance(each, kind) for each in channels), noun) for kind, noun in kinds]
    nodes = counted(len(report.system.nodes), "node")
    return ", ".join([nodes, *(counted(number, noun) for number, noun in counts if number)])


def _kinds(report: ImportReport) -> str:
    """Return the number of assumptions of each kind."""
    kinds: dict[str, int] = {}
    for assumed in report.imported.assumed:
        kinds[assumed.kind] = kinds.get(assumed.kind, 0) + 1
    return ", ".join(f"{kind} ({number})" for kind, number in kinds.items())


def _as_json(report: ImportReport) -> dict[str, Any]:
    imported = report.imported
    return {
        "source": report.system.source,
        "model": str(report.output),
        "given": str(report.given),
        "findings": [
            {
                "rule": finding.rule,
                "severity": finding.severity,
                "elements": list(finding.elements),
                "message": finding.message,
                **({"code": list(finding.lines)} if finding.lines else {}),
            }
            for finding in report.findings
        ],
        "assumed": [asdict(assumed) for assumed in imported.assumed],
        "unseen": list(imported.unseen),
        "left_out": list(imported.left_out),
        "unused": list(imported.unused),
        "nodes": [asdict(node) for node in report.system.nodes],
        "topics": [asdict(topic) for topic in report.system.topics],
        "services": [asdict(service) for service in report.system.services],
    }
