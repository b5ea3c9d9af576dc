"""Transitions for what follows a time-out, if with the times of a model no client ever gives up.

Such a transition never fires with times. It is a precaution, and no fault: without times it can fire, and if
no client gave up, it could not even then.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.stages import Share
from dineros.analysis.checks.boundedness import Boundedness
from dineros.analysis.checks.check import check
from dineros.analysis.checks.unused import TRANSITION, Use
from dineros.analysis.consequences.used import used_in_runs
from dineros.analysis.model.subject import Subject, base_subject
from dineros.analysis.witnesses.findings import Finding, Report, Unknown
from dineros.metamodel import sym
from dineros.metamodel.elements import channels

SHARE = Share(time=0.4)
"""Part of the time that is left for each question."""

WHY = "with these times: it follows a time-out, and no client gives up"

OPEN = "time ran out before it was known whether only a time-out leads there"


def about_precautions(subject: Subject, report: Report, budget: Budget) -> Report:
    """Return a report in which transitions that are precautions are notes.

    If time runs out before it is known whether a transition is one, the report says so instead of a finding.

    Parameters
    ----------
    subject
        The net with its times, which this leaves out.
    report
        What a check with times found.
    """
    careful, is_open = _precautions(subject, report.findings, budget)
    findings = [
        each.as_note(f" {WHY}") if each in careful else each
        for each in report.findings
        if each not in is_open
    ]
    unknown = [Unknown(f"whether it is a fault that {each.message}", OPEN) for each in is_open]
    return replace(
        report,
        findings=findings,
        unknown=[*report.unknown, *unknown],
        open_rules=report.open_rules | {each.rule for each in is_open},
    )


def _precautions(
    subject: Subject, some: Sequence[Finding], budget: Budget
) -> tuple[list[Finding], list[Finding]]:
    """Return which of some findings are precautions, and for which this is not known.

    A precaution never fires without times if no client gives up, and can fire if clients may give up.
    """
    model = subject.model
    dead = [each for each in some if each.rule == TRANSITION.rule]
    if not dead or not isinstance(model, sym.SystemModel) or not _with_time_outs(model):
        return [], []
    with _without_time_outs(model):
        never, is_open = _never(base_subject(model), dead, budget)
    used = used_in_runs(subject, never, SHARE.share(budget))
    rest = [each for each in never if each not in used]
    undecided = _never(subject, rest, budget)[1] if rest else []
    return used, [*is_open, *undecided]


def _never(subject: Subject, some: Sequence[Finding], budget: Budget) -> tuple[list[Finding], list[Finding]]:
    """Return the findings whose transitions never fire without times, and those for which this is open."""
    used = used_in_runs(subject, some, SHARE.share(budget))
    rest = [each for each in some if each not in used]
    if not rest:
        return [], []
    report = check(subject.model, SHARE.share(budget), questions=[Boundedness(), Use()])
    found = {each.elements for each in report.findings if each.rule == TRANSITION.rule}
    never = [each for each in rest if each.elements in found]
    is_open = TRANSITION.rule in report.open_rules
    return never, [each for each in rest if is_open and each.elements not in found]


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
