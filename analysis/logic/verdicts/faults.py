"""The point where a run violates a formula regardless of its continuation: the end of a finite witness.

A formula is rewritten step by step to the condition on the rest of the run. If nothing can satisfy it, the
beginning alone is a counterexample, and so is every fair run that continues it.

References
----------
F. Bacchus, F. Kabanza, *Using temporal logics to express search control knowledge for planning*, Artificial
Intelligence 116, 2000 (progression). O. Kupferman, M. Y. Vardi, *Model checking of safety properties*, Formal
Methods in System Design 19, 2001 (bad prefixes).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from dineros.analysis.logic.language.atoms import BoundAtoms, Step
from dineros.analysis.logic.language.names import Names
from dineros.analysis.logic.language.rewriting import simplified
from dineros.analysis.logic.language.syntax import (
    FALSE,
    TRUE,
    And,
    Atom,
    Constant,
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
from dineros.analysis.logic.verdicts.verdict import ReplayError, fired
from dineros.analysis.nets.compiled import CompiledNet

MOST_PARTS = 200
"""Size of the rewritten formula above which the end is not searched."""

_Truth = Callable[[Atom], bool | None]
"""The value of an atom; None: it may be either."""


def faulty_beginning(net: CompiledNet, formula: Formula, names: Names, firings: Sequence[int]) -> int | None:
    """Return the number of firings after which a run violates an LTL formula in any case; None: it need not.

    Raises
    ------
    ReplayError
        A transition is not enabled.
    """
    steps, last = fired(net, tuple(net.initial.tolist()), firings)
    left = simplified(formula)
    atoms = BoundAtoms(net, left, names)

    def truth(step: Step, has_fired: bool) -> _Truth:
        return lambda atom: atoms.is_true(atom, step) if has_fired or not isinstance(atom, Fired) else None

    for number, step in enumerate([*steps, Step(last, None)]):
        if _rest(left, truth(step, False)) == FALSE:
            return number
        if number == len(steps):
            return None
        left = _rest(left, truth(step, True))
        if left == FALSE:
            return number + 1
        if sum(1 for _ in left.subformulas()) > MOST_PARTS:
            return None
    return None


def check_fault(net: CompiledNet, formula: Formula, names: Names, firings: Sequence[int]) -> None:
    """Check that a run violates an LTL formula regardless of its continuation.

    Raises
    ------
    ReplayError
        It cannot be fired, or does not violate the formula.
    """
    if faulty_beginning(net, formula, names, firings) is None:
        raise ReplayError(f"what the witness begins with does not violate {formula}")


def _rest(formula: Formula, truth: _Truth) -> Formula:
    """Return the condition on the run after a step, for a formula in negation normal form.

    If an atom may have either value, it has the one that is better for the formula.
    """

    def value(part: Formula) -> Formula:
        return _rest(part, truth)

    match formula:
        case Constant():
            return formula
        case Atom():
            return FALSE if truth(formula) is False else TRUE
        case Not(operand):
            assert isinstance(operand, Atom)
            return FALSE if truth(operand) else TRUE
        case And(operands):
            return _joined(And, FALSE, TRUE, [value(each) for each in operands])
        case Or(operands):
            return _joined(Or, TRUE, FALSE, [value(each) for each in operands])
        case Next(operand):
            return operand
        case Globally(operand):
            return _joined(And, FALSE, TRUE, [value(operand), formula])
        case Finally(operand):
            return _joined(Or, TRUE, FALSE, [value(operand), formula])
        case Until(left, right):
            stays = _joined(And, FALSE, TRUE, [value(left), formula])
            return _joined(Or, TRUE, FALSE, [value(right), stays])
        case Release(left, right):
            ends = _joined(Or, TRUE, FALSE, [value(left), formula])
            return _joined(And, FALSE, TRUE, [value(right), ends])
    raise TypeError(f"no LTL formula in normal form: {formula}")


def _joined(kind: type[And | Or], decides: Formula, counts_nothing: Formula, parts: list[Formula]) -> Formula:
    """Return a conjunction or disjunction, flat, each part once."""
    flat = [each for part in parts for each in (part.operands if isinstance(part, kind) else [part])]
    if decides in flat:
        return decides
    kept = tuple(dict.fromkeys(part for part in flat if part != counts_nothing))
    return kept[0] if len(kept) == 1 else kind(kept) if kept else counts_nothing
