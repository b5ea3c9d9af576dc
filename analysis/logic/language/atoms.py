"""Atoms bound to a net: names resolved, and evaluated by definition."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

from dineros.analysis.logic.language.names import Names, resolved
from dineros.analysis.logic.language.syntax import (
    FALSE,
    OPERATORS,
    TRUE,
    And,
    Atom,
    Comparison,
    ComparisonOperator,
    Constant,
    Deadlock,
    Enabled,
    Fired,
    Formula,
    Name,
    Or,
    SignalTrue,
)
from dineros.analysis.nets.compiled import ArcTable, CompiledNet


@dataclass(frozen=True)
class Linear:
    """A weighted sum of tokens compared with a number: place -> factor, operator, bound."""

    factors: dict[int, int]
    operator: str
    bound: int


@dataclass(frozen=True)
class SomeEnabled:
    """At least one of these transitions is enabled."""

    transitions: frozenset[int]


@dataclass(frozen=True)
class SomeFired:
    """The step taken is one of these transitions."""

    transitions: frozenset[int]


@dataclass(frozen=True)
class NoneEnabled:
    """No transition is enabled."""


Condition = Linear | SomeEnabled | SomeFired | NoneEnabled
"""The condition of an atom on a marking and the step taken from it."""


@dataclass(frozen=True)
class Combined:
    """A boolean combination of other conditions on a marking.

    Attributes
    ----------
    program : tuple of int
        Postfix form: numbers of parts, and the negative codes of this class for operations.
    """

    parts: tuple[Condition, ...]
    program: tuple[int, ...]

    NOT: ClassVar[int] = -1
    AND: ClassVar[int] = -2
    OR: ClassVar[int] = -3
    SAME: ClassVar[int] = -4
    TRUE: ClassVar[int] = -5
    FALSE: ClassVar[int] = -6


@dataclass(frozen=True)
class Step:
    """A position of a run: a marking and the transition fired there; None: a deadlock, forever."""

    marking: tuple[int, ...]
    transition: int | None


class BoundAtoms:
    """The atoms of a formula as conditions on markings and steps of a net.

    Parameters
    ----------
    net : CompiledNet
    formula : Formula
    names : Names

    Raises
    ------
    FormulaError
        If a name is unknown; with its column.
    """

    def __init__(self, net: CompiledNet, formula: Formula, names: Names) -> None:
        self.net = net
        self.conditions: dict[Atom, Condition] = {
            part: _condition(part, names)
            for part in formula.subformulas()
            if isinstance(part, Atom) and not isinstance(part, Constant)
        }

    def is_true(self, atom: Atom, step: Step) -> bool:
        """Evaluate an atom by its definition, at a step of a run."""
        match self.conditions[atom]:
            case Linear(factors, symbol, bound):
                return OPERATORS[symbol](sum(k * step.marking[p] for p, k in factors.items()), bound)
            case SomeEnabled(transitions):
                return any(self.net.is_enabled(t, step.marking) for t in transitions)
            case SomeFired(transitions):
                return step.transition in transitions
            case NoneEnabled():
                return not any(self.net.is_enabled(t, step.marking) for t in range(len(self.net.transitions)))


def all_resolved(names: Names, wanted: Iterable[str]) -> list[int]:
    """Return the transitions of some names, each once."""
    return list(dict.fromkeys(t for name in wanted for t in names.transitions(name)))


def _condition(atom: Atom, names: Names) -> Condition:
    match atom:
        case Comparison(terms, symbol, bound):
            factors: dict[int, int] = {}
            for factor, name in terms:
                for place in resolved(names.places, name):
                    factors[place] = factors.get(place, 0) + factor
            return Linear({p: k for p, k in factors.items() if k}, symbol, bound)
        case SignalTrue(name):
            return Linear({resolved(names.signal, name): 1}, ">=", 1)
        case Enabled(name):
            return SomeEnabled(frozenset(resolved(names.transitions, name)))
        case Fired(name):
            return SomeFired(frozenset(resolved(names.transitions, name)))
        case Deadlock():
            return NoneEnabled()
    raise TypeError(f"unknown atom: {atom}")


def as_comparisons(net: CompiledNet, condition: Condition) -> Formula | None:
    """Return a condition as comparisons of tokens; None: it cannot be expressed."""
    match condition:
        case Linear(factors, symbol, bound) if factors:
            terms = tuple((factor, Name(net.places[p])) for p, factor in factors.items())
            return Comparison(terms, symbol, bound)  # type: ignore[arg-type]
        case SomeEnabled(transitions):
            some = tuple(_enabling(net, t) for t in sorted(transitions))
            return FALSE if not some else some[0] if len(some) == 1 else Or(some)
    return None


def _enabling(net: CompiledNet, transition: int) -> Formula:
    kinds: tuple[tuple[ComparisonOperator, ArcTable], ...] = ((">=", net.pre), ("<", net.inhibitor))
    rows = tuple(
        Comparison(((1, Name(net.places[place])),), operator, weight)
        for operator, table in kinds
        for place, weight in table.row(transition)
    )
    return TRUE if not rows else rows[0] if len(rows) == 1 else And(rows)
