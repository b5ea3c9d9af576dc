"""LTL formulas whose values unobserved steps cannot change."""

from __future__ import annotations

from dineros.analysis.logic.language.rewriting import opposite, simplified
from dineros.analysis.logic.language.syntax import (
    And,
    Finally,
    Fired,
    Formula,
    Globally,
    Next,
    Not,
    Or,
    Release,
    Until,
)


def is_patient(formula: Formula) -> bool:
    """Whether unobserved steps never change a formula's value, wherever they are inserted.

    Conditions on the marking are the same before and after such a step, and it fires no observed transition.
    So a formula may wait for ``fired(t)``, or require ``!fired(t)`` at every step, but nothing else.
    """
    return _kind(simplified(formula)) == "patient"


def _kind(formula: Formula) -> str | None:
    """Classify formulas: ``patient``, or made ``false`` or ``true`` by unobserved steps."""
    match formula:
        case Fired():
            return "false"
        case Not(Fired()):
            return "true"
        case And(operands) | Or(operands):
            kinds = {_kind(operand) for operand in operands}
            if None in kinds or {"true", "false"} <= kinds:
                return None
            if kinds == {"patient"}:
                return "patient"
            decisive = "false" if isinstance(formula, And) else "true"
            # A condition may be combined with a part that such a step decides anyway.
            return decisive if decisive in kinds else (kinds.pop() if len(kinds) == 1 else None)
        case Finally(operand):
            return "patient" if _kind(operand) in ("patient", "false") else None
        case Until(left, right):
            is_so = _kind(left) in ("patient", "true") and _kind(right) in ("patient", "false")
            return "patient" if is_so else None
        case Globally() | Release():
            return _kind(opposite(formula))
        case Next():
            return None
    return "patient" if all(not isinstance(part, Fired | Next) for part in formula.subformulas()) else None
