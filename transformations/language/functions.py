"""Expressions that rules call by name, such as `ancestor`, `count`, `either`, `enclosing` and `first`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

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


class Ancestor(Expression):
    """The nearest container of a class."""

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
    """All containers of a class, from the inner to the outer."""

    many = True

    def __init__(self, base: Expression, eclass: type[EObject]) -> None:
        super().__init__(base)
        self.base = base
        self.eclass = eclass
        if base.eclass is None or base.many:
            raise RuleError(f"{base} is no model element", location=self.location)

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


class First(Expression):
    """The first of many values."""

    def __init__(self, base: Expression) -> None:
        super().__init__(base)
        self.base = base
        self.eclass = base.eclass
        self.datatype = base.datatype
        if not base.many:
            raise RuleError(f"{base} is a single value and has no first one", location=self.location)

    def evaluate(self, match: Match) -> Any:
        return next(iter(self.base.evaluate(match)), None)

    def __str__(self) -> str:
        return f"first of {self.base}"


class Count(Expression):
    """The number of values."""

    datatype = WHOLE

    def __init__(self, base: Expression) -> None:
        super().__init__(base)
        self.base = base
        if not base.many:
            raise RuleError(f"{base} is a single value and cannot be counted", location=self.location)

    def evaluate(self, match: Match) -> int:
        return len(self.base.evaluate(match))

    def __str__(self) -> str:
        return f"number of {self.base}"


class Position(Expression):
    """The place of an element among its siblings, from 1."""

    datatype = WHOLE

    def __init__(self, base: Expression) -> None:
        super().__init__(base)
        self.base = base

    def evaluate(self, match: Match) -> int:
        element: EObject = self.base.evaluate(match)
        siblings = getattr(element.eContainer(), element.eContainmentFeature().name)
        return int(siblings.index(element)) + 1

    def __str__(self) -> str:
        return f"position of {self.base}"


class Otherwise(Expression):
    """A value, or another one where it is absent."""

    def __init__(self, value: Expression, default: Expression) -> None:
        super().__init__(value, default)
        self.value = value
        self.default = default
        self.eclass = value.eclass
        self.datatype = value.datatype
        same = comparable(value.datatype, default.datatype)
        if (value.eclass is None) != (default.eclass is None) or not same:
            raise RuleError(f"{default} is no value that {value} can have", location=self.location)

    def evaluate(self, match: Match) -> Any:
        value = self.value.evaluate(match)
        return self.default.evaluate(match) if value is None else value

    def __str__(self) -> str:
        return f"{self.value} or {self.default}"


class Number(Expression):
    """1 for true, 0 for false."""

    datatype = WHOLE

    def __init__(self, condition: Expression) -> None:
        super().__init__(condition)
        self.condition = condition

    def evaluate(self, match: Match) -> int:
        return int(bool(self.condition.evaluate(match)))

    def __str__(self) -> str:
        return f"1 if {self.condition}"


class Greatest(Expression):
    """The greatest of some numbers."""

    datatype = WHOLE

    def __init__(self, *values: Expression) -> None:
        super().__init__(*values)
        self.values = values

    def evaluate(self, match: Match) -> int:
        return max(int(value.evaluate(match)) for value in self.values)

    def __str__(self) -> str:
        return f"greatest of {', '.join(map(str, self.values))}"


class Difference(Expression):
    """A number less another one."""

    datatype = WHOLE

    def __init__(self, whole: Expression, part: Expression) -> None:
        super().__init__(whole, part)
        self.whole = whole
        self.part = part

    def evaluate(self, match: Match) -> int:
        return int(self.whole.evaluate(match)) - int(self.part.evaluate(match))

    def __str__(self) -> str:
        if isinstance(self.whole, Constant) and self.whole.value == 0:
            return f"-({self.part})"
        return f"({self.whole}) - {self.part}" if " " in str(self.whole) else f"{self.whole} - {self.part}"


def ancestor(element: Expression, eclass: type[EObject]) -> Expression:
    """Return the nearest container of a class, the element itself included."""
    return Ancestor(element, eclass)


def count(values: Expression, where: Callable[[Item], Expression] | None = None) -> Expression:
    """Return the number of values, of those alone that fulfil a condition if one is given."""
    return Count(values if where is None else Selection(values, where))


def enclosing(element: Expression, eclass: type[EObject]) -> Expression:
    """Return all containers of a class, the element itself included, from the inner to the outer."""
    return Enclosing(element, eclass)


def either(value: Expression, default: object) -> Expression:
    """Return a value, or another one where it is absent."""
    return Otherwise(value, as_expression(default))


def first(values: Expression, **features: object) -> Expression:
    """Return the first value whose features equal those given; absent where none does."""
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
    """Return a number less another one."""
    return Difference(as_expression(whole), as_expression(part))


def number(condition: Expression) -> Expression:
    """Return 1 where a condition is true, else 0."""
    return Number(condition)


def position(element: Expression) -> Expression:
    """Return the place of an element among its siblings, from 1."""
    return Position(element)
