"""Transitions whose clause can never be true are left out, and what refers to them too."""

from __future__ import annotations

from dineros.analysis.checks.check import check
from dineros.analysis.model.subject import base_subject
from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.clauses import set_clause


def test_a_reference_to_a_blocked_transition_goes_with_it() -> None:
    model = sym.SystemModel(id="system")
    net = sym.NodeNet(id="node", net=model)
    sym.InputSignal(id="ready", node=net)
    start, end = sym.Place(id="start", tokens=1, page=net), sym.Place(id="end", page=net)
    work = sym.Transition(id="work", page=net)
    flow(start, work, end)
    set_clause(work, "ready & !ready")
    page = pn.Page(id="states", page=net)
    noted = sym.Place(id="noted", page=page)
    flow(pn.ReferenceTransition(id="again", target=work, page=page), noted)
    assert base_subject(model).net.transitions == ()
    assert "unsatisfiable-clause" in {finding.rule for finding in check(model).findings}
