"""Which faults of a check with times are consequences: the corrected model is asked again with its times.

Random runs of it disprove that parts are never used. Another finding, such as lost messages, is absent if the
same question has an answer there and does not report it.
"""

from __future__ import annotations

from collections.abc import Collection

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.stages import Share
from dineros.analysis.checks.question import finding_rules
from dineros.analysis.consequences.cause_fixes import is_proved
from dineros.analysis.consequences.gone import Key, faults_of, gone_from, is_in
from dineros.analysis.consequences.used import disproved
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.analysis.timed_checks.timed_check import TIMED_QUESTIONS, check_timed
from dineros.analysis.timed_checks.timed_walks import walk_in_time
from dineros.analysis.witnesses.findings import Finding
from dineros.metamodel import sym

WALKS = Share(time=0.3)
"""Part of the time for random runs."""


def gone_in_time(
    fixed: sym.SystemModel,
    causes: Collection[Key],
    some: list[Finding],
    budget: Budget,
) -> list[Finding]:
    """Return which of some faults a corrected model with times does not have."""
    subject = timed_base_subject(fixed)
    used = disproved(subject, walk_in_time(subject.timed, WALKS.share(budget)).ways, some)
    rest = [each for each in some if not is_in(each, used)]
    if not rest or not subject.timed.has_times:
        return used
    rules = {each.rule for each in rest} | {rule for rule, _ in causes}
    again = check_timed(fixed, budget, finding_rules(rules, TIMED_QUESTIONS))
    still = faults_of(again)
    if any(key in still or (key[0] in again.open_rules and not is_proved(key[0])) for key in causes):
        return used
    return gone_from(again, some, used)
