"""Formulas as immutable trees: marking expressions, LTL and CTL.

A path quantifier is a separate node (``AG f`` is ``ForAll(Globally(f))``), as in CTL*, so that both logics
share their temporal operators. `str` of a tree is text that parses to an equal tree.

References
----------
E. M. Clarke, E. A. Emerson, A. P. Sistla, *Automatic verification of finite-state concurrent systems using
temporal logic specifications*, TOPLAS 8(2), 1986 (CTL). S. Chaki, E. M. Clarke, J. Ouaknine, N. Sharygina, N.
Sinha, *State/event-based software model checking*, IFM 2004, LNCS 2999 (atoms on states and on the step
taken).
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar, Literal

ComparisonOperator = Literal["<=", ">=", "==", "!=", "<", ">"]
OPERATORS: dict[str, Callable[[float, float], bool]] = {
    "<=": operator.le,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
}
"""Functions of the comparison operators."""

PLAIN_NAME = re.compile(r"[^\W\d]\w*(?:\[\d+\])?(?:\.\w+(?:\[\d+\])?)*")
RESERVED = frozenset(
    ["true", "false", "deadlock", "and", "or", "not", "G", "F", "X", "U", "R", "W"]
    + ["enabled", "fired", "signal"]
    + [quantifier + operator for quantifier in "AE" for operator in "GFX"]
)


class Formula:
    """Any formula. Subclasses are immutable, hashable and compare by content.

    Attributes
    ----------
    operands : tuple of Formula
        The direct parts.
    """

    operands: tuple[Formula, ...]
    #: Computed once when a formula is made, from the hashes of its parts, so that no nesting exhausts the
    #: stack.
    _hash: int

    def subformulas(self) -> list[Formula]:
        """Return every part once, parts before the formulas that contain them; the formula itself last."""
        found: dict[Formula, None] = {}
        todo: list[tuple[Formula, bool]] = [(self, False)]
        while todo:
            part, is_done = todo.pop()
            if is_done:
                found[part] = None
            elif part not in found:
                todo.append((part, True))
                todo.extend((operand, False) for operand in reversed(part.operands))
        return list(found)

    def with_operands(self, operands: tuple[Formula, ...]) -> Formula:
        """Return the same operator with other operands."""
        if not operands:
            return self
        if isinstance(self, And | Or):
            return type(self)(operands)
        return type(self)(*operands)

    def replaced(self, new: Callable[[Formula], Formula | None]) -> Formula:
        """Return the formula with some parts replaced; None keeps the operator of a part."""
        made: dict[Formula, Formula] = {}
        for part in self.subformulas():
            made[part] = new(part) or part.with_operands(tuple(made[operand] for operand in part.operands))
        return made[self]


@dataclass(frozen=True)
class Name:
    """A name in a formula. `column` is its position (from 1, 0: unknown); names compare by their text."""

    text: str
    column: int = field(default=0, compare=False)

    def __str__(self) -> str:
        if PLAIN_NAME.fullmatch(self.text) and self.text not in RESERVED:
            return self.text
        return '"' + re.sub(r'(["\\])', r"\\\1", self.text) + '"'


class Atom(Formula):
    """A formula without parts; `operands` is empty."""

    @property
    def operands(self) -> tuple[Formula, ...]:  # type: ignore[override]
        """No parts."""
        return ()


@dataclass(frozen=True)
class Constant(Atom):
    """``true`` or ``false``."""

    value: bool

    def __str__(self) -> str:
        return "true" if self.value else "false"


TRUE = Constant(True)
FALSE = Constant(False)


@dataclass(frozen=True)
class Comparison(Atom):
    """``2*A - B >= 3``: a weighted sum of tokens compared with a number.

    Attributes
    ----------
    terms : tuple of (int, Name)
        Factors, none of them 0, and names, each at most once.
    """

    terms: tuple[tuple[int, Name], ...]
    operator: ComparisonOperator
    bound: int

    def __str__(self) -> str:
        text = ""
        for factor, name in self.terms:
            sign = (" - " if factor < 0 else " + ") if text else ("-" if factor < 0 else "")
            text += sign + (f"{abs(factor)}*" if abs(factor) != 1 else "") + str(name)
        return f"{text} {self.operator} {self.bound}"


@dataclass(frozen=True)
class Enabled(Atom):
    """``enabled(T)``: some transition of this name is enabled."""

    name: Name

    def __str__(self) -> str:
        return f"enabled({self.name})"


@dataclass(frozen=True)
class Fired(Atom):
    """``fired(T)``: the step taken next is a firing of a transition of this name."""

    name: Name

    def __str__(self) -> str:
        return f"fired({self.name})"


@dataclass(frozen=True)
class SignalTrue(Atom):
    """``signal(S)``: the input signal is true."""

    name: Name

    def __str__(self) -> str:
        return f"signal({self.name})"


@dataclass(frozen=True)
class Deadlock(Atom):
    """``deadlock``: no transition is enabled."""

    def __str__(self) -> str:
        return "deadlock"


@dataclass(frozen=True)
class _Unary(Formula):
    operand: Formula
    #: Position of the operator in the text, from 1; 0: there is no text.
    column: int = field(default=0, compare=False, kw_only=True)
    symbol: ClassVar[str]

    @property
    def operands(self) -> tuple[Formula, ...]:  # type: ignore[override]
        """The one operand."""
        return (self.operand,)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_hash", hash((type(self), self.operand)))

    def __hash__(self) -> int:
        return self._hash

    def __str__(self) -> str:
        space = "" if self.symbol in ("!", "A", "E") else " "
        if self.symbol in ("A", "E") and not isinstance(self.operand, Next | Finally | Globally):
            return f"{self.symbol}[{self.operand}]"
        return self.symbol + space + _grouped(self.operand)


@dataclass(frozen=True)
class _Binary(Formula):
    left: Formula
    right: Formula
    column: int = field(default=0, compare=False, kw_only=True)
    symbol: ClassVar[str]

    @property
    def operands(self) -> tuple[Formula, ...]:  # type: ignore[override]
        """Left and right operand."""
        return (self.left, self.right)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_hash", hash((type(self), self.left, self.right)))

    def __hash__(self) -> int:
        return self._hash

    def __str__(self) -> str:
        return f"{_grouped(self.left)} {self.symbol} {_grouped(self.right)}"


@dataclass(frozen=True)
class _Many(Formula):
    operands: tuple[Formula, ...]
    symbol: ClassVar[str]

    def __post_init__(self) -> None:
        object.__setattr__(self, "_hash", hash((type(self), self.operands)))

    def __hash__(self) -> int:
        return self._hash

    def __str__(self) -> str:
        return f" {self.symbol} ".join(_grouped(operand) for operand in self.operands)


def _grouped(formula: Formula) -> str:
    return f"({formula})" if isinstance(formula, _Binary | _Many | Comparison) else str(formula)


class Not(_Unary):
    """Negation."""

    symbol = "!"


class And(_Many):
    """Conjunction of any number of formulas."""

    symbol = "&"


class Or(_Many):
    """Disjunction of any number of formulas."""

    symbol = "|"


class Implies(_Binary):
    """Implication."""

    symbol = "->"


class Equivalent(_Binary):
    """Equivalence."""

    symbol = "<->"


class Next(_Unary):
    """``X f``: f holds after the next step."""

    symbol = "X"


class Finally(_Unary):
    """``F f``: f holds now or some time later."""

    symbol = "F"


class Globally(_Unary):
    """``G f``: f holds from now on."""

    symbol = "G"


class Until(_Binary):
    """``a U b``: b holds now or later, and a until then."""

    symbol = "U"


class Release(_Binary):
    """``a R b``: b holds up to and including the first moment of a; forever if there is none."""

    symbol = "R"


class WeakUntil(_Binary):
    """``a W b``: like `Until`, but b need not come if a holds forever."""

    symbol = "W"


class ForAll(_Unary):
    """``A f``: on all runs from here."""

    symbol = "A"


class Exists(_Unary):
    """``E f``: on some run from here."""

    symbol = "E"


TEMPORAL = (Next, Finally, Globally, Until, Release, WeakUntil)
QUANTIFIERS = (ForAll, Exists)
