"""Which faults of a check with times are consequences: random runs of the mended model disprove them."""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget
from dineros.analysis.checks.unused import FAULTS, unused_parts
from dineros.analysis.consequences.folding import key_of
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.analysis.timed_checks.timed_walks import walk_in_time
from dineros.analysis.witnesses.findings import Finding
from dineros.metamodel import sym


def used_in_time(mended: sym.SystemModel, _: object, some: list[Finding], budget: Budget) -> list[Finding]:
    """Return which of some faults, that parts are never used, random runs of a mended model disprove."""
    subject = timed_base_subject(mended)
    walked = walk_in_time(subject.timed, budget)
    never = set(range(len(subject.net.transitions))) - walked.ways.keys()
    still = {key_of(finding) for finding in unused_parts(subject, never)}
    rules = {fault.rule for fault in FAULTS}
    return [each for each in some if each.rule in rules and key_of(each) not in still]
