"""Conditions over fields of tokens, and assignments to fields: immutable trees with unresolved names."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

from dineros.metamodel.clauses.expressions import And, Expression, Not, Or, Valuation

Condition = Expression
"""A condition over fields, such as a `Comparison`, or several that are joined as in clauses."""

Constant = int | bool | str
"""A number, a truth value, or the name of a value."""

SIGNS: dict[str, Callable[[Any, Any], bool]] = {
    "=": operator.eq,
    "<>": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}

TURNED = {"<": ">", "<=": ">=", ">": "<", ">=": "<="}
"""Signs that differ if both sides of a comparison change places."""


class FieldName(NamedTuple):
    """A field as it is named in a text: with or without the id of its place."""

    place: str | None
    field: str

    def __str__(self) -> str:
        return ".".join(_written(part) for part in (self.place, self.field) if part is not None)


def _written(name: str) -> str:
    """Return a name as a guard has it: in quotes if it is not a word."""
    if re.fullmatch(r"[^\W\d][\w@-]*", name):
        return name
    escaped = name.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


@dataclass(frozen=True)
class Comparison(Expression):
    """A field compared with a constant, or with another field of the same token until names are resolved."""

    field: FieldName
    sign: str
    value: Constant | FieldName

    @property
    def fields(self) -> tuple[FieldName, ...]:
        """The fields that are compared."""
        return (self.field, self.value) if isinstance(self.value, FieldName) else (self.field,)

    def evaluate(self, values: Valuation) -> bool:  # noqa: D102
        assert not isinstance(self.value, (str, FieldName)), "names are resolved"
        return SIGNS[self.sign](values[self.field], self.value)


class Assignment(NamedTuple):
    """A field of a token that is put gets a constant, or the value of a field of a token taken or read."""

    field: FieldName
    value: Constant | FieldName


def comparisons(condition: Condition) -> Iterator[Comparison]:
    """Yield the comparisons of a condition, from left to right."""
    stack = [condition]
    while stack:
        part = stack.pop()
        if isinstance(part, Comparison):
            yield part
        stack.extend(reversed(part.operands))


def with_comparisons(condition: Condition, changed: Callable[[Comparison], Condition]) -> Condition:
    """Return a condition with each comparison replaced; its depth is bounded by the parser."""
    match condition:
        case Comparison():
            return changed(condition)
        case Not(operand):
            return Not(with_comparisons(operand, changed))
        case And(parts):
            return And(tuple(with_comparisons(part, changed) for part in parts))
        case Or(parts):
            return Or(tuple(with_comparisons(part, changed) for part in parts))
    raise TypeError(f"no condition: {condition!r}")
