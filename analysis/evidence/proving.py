"""Creates certificates of answers: the evidence in a form that other programs can check.

Evidence that the answering engine has found is reused.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import lcm
from typing import Any

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.answers.evidence import Evidence, Excluded, Inductive, Row, Together, Weighting
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.evidence.certificate import FORMAT, net_digest, sealed
from dineros.analysis.model.subject import Subject
from dineros.analysis.nets.compiled import CompiledNet
from dineros.metamodel.errors import DinerosError

Certificate = dict[str, Any]
Fact = dict[str, Any]

MOST_STEPS, MOST_FIRINGS = 3, 10_000
"""Limits of an induction without bounds: steps, and steps times transitions of the net."""


@dataclass(frozen=True)
class Asked:
    """A question, as named in a certificate.

    Attributes
    ----------
    kind : {"enabled", "marking", "ctl", "ltl"}
        Kind of the text: the name of a transition, a condition, a formula.
    signals, overflow : str
        Options with which a system model was flattened.
    settings : sequence of str
        Settings that changed the model.
    """

    subject: Subject
    kind: str
    text: str
    signals: str = "none"
    overflow: str = "weighted"
    settings: Sequence[str] = ()

    def certificate(self, format: str, answer: str, **proof: object) -> Certificate:
        """Return the certificate of an answer with a proof; it is not checked here."""
        return sealed(
            {
                "format": format,
                "model": str(self.subject.model.id),
                "settings": list(self.settings),
                "signals": self.signals,
                "overflow": self.overflow,
                "net": net_digest(self.subject),
                "question": {"kind": self.kind, "text": self.text},
                "answer": answer,
                **proof,
            }
        )


def proved(asked: Asked, budget: Budget = UNLIMITED) -> Outcome | None:
    """Answer a question by structure or induction; None: these do not decide it."""
    from dineros.analysis.evidence.checker import excluded
    from dineros.analysis.portfolio.asking import proof_against

    for answer in ("unreachable",) if asked.kind in ("enabled", "marking") else ("holds", "violated"):
        budget = budget.begun()
        try:
            goal = excluded(asked.kind, asked.text, answer)
            found = proof_against(asked.subject.net, goal, asked.subject.names, budget)
            return _inductive(asked, answer, budget) if found is None else replace(found, status=answer)
        except DinerosError:  # an invalid question, which the engine reports
            continue
    return None


def _inductive(asked: Asked, answer: str, budget: Budget) -> Outcome | None:
    """Let the checker decide whether few induction steps exclude a goal, even for unbounded places."""
    from dineros.analysis.proofs.induction import INDUCTION

    for depth in range(1, MOST_STEPS + 1):
        evidence = Inductive(depth, ())
        if budget.is_over or depth * len(asked.subject.net.transitions) > MOST_FIRINGS:
            break
        if certificate_of(asked, answer, evidence) is not None:
            return Outcome(answer, by=INDUCTION, evidence=evidence)
    return None


def certificate_of(asked: Asked, answer: str, evidence: Evidence | None) -> Certificate | None:
    """Return the certificate of an answer after checking it; None: the answer has other evidence."""
    from dineros.analysis.evidence.checker import refutation

    if evidence is None:
        return None
    net = asked.subject.net
    parts = evidence.parts if isinstance(evidence, Together) else (evidence,)
    never = [fact for part in parts for fact in _never(net, part)]
    # A marked trap is a clause of inequalities that firings preserve.
    traps = [trap for part in parts if isinstance(part, Excluded) for trap in part.traps]
    steps = max([min(1, len(traps)), *(part.depth for part in parts if isinstance(part, Inductive))])
    clauses = [[_named(net, ({p: 1}, 1)) for p in trap] for trap in traps]
    certificate = asked.certificate(FORMAT, answer, never=never, clauses=clauses, steps=steps)
    return None if refutation(certificate, asked.subject) else certificate


def _never(net: CompiledNet, evidence: Excluded | Inductive) -> Iterator[Fact]:
    """Yield the inequalities that are never fulfilled together, with their proofs."""
    if isinstance(evidence, Excluded):
        for case in evidence.cases:
            if any(terms for terms, _ in case.rows):
                yield _fact(net, case)
        return
    for place, (bound, weights) in enumerate(zip(evidence.bounds, evidence.proofs, strict=True)):
        yield _fact(net, Weighting.of_bound(place, bound, weights))
    for weights in evidence.weightings:
        total = sum(int(net.initial[p]) * weight for p, weight in weights.items())
        for sign in (1, -1):
            terms = {p: sign * weight for p, weight in weights.items()}
            exact = {p: Fraction(weight) for p, weight in terms.items()}
            yield _fact(net, Weighting(((terms, sign * total + 1),), exact, (Fraction(1),)))


def _fact(net: CompiledNet, case: Weighting) -> Fact:
    scale = lcm(*(number.denominator for number in (*case.weights.values(), *case.factors)))
    return {
        "rows": [_named(net, row) for row in case.rows],
        "factors": [int(factor * scale) for factor in case.factors],
        "weights": {net.places[p]: int(weight * scale) for p, weight in case.weights.items() if weight},
    }


def _named(net: CompiledNet, row: Row) -> Mapping[str, Any]:
    terms, least = row
    return {"sum": {net.places[p]: int(k) for p, k in terms.items() if k}, "least": int(least)}
