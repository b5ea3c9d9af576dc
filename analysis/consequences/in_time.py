"""Which faults of a check with times are consequences: random runs of the corrected model disprove them."""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget
from dineros.analysis.consequences.used import disproved
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.analysis.timed_checks.timed_walks import walk_in_time
from dineros.analysis.witnesses.findings import Finding
from dineros.metamodel import sym


def used_in_time(fixed: sym.SystemModel, _: object, some: list[Finding], budget: Budget) -> list[Finding]:
    """Return which of some faults, that parts are never used, random runs of a corrected model disprove."""
    subject = timed_base_subject(fixed)
    return disproved(subject, walk_in_time(subject.timed, budget).ways, some)
