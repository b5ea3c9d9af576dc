"""Conditions on markings, evaluated for many markings at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.logic.language.atoms import Condition, Linear, NoneEnabled, SomeEnabled
from dineros.analysis.logic.language.syntax import (
    OPERATORS,
    And,
    Atom,
    Constant,
    Deadlock,
    Equivalent,
    Formula,
    Implies,
    Not,
    Or,
)
from dineros.analysis.nets.compiled import CompiledNet

Flags = NDArray[np.bool_]
Int64Array = NDArray[np.int64]

_BOOLEAN = (Constant, Not, And, Or, Implies, Equivalent)


class Markings(Protocol):
    """Many markings."""

    net: CompiledNet
    size: int

    def tokens(self, place: int) -> Int64Array:
        """Return the tokens of a place in each marking."""

    def at_least(self, place: int, weight: int) -> Flags:
        """Return the markings in which a place has at least this number of tokens."""

    def deadlocks(self) -> Flags:
        """Return the markings in which no transition is enabled."""


class MarkingMatrix:
    """Markings as the rows of a matrix.

    Parameters
    ----------
    rows : int64 array, shape (markings, places)
    """

    def __init__(self, net: CompiledNet, rows: Int64Array) -> None:
        self.net, self.rows, self.size = net, rows, len(rows)

    def tokens(self, place: int) -> Int64Array:
        """Return the tokens of a place in each marking."""
        column: Int64Array = self.rows[:, place]
        return column

    def at_least(self, place: int, weight: int) -> Flags:
        """Return the markings in which a place has at least this number of tokens."""
        flags: Flags = self.rows[:, place] >= weight
        return flags

    def deadlocks(self) -> Flags:
        """Return the markings in which no transition is enabled."""
        return ~any_enabled(self, range(len(self.net.transitions)))


@lru_cache(maxsize=1 << 16)
def is_condition(formula: Formula) -> bool:
    """Whether a formula is about one marking: it has no temporal operator and no `fired` atom."""
    return all(
        isinstance(part, _BOOLEAN) or (isinstance(part, Atom) and type(part).__name__ != "Fired")
        for part in formula.subformulas()
    )


def enabled(markings: Markings, transition: int) -> Flags:
    """Return the markings in which a transition is enabled."""
    net = markings.net
    result = np.ones(markings.size, dtype=np.bool_)
    for place, weight in net.pre.row(transition):
        result &= markings.at_least(place, weight)
    for place, weight in net.inhibitor.row(transition):
        result &= ~markings.at_least(place, weight)
    return result


def total(markings: Markings, factors: Mapping[int, int]) -> Int64Array:
    """Return a weighted sum of tokens in each marking."""
    result = np.zeros(markings.size, dtype=np.int64)
    for place, factor in factors.items():
        result += markings.tokens(place) if factor == 1 else factor * markings.tokens(place)
    return result


def holds(markings: Markings, condition: Condition) -> Flags:
    """Return the markings in which a condition holds."""
    match condition:
        case Linear(factors, symbol, bound):
            return np.asarray(OPERATORS[symbol](total(markings, factors), bound))  # type: ignore[arg-type]
        case SomeEnabled(transitions):
            return any_enabled(markings, sorted(transitions))
        case NoneEnabled():
            return markings.deadlocks()
    raise TypeError(f"no condition on markings: {condition}")


def any_enabled(markings: Markings, transitions: Iterable[int]) -> Flags:
    """Return the markings in which at least one of these transitions is enabled."""
    result = np.zeros(markings.size, dtype=np.bool_)
    for transition in transitions:
        result |= enabled(markings, transition)
        if result.all():
            break
    return result


def satisfied(markings: Markings, formula: Formula, conditions: Mapping[Atom, Condition]) -> Flags:
    """Return the markings in which a formula without temporal operators holds."""

    def evaluate(atom: Atom) -> Flags:
        return holds(markings, NoneEnabled() if isinstance(atom, Deadlock) else conditions[atom])

    return combination(formula, evaluate, markings.size)


def combination(formula: Formula, evaluate: Callable[[Atom], Flags], size: int) -> Flags:
    """Return where a boolean combination of atoms is true, given where each atom is.

    Raises
    ------
    TypeError
        There is a temporal operator.
    """
    found: dict[Formula, Flags] = {}
    for part in formula.subformulas():
        rows = [found[operand] for operand in part.operands]
        match part:
            case Constant(value):
                found[part] = np.full(size, value)
            case Atom():
                found[part] = evaluate(part)
            case Not():
                found[part] = ~rows[0]
            case And():
                found[part] = np.logical_and.reduce(rows)
            case Or():
                found[part] = np.logical_or.reduce(rows)
            case Implies():
                found[part] = ~rows[0] | rows[1]
            case Equivalent():
                found[part] = rows[0] == rows[1]
            case _:
                raise TypeError(f"no condition on a marking: {part}")
    return found[formula]
