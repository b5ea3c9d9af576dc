"""Normal forms of formulas: split into parts that are decided separately, with known values substituted.

A *part* is a state formula that begins with a path quantifier; ``A`` before an LTL path formula means "all
runs satisfy", as in CTL*.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from dineros.analysis.logic.graphs.predicates import is_condition
from dineros.analysis.logic.language.rewriting import DUAL, simplified
from dineros.analysis.logic.language.syntax import (
    FALSE,
    TEMPORAL,
    TRUE,
    And,
    Constant,
    Equivalent,
    Exists,
    Finally,
    ForAll,
    Formula,
    Globally,
    Implies,
    Next,
    Not,
    Or,
    Release,
    Until,
)


def of_linear(formula: Formula) -> Formula:
    """Return "all runs satisfy an LTL formula" as parts, in CTL if there is an equivalent."""
    wanted = simplified(formula)
    operands = wanted.operands if isinstance(wanted, And) else (wanted,)
    parts = [_branching(operand) or ForAll(operand) for operand in operands]
    return parts[0] if len(parts) == 1 else And(tuple(parts))


def _branching(formula: Formula) -> Formula | None:
    """Return a CTL equivalent of "all runs satisfy", if one is known, for a formula in normal form."""
    if is_condition(formula):
        return formula
    match formula:
        case And() | Or():
            return _each(formula, _branching)
        case Globally(operand) | Next(operand):
            inner = _branching(operand)
            return None if inner is None else ForAll(type(formula)(inner))
        case Release(left, right) if is_condition(left):
            inner = _branching(right)
            return None if inner is None else ForAll(Release(left, inner))
        case Finally(operand) if is_condition(operand):
            return ForAll(formula)
        case Until(left, right) if is_condition(left) and is_condition(right):
            return ForAll(formula)
    return None


def _each(formula: And | Or, made: Callable[[Formula], Formula | None]) -> Formula | None:
    """Apply a function to each operand; in a disjunction, at most one may be more than a condition."""
    others = [operand for operand in formula.operands if not is_condition(operand)]
    if isinstance(formula, Or) and len(others) > 1:
        return None
    found = [made(operand) for operand in formula.operands]
    return None if None in found else formula.with_operands(tuple(part for part in found if part is not None))


def is_linear(part: Formula) -> bool:
    """Whether a part is an LTL formula: its path formula is more than one operator on state formulas."""
    return isinstance(part, ForAll) and (
        not isinstance(part.operand, TEMPORAL) or any(_is_path(inner) for inner in part.operand.operands)
    )


def _is_path(formula: Formula) -> bool:
    """Whether a formula has a temporal operator without its path quantifier."""
    if isinstance(formula, TEMPORAL):
        return True
    if isinstance(formula, ForAll | Exists):
        return False
    return any(_is_path(operand) for operand in formula.operands)


def has_next(formula: Formula) -> bool:
    """Whether a formula counts steps."""
    return any(isinstance(part, Next) for part in formula.subformulas())


def folded(formula: Formula, known: Mapping[Formula, bool]) -> Formula:
    """Return an equivalent formula, given parts that are known to be constant in all markings."""
    made: dict[Formula, Formula] = {}
    for part in formula.subformulas():
        if part in known:
            made[part] = TRUE if known[part] else FALSE
        else:
            made[part] = _constant(part, tuple(made[operand] for operand in part.operands))
    return made[formula]


def _constant(part: Formula, operands: tuple[Formula, ...]) -> Formula:
    match part:
        case Not():
            return _negation(operands[0])
        case And():
            return _joined(And, operands, FALSE)
        case Or():
            return _joined(Or, operands, TRUE)
        case Implies():
            return _joined(Or, (_negation(operands[0]), operands[1]), TRUE)
        case Equivalent() if isinstance(operands[0], Constant):
            return operands[1] if operands[0].value else _negation(operands[1])
        case Equivalent() if isinstance(operands[1], Constant):
            return operands[0] if operands[1].value else _negation(operands[0])
        case Finally() | Globally() | Next() | ForAll() | Exists() if isinstance(operands[0], Constant):
            return operands[0]
        case ForAll() | Exists():
            return _quantified(type(part), operands[0])
        case Until():
            left, right = operands
            if isinstance(right, Constant) or left == FALSE:
                return right
            return Finally(right) if left == TRUE else Until(left, right)
        case Release():
            left, right = operands
            if isinstance(right, Constant) or left == TRUE:
                return right
            return Globally(right) if left == FALSE else Release(left, right)
    return part.with_operands(operands)


def _negation(formula: Formula) -> Formula:
    if isinstance(formula, Constant):
        return FALSE if formula.value else TRUE
    return formula.operand if isinstance(formula, Not) else Not(formula)


def _joined(
    kind: Callable[[tuple[Formula, ...]], Formula], operands: tuple[Formula, ...], strong: Formula
) -> Formula:
    if strong in operands:
        return strong
    parts: dict[Formula, None] = {}
    for operand in operands:
        if isinstance(operand, Constant):
            continue
        parts.update(dict.fromkeys(operand.operands if type(operand) is kind else [operand]))
    if not parts:
        return _negation(strong)
    return next(iter(parts)) if len(parts) == 1 else kind(tuple(parts))


def _quantified(quantifier: type[ForAll] | type[Exists], path: Formula) -> Formula:
    """Put a quantifier before a path formula, distributed over its operands where possible."""
    if not isinstance(path, TEMPORAL):
        if not _is_path(path):
            return path  # it is a state formula already
        return quantifier(path)
    (operand, *_) = path.operands
    if isinstance(path, Globally | Finally):
        can_reach = quantifier is Exists and isinstance(path, Finally)
        is_invariant = quantifier is ForAll and isinstance(path, Globally)
        if (can_reach or is_invariant) and is_condition(operand):
            operand = simplified(operand)
            if isinstance(operand, Constant):
                return operand
            path = type(path)(operand)
        if can_reach and isinstance(operand, Or):
            return _joined(Or, tuple(_quantified(Exists, Finally(one)) for one in operand.operands), TRUE)
        if is_invariant and isinstance(operand, And):
            return _joined(And, tuple(_quantified(ForAll, Globally(one)) for one in operand.operands), FALSE)
        if isinstance(operand, quantifier) and type(operand.operand) is type(path):
            return operand  # AG AG f, EF EF f, AF AF f, EG EG f
    return quantifier(path)


def initially(formula: Formula, known: Callable[[Formula], bool | None]) -> bool | None:
    """Evaluate a formula in the initial marking, as far as the known values decide it.

    Parameters
    ----------
    formula : Formula
        State formula, LTL path formula, or a combination; `folded`.
    known : callable
        Values of atoms and parts in the initial marking.
    """
    values: dict[Formula, bool | None] = {}
    for part in formula.subformulas():
        value = known(part)
        values[part] = (
            value if value is not None else _from_operands(part, [values[o] for o in part.operands])
        )
    return values[formula]


def _from_operands(part: Formula, values: list[bool | None]) -> bool | None:
    match part:
        case Constant(value):
            return value
        case Not():
            return None if values[0] is None else not values[0]
        case And():
            return False if False in values else None if None in values else True
        case Or():
            return True if True in values else None if None in values else False
        case Equivalent():
            return None if None in values else values[0] == values[1]
        case Finally():
            return True if values[0] else None
        case Globally():
            return False if values[0] is False else None
        case Until():
            left, right = values
            return True if right else False if left is False and right is False else None
        case Release():
            left, right = values
            return False if right is False else True if left and right else None
        case ForAll() | Exists():
            return values[0]
    return None


def linear_equal(part: Formula) -> tuple[Formula, bool] | None:
    """Return an LTL formula that decides a part, and the value of the part if all runs satisfy it."""
    universal = _linear(_negation_inside(part, True))
    if universal is not None:
        return universal, True
    negated = _linear(_negation_inside(part, False))
    return None if negated is None else (negated, False)


def _negation_inside(formula: Formula, positive: bool) -> Formula:
    """Return a formula of ``! & |`` and quantified operators, or its negation, with ``!`` at conditions."""
    if is_condition(formula):
        return simplified(formula if positive else Not(formula))
    match formula:
        case Not(operand):
            return _negation_inside(operand, not positive)
        case And(operands) | Or(operands):
            parts = tuple(_negation_inside(operand, positive) for operand in operands)
            return And(parts) if isinstance(formula, And) == positive else Or(parts)
        case ForAll(path) | Exists(path):
            quantifier = ForAll if isinstance(formula, ForAll) == positive else Exists
            operands = tuple(_negation_inside(operand, positive) for operand in path.operands)
            return quantifier(path.with_operands(operands) if positive else DUAL[type(path)](*operands))
    return Not(formula) if not positive else formula


def _linear(formula: Formula) -> Formula | None:
    """Return an LTL formula with an equivalent "all runs satisfy"; None: none is known."""
    if is_condition(formula):
        return formula
    match formula:
        case And() | Or():
            return _each(formula, _linear)
        case ForAll(Globally(operand) | Next(operand) as path):
            inner = _linear(operand)
            return None if inner is None else path.with_operands((inner,))
        case ForAll(Release(left, right)) if is_condition(left):
            inner = _linear(right)
            return None if inner is None else Release(left, inner)
        case ForAll(Finally() | Until() as path) if all(is_condition(part) for part in path.operands):
            return path
    return None


def parts_of(formula: Formula) -> list[Formula]:
    """Return the largest parts of a Boolean combination that begin with a quantifier."""
    if isinstance(formula, ForAll | Exists):
        return [formula]
    found = [part for operand in formula.operands for part in parts_of(operand)]
    return list(dict.fromkeys(found))


def goal_of(part: Formula) -> tuple[Formula, bool] | None:
    """Return the condition to search for in reachable markings, and the part's value if it is found."""
    match part:
        case Exists(Finally(operand)) if is_condition(operand):
            return operand, True
        case ForAll(Globally(operand)) if is_condition(operand):
            return simplified(Not(operand)), False
    return None


def everywhere(part: Formula) -> Formula | None:
    """Return f of ``AG f`` or ``EF f``, which one reachable marking may decide, if f is not a condition."""
    match part:
        case Exists(Finally(operand)) | ForAll(Globally(operand)) if not is_linear(part):
            return None if is_condition(operand) else operand
    return None
