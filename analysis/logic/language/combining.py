"""Combines Boolean combinations of conditions on a marking, so that an automaton has one atom for each.

An automaton would expand ``G !(a & (b | c) & ...)`` to a disjunction of possibly exponentially many
conjunctions; the kernels evaluate it directly.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce

from dineros.analysis.logic.language.atoms import Combined, Condition
from dineros.analysis.logic.language.syntax import (
    And,
    Atom,
    Constant,
    Equivalent,
    Fired,
    Formula,
    Implies,
    Not,
    Or,
)

MOST_FREE = 4
"""Maximum number of atoms of a combination that the automaton gets separately, to detect exclusions."""

_BOOLEAN = (Not, And, Or, Implies, Equivalent)


@dataclass(frozen=True)
class Combination(Atom):
    """A boolean combination of conditions on a marking, to be evaluated as a whole."""

    formula: Formula

    def __str__(self) -> str:
        return f"({self.formula})"


def combined(formula: Formula) -> Formula:
    """Return an equivalent formula whose largest boolean combinations of many conditions are single atoms."""
    made: dict[Formula, Formula] = {}
    atoms: dict[Formula, frozenset[Atom] | None] = {}  # of a condition on the marking; None for others
    for part in formula.subformulas():
        atoms[part] = _atoms_of(part, atoms)
        if atoms[part] is not None or not part.operands:
            made[part] = part
        elif isinstance(part, And | Or):
            made[part] = part.with_operands(_operands(part, atoms, made))
        else:
            made[part] = part.with_operands(
                tuple(_as_atom(operand, atoms, made) for operand in part.operands)
            )
    return _as_atom(formula, atoms, made)


def condition_of(atom: Atom, conditions: Mapping[Atom, Condition]) -> Condition | Combined:
    """Return the condition of an atom of a `combined` formula, from the conditions of its parts."""
    if not isinstance(atom, Combination):
        return conditions[atom]
    parts = [part for part in atom.formula.subformulas() if isinstance(part, Atom)]
    index = {part: number for number, part in enumerate(p for p in parts if not isinstance(p, Constant))}
    return Combined(tuple(conditions[part] for part in index), _program(atom.formula, index))


def _atoms_of(part: Formula, atoms: Mapping[Formula, frozenset[Atom] | None]) -> frozenset[Atom] | None:
    if isinstance(part, Atom):
        return None if isinstance(part, Fired) else frozenset(() if isinstance(part, Constant) else [part])
    inner = [atoms[operand] for operand in part.operands]
    if not isinstance(part, _BOOLEAN) or None in inner:
        return None
    return frozenset().union(*(found for found in inner if found is not None))


def _operands(
    part: And | Or, atoms: Mapping[Formula, frozenset[Atom] | None], made: Mapping[Formula, Formula]
) -> tuple[Formula, ...]:
    """Combine the conditions on the marking among the operands."""
    conditions = [operand for operand in part.operands if atoms[operand] is not None]
    others = [made[operand] for operand in part.operands if atoms[operand] is None]
    many = frozenset[Atom]().union(*(atoms[operand] or () for operand in conditions))
    if len(many) <= MOST_FREE:
        return (*conditions, *others)
    return (Combination(part.with_operands(tuple(conditions))), *others)


def _as_atom(
    part: Formula, atoms: Mapping[Formula, frozenset[Atom] | None], made: Mapping[Formula, Formula]
) -> Formula:
    found = atoms[part]
    return Combination(part) if found is not None and len(found) > MOST_FREE else made[part]


def _program(formula: Formula, index: Mapping[Atom, int]) -> tuple[int, ...]:
    """Return a formula in postfix form, without recursion and with shared parts duplicated."""
    code: list[int] = []
    todo: list[Formula | int] = [formula]
    while todo:
        part = todo.pop()
        if isinstance(part, int):
            code.append(part)
            continue
        match part:
            case Constant(value):
                code.append(Combined.TRUE if value else Combined.FALSE)
            case Atom():
                code.append(index[part])
            case Not(operand):
                todo += [Combined.NOT, operand]
            case And(operands):
                todo += _joined(Combined.AND, operands)
            case Or(operands):
                todo += _joined(Combined.OR, operands)
            case Implies(left, right):
                todo += [Combined.OR, right, Combined.NOT, left]
            case Equivalent(left, right):
                todo += [Combined.SAME, right, left]
    return tuple(code)


def _joined(operation: int, operands: Sequence[Formula]) -> list[Formula | int]:
    """Operands in the order they are taken from the end of a list, joined as they come."""
    first, *others = operands
    return reduce(lambda code, operand: [operation, operand, *code], others, [first])
