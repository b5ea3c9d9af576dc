"""Conditions on markings as goals of a search: disjunctions of conjunctions of comparisons."""

from __future__ import annotations

from itertools import product

from dineros.analysis.explicit.goals import Comparison, Goal, Relation
from dineros.analysis.logic.language.atoms import BoundAtoms, Condition, Linear, NoneEnabled, SomeEnabled
from dineros.analysis.logic.language.names import Names
from dineros.analysis.logic.language.rewriting import simplified
from dineros.analysis.logic.language.syntax import And, Atom, Constant, Formula, Not, Or
from dineros.analysis.nets.compiled import CompiledNet

#: Maximum number of conjunctions of a condition for a direct search.
MOST_CONJUNCTIONS = 256

_RELATIONS: dict[str, Relation] = {"<": "<", "<=": "<=", "==": "=", "!=": "!=", ">=": ">=", ">": ">"}
_OPPOSITE: dict[Relation, Relation] = {"<": ">=", "<=": ">", "=": "!=", "!=": "=", ">=": "<", ">": "<="}

_Conjunction = tuple[Comparison, ...]


class _TooManyError(Exception):
    """There are too many conjunctions, or a deadlock is a part of one."""


def goals_of(net: CompiledNet, condition: Formula, names: Names) -> list[Goal] | None:
    """Return goals one of which is fulfilled exactly if a condition holds; empty if it is never true.

    None if there are too many.

    Raises
    ------
    FormulaError
        A name is unknown.
    """
    bound = BoundAtoms(net, condition, names)
    normal = simplified(condition)
    parts = normal.operands if isinstance(normal, Or) else (normal,)
    deadlock = [part for part in parts if isinstance(bound.conditions.get(part), NoneEnabled)]  # type: ignore[call-overload]
    conjunctions: list[_Conjunction] = []
    try:
        for part in parts:
            if part not in deadlock:
                conjunctions += _conjunctions(net, part, bound)
                _limit(len(conjunctions))
    except _TooManyError:
        return None
    goals = [Goal(conjunctions=tuple(conjunctions))] if conjunctions else []
    return [*goals, Goal.deadlock()] if deadlock else goals


def _limit(count: int) -> None:
    if count > MOST_CONJUNCTIONS:
        raise _TooManyError


def _conjunctions(net: CompiledNet, part: Formula, bound: BoundAtoms) -> list[_Conjunction]:
    match part:
        case Constant(value):
            return [()] if value else []
        case Atom():
            return _of_condition(net, bound.conditions[part], True)
        case Not(Atom() as atom):
            return _of_condition(net, bound.conditions[atom], False)
        case Or(operands):
            rows = [row for operand in operands for row in _conjunctions(net, operand, bound)]
            _limit(len(rows))
            return rows
        case And(operands):
            return _product([_conjunctions(net, operand, bound) for operand in operands])
    raise TypeError(f"no condition in normal form: {part}")


def _product(factors: list[list[_Conjunction]]) -> list[_Conjunction]:
    size = 1
    for factor in factors:
        size *= len(factor)
        _limit(size)
    return [tuple(c for row in rows for c in row) for rows in product(*factors)]


def _of_condition(net: CompiledNet, condition: Condition, is_positive: bool) -> list[_Conjunction]:
    match condition:
        case Linear(factors, symbol, number):
            relation = _RELATIONS[symbol]
            return [(Comparison(factors, relation if is_positive else _OPPOSITE[relation], number),)]
        case SomeEnabled(transitions):
            rows = Goal.enabled(net, *sorted(transitions)).alternatives(net)
            if is_positive:
                return rows
            # For each transition, one condition is violated.
            return _product([[(_negated(c),) for c in row] for row in rows])
        case NoneEnabled() if not is_positive:
            return Goal.enabled(net, *range(len(net.transitions))).alternatives(net)
    raise _TooManyError


def _negated(comparison: Comparison) -> Comparison:
    return comparison._replace(relation=_OPPOSITE[comparison.relation])
