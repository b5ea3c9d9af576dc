"""Certificates of a check with times: for conditions proved unreachable, and for stored properties."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.checks.overflow import Overflow
from dineros.analysis.evidence.certificate import BASE
from dineros.analysis.evidence.claims import Claim, file_name
from dineros.analysis.evidence.proving import Asked, Certificate
from dineros.analysis.evidence.timed_checker import timed_refutation
from dineros.analysis.evidence.timed_proving import classes_of, timed_certificate, timed_form
from dineros.analysis.logic.language.syntax import (
    Comparison,
    Deadlock,
    Fired,
    Formula,
    Globally,
    Name,
    Not,
    Or,
)
from dineros.analysis.model.queues import queues
from dineros.analysis.requirements.stored import VARIANTS
from dineros.analysis.requirements.stored import Asked as Stored
from dineros.analysis.timed.timed_subject import TimedSubject
from dineros.analysis.timed_checks.timed_checked import TimedChecked

Named = tuple[str, Certificate]


def timed_certificates_of(
    checked: TimedChecked, settings: Sequence[str], budget: Budget
) -> tuple[list[Named], Certificate | None]:
    """Return the certificates of a check with times, and a common one of all unreachable conditions.

    Parameters
    ----------
    settings : sequence of str
        Settings that changed the model.
    budget : Budget
        Budget for creating and checking them. Certificates not checked within it are left out.
    """
    budget = budget.begun()
    found: list[Named] = []
    everything = None
    try:
        claims = list(_claims(checked)) if checked.explored.is_complete else []
        if claims:
            classes = list(classes_of(checked.timed.timed, budget))
            everything = timed_form(
                _never(checked, Or(tuple(one.condition for one in claims)), settings), "holds", classes
            )
            if timed_refutation(everything, checked.timed, budget):
                claims, everything = [], None  # results that need priorities have no certificate
            # If no class fulfils any of the conditions, none fulfils a single one.
            found += [
                (one.name, timed_form(_never(checked, one.condition, settings), "holds", classes))
                for one in claims
            ]
        found += _properties(checked, settings, budget)
    except BudgetExceededError:
        pass
    return found, everything


def _never(checked: TimedChecked, goal: Formula, settings: Sequence[str]) -> Asked:
    return Asked(checked.timed, "ltl", str(Globally(Not(goal))), BASE, "weighted", settings)


def _claims(checked: TimedChecked) -> Iterator[Claim]:
    """Yield the conditions that are never fulfilled."""
    explored, names = checked.explored, checked.timed.net.transitions
    most = explored.markings.max(axis=0).tolist()
    more: list[Formula] = [
        Comparison(((1, Name(place)),), ">=", int(tokens) + 1)
        for place, tokens in zip(checked.timed.net.places, most, strict=True)
    ]
    yield Claim("bounded", Or(tuple(more)))
    overflows = {fault.rule for fault in Overflow.faults}
    losing = {found.elements for found in checked.report.findings if found.rule in overflows}
    fires = {names[t] for t in explored.ways}
    drops: set[str] = set()
    for queue in queues(checked.timed):
        drops.update(queue.drops)
        if queue.elements not in losing and fires.isdisjoint(queue.drops):
            fired: list[Formula] = [Fired(Name(drop)) for drop in queue.drops]
            yield Claim(file_name("no-overflow", *queue.elements), Or(tuple(fired)))
    for name in names:
        if name not in fires and name not in drops:
            yield Claim(file_name("dead", name), Fired(Name(name)))
    if not explored.ends and not checked.timed.timed.has_priorities:
        yield Claim("no-deadlock", Deadlock())


def _properties(checked: TimedChecked, settings: Sequence[str], budget: Budget) -> Iterator[Named]:
    """Yield the certificates of stored properties, if there are any."""
    for property, question, outcome in checked.answered:
        if not isinstance(question, Stored) or not isinstance(question.subject, TimedSubject):
            continue
        variant = VARIANTS[str(property.signals)]
        signals = BASE if variant == "none" else variant
        text = str(question.reading.formula)
        asked = Asked(question.subject, question.reading.logic, text, signals, "weighted", settings)
        raw = question.verdict(outcome)  # the double negation gives the answer to the question
        certificate = timed_certificate(asked, raw, budget)
        if certificate is not None:
            yield file_name("property", str(property.id)), certificate
