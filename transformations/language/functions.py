"""Expressions that rules call by name, such as `ancestor`, `count`, `either`, `enclosing` and `first`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, ClassVar

from dineros.metamodel.base import EObject
from dineros.transformations.language.datatypes import WHOLE, comparable
from dineros.transformations.language.errors import RuleError
from dineros.transformations.language.expressions import (
    Constant,
    Expression,
    Item,
    Match,
    Path,
    Variable,
    as_expression,
)


class Query(Expression):
    """The result of a function applied to the values of other expressions.

    A subclass defines the function `_answer`, its description `_words` with placeholders for the operands,
    and the type of the result: `eclass` or `datatype`, and `many`.
    """

    _words: ClassVar[str]
    _answer: ClassVar[Callable[..., Any]]

    def evaluate(self, match: Match) -> Any:
        return self._answer(*[operand.evaluate(match) for operand in self._operands])

    def __str__(self) -> str:
        return self._words.format(*self._operands)


class Ancestor(Expression):
    """The nearest container of a class; the element itself counts."""

    def __init__(self, base: Expression, eclass: type[EObject]) -> None:
        super().__init__(base)
        self.base = base
        self.eclass = eclass
        self.many = base.many

    def evaluate(self, match: Match) -> Any:
        value = self.base.evaluate(match)
        if not self.many:
            return self._climb(value)
        climbed = dict.fromkeys(self._climb(start) for start in value)
        climbed.pop(None, None)
        return list(climbed)

    def _climb(self, element: EObject | None) -> EObject | None:
        assert self.eclass is not None
        while element is not None and not isinstance(element, self.eclass):
            element = element.eContainer()
        return element

    def __str__(self) -> str:
        return f"{getattr(self.eclass, '__name__', '')} of {self.base}"


class Enclosing(Expression):
    """All containers of a class, from inner to outer; the element itself counts."""

    many = True

    def __init__(self, base: Expression, eclass: type[EObject]) -> None:
        super().__init__(base)
        self.base = base
        self.eclass = eclass
        if base.eclass is None or base.many:
            raise RuleError(f"{base} is not a model element", location=self.location)

    def evaluate(self, match: Match) -> list[EObject]:
        found: list[EObject] = []
        holder: EObject | None = self.base.evaluate(match)
        assert self.eclass is not None
        while holder is not None:
            if isinstance(holder, self.eclass):
                found.append(holder)
            holder = holder.eContainer()
        return found

    def __str__(self) -> str:
        return f"each {getattr(self.eclass, '__name__', '')} around {self.base}"


class Selection(Expression):
    """The values that fulfil a condition."""

    many = True

    def __init__(self, base: Expression, where: Callable[[Item], Expression]) -> None:
        super().__init__(base)
        self.base = base
        self.eclass = base.eclass
        self.datatype = base.datatype
        self.item = Item(base.eclass)
        self.condition = where(self.item)

    def evaluate(self, match: Match) -> list[Any]:
        values = self.base.evaluate(match)
        return [value for value in values if self.condition.evaluate({**match, self.item: value})]

    def variables(self) -> Iterator[Variable]:
        yield from self.base.variables()
        for variable in self.condition.variables():
            if variable is not self.item:
                yield variable

    def __str__(self) -> str:
        return f"{self.base} with {self.condition}"


class First(Query):
    """The first of many values."""

    _words = "first of {}"

    def __init__(self, base: Expression) -> None:
        super().__init__(base)
        self.eclass = base.eclass
        self.datatype = base.datatype
        if not base.many:
            raise RuleError(f"{base} is a single value and has no first element", location=self.location)

    @staticmethod
    def _answer(values: list[Any]) -> Any:
        return values[0] if values else None


class Count(Query):
    """The number of values."""

    datatype = WHOLE
    _words = "number of {}"
    _answer = staticmethod(len)

    def __init__(self, base: Expression) -> None:
        super().__init__(base)
        if not base.many:
            raise RuleError(f"{base} is a single value and cannot be counted", location=self.location)


class Position(Query):
    """The position of an element among its siblings, from 1."""

    datatype = WHOLE
    _words = "position of {}"

    @staticmethod
    def _answer(element: EObject) -> int:
        siblings = getattr(element.eContainer(), element.eContainmentFeature().name)
        return int(siblings.index(element)) + 1


class Otherwise(Expression):
    """A value, or another one if it is absent."""

    def __init__(self, value: Expression, default: Expression) -> None:
        super().__init__(value, default)
        self.value = value
        self.default = default
        self.eclass = value.eclass
        self.datatype = value.datatype
        same = comparable(value.datatype, default.datatype)
        if (value.eclass is None) != (default.eclass is None) or not same:
            raise RuleError(f"{default} is not a value that {value} can have", location=self.location)

    def evaluate(self, match: Match) -> Any:
        value = self.value.evaluate(match)
        return self.default.evaluate(match) if value is None else value

    def __str__(self) -> str:
        return f"{self.value} or {self.default}"


class Number(Query):
    """1 for true, 0 for false."""

    datatype = WHOLE
    _words = "1 if {}"

    @staticmethod
    def _answer(condition: object) -> int:
        return int(bool(condition))


class Greatest(Query):
    """The greatest of some numbers."""

    datatype = WHOLE

    @staticmethod
    def _answer(*values: int) -> int:
        return max(map(int, values))

    def __str__(self) -> str:
        return f"greatest of {', '.join(map(str, self._operands))}"


class Difference(Query):
    """A number minus another one."""

    datatype = WHOLE

    @staticmethod
    def _answer(whole: int, part: int) -> int:
        return int(whole) - int(part)

    def __str__(self) -> str:
        whole, part = self._operands
        if isinstance(whole, Constant) and whole.value == 0:
            return f"-({part})"
        return f"({whole}) - {part}" if " " in str(whole) else f"{whole} - {part}"


# Rules call them as functions.
ancestor, enclosing, number, position = Ancestor, Enclosing, Number, Position


def count(values: Expression, where: Callable[[Item], Expression] | None = None) -> Expression:
    """Return the number of values; with a condition, of those that fulfil it."""
    return Count(values if where is None else Selection(values, where))


def either(value: Expression, default: object) -> Expression:
    """Return a value, or another one if it is absent."""
    return Otherwise(value, as_expression(default))


def first(values: Expression, **features: object) -> Expression:
    """Return the first value with the given features; absent if there is none."""
    selected = values
    for name, wanted in features.items():
        selected = Selection(selected, partial(_equals, name, wanted))
    return First(selected)


def _equals(name: str, wanted: object, item: Item) -> Expression:
    return Path(item, name) == wanted


def greatest(*values: object) -> Expression:
    """Return the greatest of some numbers."""
    return Greatest(*map(as_expression, values))


def less(whole: object, part: object) -> Expression:
    """Return a number minus another one."""
    return Difference(as_expression(whole), as_expression(part))
