"""Claims of a check or a property file that no marking fulfils a condition, proved without a state space."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.evidence import Evidence, Excluded, Inductive, together
from dineros.analysis.answers.stages import fairly
from dineros.analysis.checks.overflow import Overflow
from dineros.analysis.evidence.certificate import BASE, subject_as
from dineros.analysis.evidence.proving import Asked, Certificate, certificate_of, proved
from dineros.analysis.logic.language.syntax import Comparison, Deadlock, Enabled, Formula, Name, Or
from dineros.analysis.model.queues import queues
from dineros.analysis.model.subject import Subject
from dineros.analysis.nets.bounds import place_bounds
from dineros.analysis.proofs.state_equation import StateEquation
from dineros.analysis.properties.property import GroupedNames, Property, PropertyAnswer
from dineros.analysis.witnesses.findings import Report
from dineros.metamodel import pn
from dineros.metamodel.errors import DinerosError


@dataclass(frozen=True)
class Claim:
    """The claim that no run fulfils a condition, or no marking of the net without signals.

    Attributes
    ----------
    name : str
        Name of the claim, usable as a file name.
    """

    name: str
    condition: Formula
    evidence: Evidence | None = None


def certificates_of(
    model: pn.Net, report: Report, settings: Sequence[str], budget: Budget
) -> tuple[list[tuple[str, Certificate]], Certificate | None]:
    """Return the certificates of conditions that a check proved unreachable, and a common certificate.

    Parameters
    ----------
    settings : sequence of str
        Settings that changed the model.
    """
    subject, budget = subject_as(model, BASE, "weighted"), budget.begun()
    claims = list(_claims(subject, report))
    found, proofs = [], list[Claim]()
    for claim, share in fairly(claims, budget):
        asked = _asked(subject, claim.condition, settings)
        evidence = claim.evidence
        if evidence is None and not share.is_over:
            answer = proved(asked, share)
            evidence = None if answer is None else answer.evidence
        certificate = certificate_of(asked, "unreachable", evidence)
        if certificate is not None:
            found.append((claim.name, certificate))
            proofs.append(Claim(claim.name, claim.condition, evidence))
    if not found:
        return [], None
    everything = _asked(subject, Or(tuple(claim.condition for claim in proofs)), settings)
    return found, certificate_of(everything, "unreachable", together(claim.evidence for claim in proofs))


def property_certificate(
    asked: Asked, one: Property, names: GroupedNames, answer: PropertyAnswer
) -> Certificate | None:
    """Return the certificate of the answer to a property; None: it has another kind of evidence.

    Parameters
    ----------
    asked : Asked
        The net; its kind and text are those of the property in a certificate.
    """
    evidence, said = answer.evidence, "holds" if answer.value is True else "violated"
    if answer.value is None or (one.kind != "bound" and evidence is None):
        return None
    if one.formula is not None:
        asked = replace(asked, kind=one.kind, text=str(names.ungrouped(one.formula)))
    elif one.kind == "bound":
        factors = Counter(place for name in one.places for place in names.places(name))
        case = StateEquation(asked.subject.net).excludes([(factors, int(answer.value) + 1)])
        evidence, said = None if case is None else Excluded((case,)), "unreachable"
        sums = Counter(Name(asked.subject.net.places[place]) for place in factors.elements())
        terms = tuple((factor, name) for name, factor in sums.items())
        more = Comparison(terms, ">=", int(answer.value) + 1)
        asked = replace(asked, kind="marking", text=str(more))
    else:
        asked, said = replace(asked, kind="enabled", text=answer.dead), "unreachable"
    try:
        return certificate_of(asked, said, evidence)
    except DinerosError:  # the answer is not only about markings
        return None


def _asked(subject: Subject, condition: Formula, settings: Sequence[str]) -> Asked:
    return Asked(subject, "marking", str(condition), BASE, "weighted", settings)


def _claims(subject: Subject, report: Report) -> Iterator[Claim]:
    """Yield the claims, except those that the check refuted."""
    faults = {finding.rule for finding in report.findings}
    overflows = {fault.rule for fault in Overflow.faults}
    losing = {finding.elements for finding in report.findings if finding.rule in overflows}
    if "unbounded" not in faults:
        yield from _bounded(subject)
    found = queues(subject)
    for queue in found:
        if queue.elements not in losing:
            yield Claim(file_name("no-overflow", *queue.elements), _any_enabled(queue.drops))
    drops = {drop for queue in found for drop in queue.drops}
    for name in (name for name in report.dead if name not in drops):
        yield Claim(file_name("dead", name), _any_enabled([name]))
    if "deadlock" not in faults:
        yield Claim("no-deadlock", Deadlock())


def _bounded(subject: Subject) -> Iterator[Claim]:
    """Yield the claim that no place exceeds its bound, if weightings prove all bounds."""
    found = place_bounds(subject.net)
    bounds = [bound for bound in found if bound is not None]
    if bounds and len(bounds) == len(found):
        more: list[Formula] = [
            Comparison(((1, Name(name)),), ">=", bound.value + 1)
            for name, bound in zip(subject.net.places, bounds, strict=True)
        ]
        evidence = Inductive(0, tuple(one.value for one in bounds), tuple(one.weights for one in bounds))
        yield Claim("bounded", Or(tuple(more)), evidence)


def _any_enabled(transitions: Sequence[str]) -> Formula:
    enabled: list[Formula] = [Enabled(Name(name)) for name in transitions]
    return enabled[0] if len(enabled) == 1 else Or(tuple(enabled))


def file_name(*words: str) -> str:
    """Return a safe file name for untrusted names."""
    return "-".join(re.sub(r"[^\w.]+", "_", word) for word in words)
