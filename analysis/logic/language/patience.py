"""Formulas of linear time that steps which are not observed cannot change."""

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
    """Whether steps that are not observed never change a formula's value, wherever they come.

    Conditions on the marking are the same before such a step and after it, and nothing observed is fired in
    it. So ``fired(t)`` may be waited for, and ``!fired(t)`` may be asked of every step, and no more.
    """
    return _kind(simplified(formula)) == "patient"


def _kind(formula: Formula) -> str | None:
    """Tell ``patient`` formulas, those that other steps make ``false``, and those they make ``true``."""
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
            # A condition may stand beside what such a step decides anyway.
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
