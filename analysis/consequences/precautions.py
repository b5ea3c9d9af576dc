"""Transitions for what follows a time-out, if with the times of a model no client ever gives up.

Such a transition never fires with times. It is a precaution, and no fault: without times it can fire, and if
no client gave up, it could not even then.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

from dineros.analysis.answers.budget import Budget
from dineros.analysis.checks.boundedness import Boundedness
from dineros.analysis.checks.check import check
from dineros.analysis.checks.unused import TRANSITION, Use
from dineros.analysis.consequences.used import used_in_runs
from dineros.analysis.model.subject import Subject
from dineros.analysis.witnesses.findings import Finding, Report
from dineros.metamodel import sym
from dineros.metamodel.elements import channels

SHARE = 0.2
"""Part of the time for each of the two questions."""

WHY = "with these times: it follows a time-out, and no client gives up"


def about_precautions(subject: Subject, report: Report, budget: Budget) -> Report:
    """Return a report in which transitions that are precautions are notes.

    Parameters
    ----------
    subject
        The net with its times, which this leaves out.
    report
        What a check with times found.
    budget
        Limits.
    """
    careful = _precautions(subject, report.findings, budget)
    findings = [
        replace(each, severity="note", message=f"{each.message} {WHY}") if each in careful else each
        for each in report.findings
    ]
    return replace(report, findings=findings)


def _precautions(subject: Subject, some: Sequence[Finding], budget: Budget) -> list[Finding]:
    model = subject.model
    dead = [each for each in some if each.rule == TRANSITION.rule]
    if not dead or not isinstance(model, sym.SystemModel) or not _with_time_outs(model):
        return []
    needed = used_in_runs(subject, dead, budget.share(SHARE))
    if not needed:
        return []
    with _without_time_outs(model):
        report = check(model, budget.share(SHARE), questions=[Boundedness(), Use()])
    never = {each.elements for each in report.findings if each.rule == TRANSITION.rule}
    return [each for each in needed if each.elements in never]


def _with_time_outs(model: sym.SystemModel) -> list[sym.ClientPort]:
    clients = [each for service in channels(model, sym.ServiceChannel) for each in service.clients]
    return [each for each in clients if each.timeout]


@contextmanager
def _without_time_outs(model: sym.SystemModel) -> Iterator[None]:
    """Let no client give up meanwhile."""
    given = {client: (client.timeout, client.timedOut) for client in _with_time_outs(model)}
    try:
        for client in given:
            client.timeout = client.timedOut = None
        yield
    finally:
        for client, (timeout, told) in given.items():
            client.timeout, client.timedOut = timeout, told
