"""Messages lost because of a managed node, in models of source code: whether they are depends on its life.

Code does not say when a managed node is configured, activated and stopped: its manager does, or a person. So
a model of source code lets it change its state at any time, which is noted as an assumption. Then each
message that comes or goes at the wrong time can be lost. Such a finding does not apply to the code: it is a
note. It is a fault again once the facts about the node state what happens to it. Requests that are lost stay
faults: their clients may wait forever.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from dineros.analysis.checks.overflow import Presence
from dineros.analysis.witnesses.findings import Finding, Report
from dineros.metamodel import pn, sym
from dineros.metamodel.elements import node_net_of, node_nets, places

RULES = frozenset(fault.rule for fault in (Presence.INACTIVE, Presence.MISSED, Presence.LEFT))
"""Faults that lose a message of a topic because of the state of a managed node."""

WHY = "if a managed node changes its state at that time; the code does not say when it does"
OPEN = "depends on when managed nodes change their state, which the code does not say"


def left_to_lives(model: pn.Net, report: Report) -> Report:
    """Return a report in which losses are notes that need a change of state which is only assumed."""
    managed = [node for node in node_nets(model) if node.lifecycle is not None]
    if all(_is_given(node) for node in managed):
        return report
    owners = {place.id: node_net_of(place) for place in places(model)}

    def depends(rule: str, elements: Iterable[str]) -> bool:
        involved = [node for node in map(owners.get, elements) if node is not None and node.lifecycle]
        return rule in RULES and bool(involved) and not any(map(_is_given, involved))

    findings = [
        finding.as_note(f", {WHY}")
        if finding.severity != "note" and depends(finding.rule, finding.elements)
        else finding
        for finding in report.findings
    ]
    unknown = []
    for each in report.unknown:
        if depends(each.rule, each.elements):
            findings.append(Finding(each.rule, "note", each.elements, f"{each.question} {OPEN}"))
        else:
            unknown.append(each)
    return replace(report, findings=findings, unknown=unknown)


def _is_given(node: sym.NodeNet) -> bool:
    """Return whether it is stated what a managed node does, and it is not an assumption."""
    return "lifecycle" not in (node.assumed or "").split()
