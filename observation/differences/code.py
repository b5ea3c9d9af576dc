"""Compares source code with a running system."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from dineros.analysis.witnesses.findings import Finding, Report
from dineros.observation.differences.comparing import ROLES, compare_nodes
from dineros.observation.differences.described import Described
from dineros.observation.systems import ObservedSystem, name_of, within


def differences_of_code(
    code: ObservedSystem, seen: ObservedSystem, namespaces: Sequence[str] = (), without: Sequence[str] = ()
) -> Report:
    """Return the differences between a running graph and source code, at the lines of the code.

    Parameters
    ----------
    code : ObservedSystem
        The nodes of the code, each for itself.
    seen : ObservedSystem
        The graph.
    namespaces, without : sequence of str
        Only nodes in these namespaces; full names of nodes that are left out.
    """
    code, seen = (within(each, namespaces, without) for each in (code, seen))
    elements: dict[tuple[str, str, str], str] = {}
    lines: dict[tuple[str, ...], str] = {}
    for node in code.nodes:
        elements[node.name, "", ""] = node.name
        for role in ROLES:
            for port in getattr(node, role):
                elements[node.name, role, name_of(port)] = node.name
                lines.setdefault((node.name, name_of(port)), port.at)
    managed = frozenset(node.name for node in code.nodes if node.lifecycle is not None)
    report = Report()
    compare_nodes(code, seen, report, Described(code, elements, managed))
    report.findings = [_of_code(each, lines.get(each.elements, "")) for each in report.findings]
    return report


def _of_code(finding: Finding, line: str) -> Finding:
    return replace(
        finding, message=finding.message.replace("the model", "the code"), lines=(line,) if line else ()
    )
