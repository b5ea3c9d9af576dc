"""LTL in negation normal form, simplified by equivalences.

The result uses constants, atoms, negated atoms, conjunction, disjunction, ``X F G U R`` only. Rules are
applied by the constructors below, bottom-up: propositional ones, pure eventuality and universality (Etessami
and Holzmann), syntactic implication (Somenzi and Bloem), and joining of equal temporal operators. Of two
operators that are dual to each other one has rules; the other is made of it by negation.

References
----------
K. Etessami, G. J. Holzmann, *Optimizing Buchi automata*, CONCUR 2000, LNCS 1877. F. Somenzi, R. Bloem,
*Efficient Buchi automata from LTL formulae*, CAV 2000, LNCS 1855.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from dineros.analysis.logic.language.syntax import (
    FALSE,
    TRUE,
    And,
    Atom,
    Constant,
    Equivalent,
    Finally,
    Formula,
    Globally,
    Implies,
    Next,
    Not,
    Or,
    Release,
    Until,
    WeakUntil,
)

DUAL: dict[type[Formula], Callable[..., Formula]] = {
    And: Or,
    Or: And,
    Finally: Globally,
    Globally: Finally,
    Until: Release,
    Release: Until,
    Next: Next,
}
"""For each operator, its dual: the negation of the operator applied to negated operands."""


def simplified(formula: Formula) -> Formula:
    """Return an equivalent formula in negation normal form, usually a smaller one."""
    for _ in range(10):
        smaller = _normal(formula, True)
        if smaller == formula:
            break
        formula = smaller
    return formula


def negated(formula: Formula) -> Formula:
    """Return the negation, simplified."""
    return simplified(Not(formula))


@lru_cache(maxsize=4096)
def _normal(formula: Formula, positive: bool) -> Formula:
    """Return the formula, or its negation unless `positive`, in normal form."""
    match formula:
        case Atom():
            return formula if positive else opposite(formula)
        case Not(operand):
            return _normal(operand, not positive)
        case Implies(left, right):
            return _normal(Or((Not(left), right)), positive)
        case Equivalent(left, right):
            other = right if positive else Not(right)
            return _normal(Or((And((left, other)), And((Not(left), Not(other))))), True)
        case WeakUntil(left, right):
            return _normal(Release(right, Or((left, right))), positive)
    if type(formula) not in DUAL:
        raise TypeError(f"no LTL formula: {formula}")
    parts = [_normal(operand, positive) for operand in formula.operands]
    return _MAKERS[type(formula) if positive else DUAL[type(formula)]](*parts)


def next_(operand: Formula) -> Formula:
    """Return ``X operand``, simplified."""
    if isinstance(operand, Constant) or (_is_eventual(operand) and _is_universal(operand)):
        return operand
    return Next(operand)


def finally_(operand: Formula) -> Formula:
    """Return ``F operand``, simplified."""
    if isinstance(operand, Constant) or _is_eventual(operand):
        return operand
    match operand:
        case Next(inner):
            return next_(finally_(inner))
        case Until(_, right):
            return finally_(right)
        case Or(operands):
            return disjunction(*map(finally_, operands))
        case And(operands):
            # F (a & G F b) = F a & G F b
            lasting = [part for part in operands if _is_eventual(part) and _is_universal(part)]
            if lasting:
                rest = conjunction(*(part for part in operands if part not in lasting))
                return conjunction(finally_(rest), *lasting)
    return Finally(operand)


def globally(operand: Formula) -> Formula:
    """Return ``G operand``, simplified."""
    return opposite(finally_(opposite(operand)))


def until(left: Formula, right: Formula) -> Formula:
    """Return ``left U right``, simplified."""
    if isinstance(right, Constant) or left == FALSE or implies(left, right) or _is_eventual(right):
        return right
    if left == TRUE or implies(opposite(left), right):
        return finally_(right)
    match left, right:
        case Next(a), Next(b):
            return next_(until(a, b))
        case _, Until(a, b) if implies(left, a):
            return until(a, b)
        case _, Finally(_):
            return right
    return Until(left, right)


def release(left: Formula, right: Formula) -> Formula:
    """Return ``left R right``, simplified."""
    return opposite(until(opposite(left), opposite(right)))


def conjunction(*operands: Formula) -> Formula:
    """Return the conjunction, flattened, without implied parts, equal temporal operators joined."""
    flat = [
        part for operand in operands for part in (operand.operands if isinstance(operand, And) else [operand])
    ]
    parts = sorted(dict.fromkeys(flat), key=str)
    if FALSE in parts or any(opposite(part) in parts for part in parts):
        return FALSE
    parts = _without_implied([part for part in parts if part != TRUE])
    if any(implies(part, opposite(other)) for part in parts for other in parts):
        return FALSE
    steps = [part.operand for part in parts if isinstance(part, Next)]
    if len(steps) > 1:
        others = [part for part in parts if not isinstance(part, Next)]
        return conjunction(*others, next_(conjunction(*steps)))
    # F G a & F G b = F G (a & b)
    ends = [part for part in parts if isinstance(part, Finally) and isinstance(part.operand, Globally)]
    if len(ends) > 1:
        others = [part for part in parts if part not in ends]
        inner = conjunction(*(part.operand.operands[0] for part in ends))
        return conjunction(*others, finally_(globally(inner)))
    return _combined(And, parts) if parts else TRUE


def disjunction(*operands: Formula) -> Formula:
    """Return the disjunction, flattened, without parts implying others, equal temporal operators joined."""
    return opposite(conjunction(*map(opposite, operands)))


_MAKERS: dict[Callable[..., Formula], Callable[..., Formula]] = {
    And: conjunction,
    Or: disjunction,
    Next: next_,
    Finally: finally_,
    Globally: globally,
    Until: until,
    Release: release,
}


@lru_cache(maxsize=8192)
def opposite(formula: Formula) -> Formula:
    """Return the negation of a formula in normal form, pushed to the atoms and not simplified."""
    match formula:
        case Constant(value):
            return FALSE if value else TRUE
        case Not(operand):
            return operand
        case Atom():
            return Not(formula)
    operands = [opposite(operand) for operand in formula.operands]
    dual = DUAL[type(formula)]
    return _combined(dual, operands) if dual in (And, Or) else dual(*operands)


@lru_cache(maxsize=65536)
def implies(a: Formula, b: Formula) -> bool:
    """Return whether a simple syntactic check of two formulas in normal form shows an implication."""
    if a in (b, FALSE) or b == TRUE:
        return True
    if isinstance(a, Or):
        return all(implies(part, b) for part in a.operands)
    if isinstance(b, And):
        return all(implies(a, part) for part in b.operands)
    return _implies_by_left(a, b) or _implies_by_right(a, b) or _implies_by_both(a, b)


def _implies_by_left(a: Formula, b: Formula) -> bool:
    match a:
        case And(operands):
            return any(implies(part, b) for part in operands)
        case Globally(operand):
            return implies(operand, b)
        case Until(left, right):
            return implies(left, b) and implies(right, b)
        case Release(_, right):
            return implies(right, b)
        case Finally(operand):
            # Sound for b that true runs into from the past: F F c.
            return _is_eventual(b) and implies(operand, b)
    return False


def _implies_by_right(a: Formula, b: Formula) -> bool:
    match b:
        case Or(operands):
            return any(implies(a, part) for part in operands)
        case Finally(operand):
            return implies(a, operand)
        case Until(_, right):
            return implies(a, right)
        case Release(left, right):
            return implies(a, left) and implies(a, right)
        case Globally(operand):
            return _is_universal(a) and implies(a, operand)
    return False


def _implies_by_both(a: Formula, b: Formula) -> bool:
    match a, b:
        case (Next(x), Next(y)) | (Finally(x), Finally(y)) | (Globally(x), Globally(y)):
            return implies(x, y)
        case (Until(x, y), Until(z, w)) | (Release(x, y), Release(z, w)):
            return implies(x, z) and implies(y, w)
        case Until(_, y), Finally(w):
            return implies(y, w)
        case Globally(y), Release(_, w):
            return implies(y, w)
    return False


@lru_cache(maxsize=8192)
def _is_eventual(formula: Formula) -> bool:
    """Pure eventuality: true of a word whenever it is true of some suffix."""
    match formula:
        case Constant() | Finally():
            return True
        case And(operands) | Or(operands):
            return all(_is_eventual(part) for part in operands)
        case Until(left, right):
            return left == TRUE or _is_eventual(right)
        case Release(left, right):
            return _is_eventual(left) and _is_eventual(right)
        case Next(operand) | Globally(operand):
            return _is_eventual(operand)
    return False


def _is_universal(formula: Formula) -> bool:
    """Pure universality: true of every suffix whenever it is true of the word."""
    return _is_eventual(opposite(formula))


def _without_implied(parts: list[Formula]) -> list[Formula]:
    kept: list[Formula] = []
    for i, part in enumerate(parts):
        # Of two parts that imply each other, the later one is kept.
        if not any(
            implies(other, part) and (j > i or not implies(part, other))
            for j, other in enumerate(parts)
            if j != i
        ):
            kept.append(part)
    return kept


def _combined(kind: Callable[..., Formula], parts: list[Formula]) -> Formula:
    return parts[0] if len(parts) == 1 else kind(tuple(sorted(parts, key=str)))
