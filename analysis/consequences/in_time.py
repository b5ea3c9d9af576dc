"""Which faults of a check with times are consequences: the corrected model is asked again with its times.

Random runs of it disprove that parts are never used. What else was found, such as lost messages, is gone if
the same question has an answer there and does not find it.
"""

from __future__ import annotations

from collections.abc import Collection

from dineros.analysis.answers.budget import Budget
from dineros.analysis.checks.question import Question
from dineros.analysis.consequences.cause_fixes import is_proved
from dineros.analysis.consequences.used import disproved
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.analysis.timed_checks.boundedness import TimedBoundedness
from dineros.analysis.timed_checks.timed_check import TIMED_QUESTIONS, check_timed
from dineros.analysis.timed_checks.timed_walks import walk_in_time
from dineros.analysis.witnesses.findings import Finding
from dineros.metamodel import sym

WALKS_SHARE = 0.3
"""Part of the time for random runs."""


def gone_in_time(
    fixed: sym.SystemModel,
    causes: Collection[tuple[str, tuple[str, ...]]],
    some: list[Finding],
    budget: Budget,
) -> list[Finding]:
    """Return which of some faults a corrected model with times does not have.

    Parameters
    ----------
    causes : collection of (str, tuple of str)
        Rules and elements of the causes that were repaired.
    """
    subject = timed_base_subject(fixed)
    used = disproved(subject, walk_in_time(subject.timed, budget.share(WALKS_SHARE)).ways, some)
    known = {id(each) for each in used}
    rest = [each for each in some if id(each) not in known]
    if not rest or not subject.timed.has_times:
        return used
    rules = {each.rule for each in rest} | {rule for rule, _ in causes}
    again = check_timed(fixed, budget, questions=_asking(rules))
    still = {(each.rule, each.elements) for each in again.findings if each.severity != "note"}
    if any(key in still or (key[0] in again.open_rules and not is_proved(key[0])) for key in causes):
        return used
    gone = [
        each for each in rest if each.rule not in again.open_rules and (each.rule, each.elements) not in still
    ]
    return [each for each in some if any(each is one for one in (*used, *gone))]


def _asking(rules: Collection[str]) -> list[Question]:
    """Return the questions with times that find faults of some rules, and what they rest on."""
    return [
        each
        for each in TIMED_QUESTIONS
        if isinstance(each, TimedBoundedness) or any(fault.rule in rules for fault in each.faults)
    ]
