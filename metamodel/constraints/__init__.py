"""Everything that makes a model wrong or suspicious: constraints with guard, check, message and fix.

`validate` checks a net of any kind: plain nets, system models, run-time models and Petri-net models.
"""

from __future__ import annotations

from collections.abc import Iterable

from dineros.metamodel import pn
from dineros.metamodel.base import EObject
from dineros.metamodel.constraints.constraint import Constraint, Severity, Violation
from dineros.metamodel.constraints.families import BOUNDS, OTHERS
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.files.reading import collector_paused

__all__ = ["CONSTRAINTS", "Constraint", "Severity", "Violation", "all_constraints", "validate"]

CONSTRAINTS = (*BOUNDS, *OTHERS)
"""All constraints, by family."""


def all_constraints() -> list[Constraint]:
    """Return all constraints, by family, as `docs/constraints.md` lists them."""
    return list(CONSTRAINTS)


def validate(net: pn.Net) -> list[Violation]:
    """Check a model against all constraints.

    Walks over the model once. An element that lacks something the metamodel requires is checked no further.

    Returns
    -------
    list[Violation]
        In model order; empty for a valid model without anything suspicious.
    """
    with collector_paused():
        return _validate(Index(net))


def _validate(index: Index) -> list[Violation]:
    wrong = {element: found for element in index.elements if (found := _violations(element, BOUNDS, index))}
    index.incomplete = set(wrong)
    applicable: dict[type[EObject], list[Constraint]] = {}
    violations: list[Violation] = []
    for element in index.elements:
        if element in wrong:
            violations += wrong[element]
            continue
        kind = type(element)
        if kind not in applicable:
            applicable[kind] = [constraint for constraint in OTHERS if issubclass(kind, constraint.about)]
        violations += _violations(element, applicable[kind], index)
    return violations


def _violations(element: EObject, constraints: Iterable[Constraint], index: Index) -> list[Violation]:
    return [
        constraint.violation(element, found)
        for constraint in constraints
        if (constraint.guard is None or constraint.guard(element, index))
        and (found := constraint.check(element, index)) is not True
    ]
