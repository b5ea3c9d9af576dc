"""CTL's operators as fixpoints: which states satisfy a formula, over any representation of sets of states.

References
----------
E. M. Clarke, E. A. Emerson, A. P. Sistla, *Automatic verification of finite-state concurrent systems using
temporal logic specifications*, TOPLAS 8(2), 1986.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import reduce

from dineros.analysis.logic.ctl.state_sets import Run, States, StateSets
from dineros.analysis.logic.language.rewriting import DUAL
from dineros.analysis.logic.language.syntax import (
    TRUE,
    And,
    Atom,
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
    WeakUntil,
)


def basic(formula: Formula) -> Formula:
    """Return an equivalent CTL formula with only ``! & |`` and the operators ``EX``, ``EU``, ``EG``."""
    match formula:
        case Exists(path):
            return _some(type(path), [basic(operand) for operand in path.operands])
        case ForAll(path):
            return Not(_some_not(type(path), [basic(operand) for operand in path.operands]))
    parts = tuple(basic(operand) for operand in formula.operands)
    match formula:
        case Atom() | Not() | And() | Or():
            return formula.with_operands(parts)
        case Implies():
            return Or((Not(parts[0]), parts[1]))
        case Equivalent():
            return Or((And(parts), And((Not(parts[0]), Not(parts[1])))))
    raise TypeError(f"no CTL formula: {formula}")


def _some(kind: Callable[..., Formula], parts: Sequence[Formula]) -> Formula:
    """Some run satisfies the temporal operator."""
    if kind is Finally:
        return Exists(Until(TRUE, parts[0]))
    if kind is Release:
        left, right = parts
        return Or((Exists(Until(right, And((left, right)))), Exists(Globally(right))))
    if kind is WeakUntil:
        return Or((Exists(Until(*parts)), Exists(Globally(parts[0]))))
    return Exists(kind(*parts))


def _some_not(kind: type[Formula], parts: list[Formula]) -> Formula:
    """Some run violates the temporal operator."""
    no = [Not(part) for part in parts]
    if kind is WeakUntil:
        return Exists(Until(no[1], And((no[0], no[1]))))
    return _some(DUAL[kind], no)


def satisfying(formula: Formula, sets: StateSets[States]) -> dict[Formula, States]:
    """Return for each state formula in a `basic` CTL formula the set of states that satisfy it."""
    found: dict[Formula, States] = {}
    for part in formula.subformulas():
        match part:
            case Constant(value):
                found[part] = sets.constant(value)
            case Atom():
                found[part] = sets.atom(part)
            case Not(operand):
                found[part] = sets.complement(found[operand])
            case And(operands):
                found[part] = reduce(sets.intersection, [found[operand] for operand in operands])
            case Or(operands):
                found[part] = reduce(sets.union, [found[operand] for operand in operands])
            case Exists(Next(operand)):
                found[part] = sets.some_next(found[operand])
            case Exists(Until(left, right)):
                found[part] = sets.some_until(found[left], found[right])
            case Exists(Globally(operand)):
                found[part] = sets.some_globally(found[operand])
    return found


def initially(formula: Formula, sets: StateSets[States]) -> bool:
    """Whether the initial state satisfies a `basic` formula; only the needed operands are computed."""
    match formula:
        case Not(operand):
            return not initially(operand, sets)
        case And(operands) | Or(operands):
            # Infinite runs take the most work.
            values = (initially(operand, sets) for operand in sorted(operands, key=_has_globally))
            return all(values) if isinstance(formula, And) else any(values)
    return sets.initially(satisfying(formula, sets)[formula])


def _has_globally(formula: Formula) -> bool:
    return any(isinstance(part, Globally) for part in formula.subformulas())


def show(
    sets: StateSets[States], formula: Formula, value: bool, found: Mapping[Formula, States]
) -> tuple[Run, str]:
    """Return a run that shows the value of a `basic` formula in the initial state, and its description.

    There is a run only for existential operators that are true; for the others, the result is empty.
    """
    match formula:
        case Not(operand):
            return show(sets, operand, not value, found)
        case And(operands) | Or(operands):
            for operand in operands:
                # One operand is sufficient if it is true in a disjunction or false in a conjunction; else all
                # are needed.
                if sets.initially(found[operand]) == value:
                    shown = show(sets, operand, value, found)
                    if shown[1]:
                        return shown
        case Exists(path) if value:
            return sets.path(path, found), f"shows {formula}"
    return ((), ()), ""
