"""Boolean expressions over signals: an immutable tree that prints as text its parser reads back.

>>> str(And((Signal("Sensor"), Not(Or((Signal("Danger"), Signal("lost link")))))))
'Sensor & !(Danger | "lost link")'
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

KEYWORDS = frozenset({"and", "or", "not", "true", "false"})
SignalSetting = bool | str
"""What a signal can be: true or false, or one of the values that it has, by name."""

Valuation = Mapping[Any, SignalSetting | int]
"""What an expression asks about, such as the name of a signal -> its value."""

Atom = tuple[str, str | None]
"""The name of a signal, and the value that it is compared with; None: it is true or false."""

_PLAIN_NAME = re.compile(r"\w+(?:[.-]+\w+)*")


@dataclass(frozen=True)
class Expression:
    """A boolean expression; `depth` is the number of operators on its longest branch."""

    binding: ClassVar[int]
    depth: int = field(init=False, repr=False, compare=False, default=0)

    @property
    def operands(self) -> tuple[Expression, ...]:
        """The expressions it is made of, from left to right."""
        return ()

    def __post_init__(self) -> None:
        deepest = max((operand.depth for operand in self.operands), default=-1)
        object.__setattr__(self, "depth", deepest + 1)

    def evaluate(self, values: Valuation) -> bool:
        """Return the truth value under an assignment of all that is asked; KeyError for what is missing."""
        raise NotImplementedError

    def _inside(self, binding: int) -> str:
        """Print as an operand of an operator that binds as strongly as `binding`."""
        return str(self) if self.binding > binding else f"({self})"


@dataclass(frozen=True)
class Signal(Expression):
    """The value of a signal."""

    binding: ClassVar[int] = 6
    name: str

    def evaluate(self, values: Valuation) -> bool:  # noqa: D102
        return values[self.name] is True

    def __str__(self) -> str:
        return quoted(self.name)


@dataclass(frozen=True)
class SignalIs(Expression):
    """Whether a signal has one of its values."""

    binding: ClassVar[int] = 6
    name: str
    value: str

    def evaluate(self, values: Valuation) -> bool:  # noqa: D102
        return values[self.name] == self.value

    def __str__(self) -> str:
        return f"{quoted(self.name)} = '{self.value}'"


@dataclass(frozen=True)
class Constant(Expression):
    """`true` or `false`."""

    binding: ClassVar[int] = 6
    value: bool

    def evaluate(self, values: Valuation) -> bool:  # noqa: D102
        return self.value

    def __str__(self) -> str:
        return "true" if self.value else "false"


@dataclass(frozen=True)
class Not(Expression):
    """Negation."""

    binding: ClassVar[int] = 5
    operand: Expression

    @property
    def operands(self) -> tuple[Expression, ...]:  # noqa: D102
        return (self.operand,)

    def evaluate(self, values: Valuation) -> bool:  # noqa: D102
        return not self.operand.evaluate(values)

    def __str__(self) -> str:
        if isinstance(self.operand, SignalIs):
            return f"{quoted(self.operand.name)} <> '{self.operand.value}'"
        return f"!{self.operand._inside(self.binding - 1)}"


@dataclass(frozen=True)
class _Chain(Expression):
    """Two or more expressions, joined by the same operator."""

    sign: ClassVar[str]
    parts: tuple[Expression, ...]

    @property
    def operands(self) -> tuple[Expression, ...]:
        return self.parts

    def __str__(self) -> str:
        return f" {self.sign} ".join(part._inside(self.binding) for part in self.parts)


@dataclass(frozen=True)
class And(_Chain):
    """Conjunction of two or more expressions."""

    binding: ClassVar[int] = 4
    sign: ClassVar[str] = "&"

    def evaluate(self, values: Valuation) -> bool:  # noqa: D102
        return all(part.evaluate(values) for part in self.parts)


@dataclass(frozen=True)
class Or(_Chain):
    """Disjunction of two or more expressions."""

    binding: ClassVar[int] = 3
    sign: ClassVar[str] = "|"

    def evaluate(self, values: Valuation) -> bool:  # noqa: D102
        return any(part.evaluate(values) for part in self.parts)


@dataclass(frozen=True)
class Implies(Expression):
    """Implication; a chain groups to the right."""

    binding: ClassVar[int] = 2
    premise: Expression
    conclusion: Expression

    @property
    def operands(self) -> tuple[Expression, ...]:  # noqa: D102
        return (self.premise, self.conclusion)

    def evaluate(self, values: Valuation) -> bool:  # noqa: D102
        return not self.premise.evaluate(values) or self.conclusion.evaluate(values)

    def __str__(self) -> str:
        return f"{self.premise._inside(self.binding)} -> {self.conclusion._inside(self.binding - 1)}"


@dataclass(frozen=True)
class Equivalent(Expression):
    """Equivalence; a chain groups to the left."""

    binding: ClassVar[int] = 1
    left: Expression
    right: Expression

    @property
    def operands(self) -> tuple[Expression, ...]:  # noqa: D102
        return (self.left, self.right)

    def evaluate(self, values: Valuation) -> bool:  # noqa: D102
        return self.left.evaluate(values) == self.right.evaluate(values)

    def __str__(self) -> str:
        return f"{self.left._inside(self.binding - 1)} <-> {self.right._inside(self.binding)}"


def quoted(name: str) -> str:
    """Return a signal's name as the grammar reads it: in quotes where it is not a plain word."""
    if _PLAIN_NAME.fullmatch(name) and name not in KEYWORDS:
        return name
    escaped = name.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


WORDS = re.compile(r"""'[^']*'|"(?:[^"\\]|\\["\\])*"|\w+(?:[.-]+\w+)*""")
"""Names, keywords and values in the text of a clause, those in quotes with them."""


def unquoted(word: str) -> str:
    """Return the name that a word of a clause is, without its quotes."""
    return re.sub(r"\\(.)", r"\1", word[1:-1]) if word[0] == '"' else word


def atoms_of(expression: Expression) -> Iterator[Atom]:
    """Yield what an expression asks of signals from left to right, as often as it does."""
    stack = [expression]
    while stack:
        part = stack.pop()
        if isinstance(part, Signal):
            yield part.name, None
        elif isinstance(part, SignalIs):
            yield part.name, part.value
        stack.extend(reversed(part.operands))


def signals_of(expression: Expression) -> Iterator[str]:
    """Yield the names of the signals of an expression from left to right, as often as they occur."""
    return (name for name, _ in atoms_of(expression))
