"""Findings about invented nodes, which stand for the other ends of channels: they are left out."""

from __future__ import annotations

from dataclasses import replace

from dineros.analysis.witnesses.findings import Finding, Report
from dineros.metamodel import pn, sym
from dineros.metamodel.elements import is_unseen, node_net_of, node_nets, nodes


def about_seen(model: pn.Net, report: Report) -> Report:
    """Return a report without the findings that are about invented nodes only."""
    if not isinstance(model, sym.SystemModel):
        return report
    nets = list(node_nets(model))
    if not any(map(is_unseen, nets)):
        return report
    owners = {each.id: node_net_of(each) for each in (*nodes(model), *nets)}

    def is_kept(finding: Finding) -> bool:
        known = [owners[each] for each in finding.elements if each in owners]
        return not known or not all(map(is_unseen, known))

    return replace(report, findings=[each for each in report.findings if is_kept(each)])
