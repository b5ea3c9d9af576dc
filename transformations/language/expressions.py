"""Expressions over a match: features of matched elements, comparisons, counts, texts.

They are objects, not functions, so that a rule can be checked against the metamodel when it is defined, and
be drawn. For a pattern node `port`, `port.place.id` is an expression.
"""

from __future__ import annotations

import operator
import string
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, TypeAlias

from pyecore.ecore import EClass, EReference

from dineros.metamodel.base import EObject, features_of, remembered
from dineros.metamodel.errors import Location, near_matches
from dineros.transformations.language.datatypes import TEXT, TRUTH, comparable, datatype_of, literal_of
from dineros.transformations.language.errors import RuleError, rule_line

Match: TypeAlias = "dict[Variable, Any]"


class Expression:
    """An expression with a value for every match.

    A feature of the value is an attribute: `port.place.id`. If a feature has the name of an attribute or
    method below, use `Path(port, "many")`.

    Attributes
    ----------
    eclass : type of model object or None
        Class of the value; None for numbers, texts and Booleans.
    datatype : Ecore data type or None
        Type of a plain value; None for model objects, and if it is not known.
    many : bool
        Whether `evaluate` returns a list.
    location : Location
        Its line in the rule; a part of another expression has the line of that one.
    """

    eclass: type[EObject] | None = None
    datatype: Any = None
    many = False

    def __init__(self, *operands: Expression, location: Location | None = None) -> None:
        self.location = location or rule_line()
        self._operands = operands

    def evaluate(self, match: Match) -> Any:
        """Return the value for a match."""
        raise NotImplementedError

    def variables(self) -> Iterator[Variable]:
        """Yield the pattern variables on which the value depends."""
        for operand in self._operands:
            yield from operand.variables()

    def __getattr__(self, name: str) -> Path:
        if name.startswith("_"):
            raise AttributeError(name)
        return Path(self, name)

    __hash__ = object.__hash__

    def __eq__(self, other: object) -> Comparison:  # type: ignore[override]
        return Comparison("==", self, as_expression(other))

    def __ne__(self, other: object) -> Comparison:  # type: ignore[override]
        return Comparison("!=", self, as_expression(other))

    def __lt__(self, other: object) -> Comparison:
        return Comparison("<", self, as_expression(other))

    def __gt__(self, other: object) -> Comparison:
        return Comparison(">", self, as_expression(other))

    def __invert__(self) -> Negation:
        return Negation(self)

    def __bool__(self) -> bool:
        raise RuleError(
            "an expression has no truth value while the rule is written",
            location=rule_line(),
            hint="use where=[...] for conditions and ~ for not",
        )


class Constant(Expression):
    """A value that does not depend on the match."""

    def __init__(self, value: object, location: Location | None = None) -> None:
        super().__init__(location=location)
        self.value = value
        self.datatype = datatype_of(value)

    def evaluate(self, match: Match) -> Any:
        return self.value

    def __str__(self) -> str:
        return str(self.value)


def as_expression(value: object, location: Location | None = None) -> Expression:
    """Return the value itself if it is an expression, else a constant."""
    return value if isinstance(value, Expression) else Constant(value, location)


class Variable(Expression):
    """A variable bound by a match: a pattern node, a lookup, a number, or an element being created.

    Attributes
    ----------
    symbol : str
        Its name in the rule.
    """

    symbol = ""

    def evaluate(self, match: Match) -> Any:
        return match[self]

    def variables(self) -> Iterator[Variable]:
        yield self

    def __str__(self) -> str:
        return self.symbol or (self.eclass.__name__ if self.eclass is not None else "?")


class Item(Variable):
    """The value to which a condition of `count` or `first` is applied."""

    def __init__(self, eclass: type[EObject] | None) -> None:
        super().__init__()
        self.eclass = eclass
        self.symbol = "item"


class Path(Expression):
    """A feature of the value of another expression; for many values, the union of their features."""

    def __init__(self, base: Expression, feature: str, location: Location | None = None) -> None:
        super().__init__(base, location=location)
        self._base = base
        self._feature = feature
        if base.eclass is None:
            raise RuleError(f"{base} is not a model element and has no {feature!r}", location=self.location)
        definition = feature_of(base.eclass, feature, self.location)
        reference = isinstance(definition, EReference)
        self.eclass = python_class(definition._eType) if reference else None
        self.datatype = None if reference else definition._eType
        self._containment = reference and definition.containment
        self.many = base.many or definition.many

    def evaluate(self, match: Match) -> Any:
        value = self._base.evaluate(match)
        name = self._feature
        if not self.many:
            return None if value is None else getattr(value, name)
        found: dict[Any, None] = {}
        for owner in value if self._base.many else (() if value is None else (value,)):
            inner = getattr(owner, name)
            if inner is None:
                continue
            if isinstance(inner, EObject) or not isinstance(inner, Iterable) or isinstance(inner, str):
                found[inner] = None
            else:
                found.update(dict.fromkeys(inner))
        return list(found)

    def __str__(self) -> str:
        base = str(self._base)
        return f"({base}).{self._feature}" if " " in base else f"{base}.{self._feature}"

    def is_collection(self) -> bool:
        """Return whether this is a many-valued containment feature of one element."""
        return bool(self._containment) and self.many and not self._base.many

    def is_containment(self) -> bool:
        """Return whether this is a containment feature of one element."""
        return bool(self._containment) and not self._base.many

    def put(self, match: Match, value: EObject) -> None:
        """Put an element into the containment feature: append it, or set a single-valued feature."""
        if self.many:
            self.collection(match).append(value)
        else:
            setattr(self._base.evaluate(match), self._feature, value)

    def collection(self, match: Match) -> Any:
        """Return the many-valued feature itself, to add elements."""
        return getattr(self._base.evaluate(match), self._feature)


_OPERATORS: Mapping[str, Callable[[Any, Any], Any]] = {
    "contains": operator.contains,
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
}


class Comparison(Expression):
    """A comparison of two values; an absent value is neither less nor greater than any value.

    Raises
    ------
    RuleError
        The values can never be equal: an element and a number, elements of unrelated classes, or a text
        that is not a literal of an enumeration.
    """

    datatype = TRUTH

    def __init__(self, symbol: str, left: Expression, right: Expression) -> None:
        right = matching(left.datatype, right)
        super().__init__(left, right)
        self.symbol = symbol
        self.left = left
        self.right = right
        if not self._can_hold():
            raise RuleError(f"{self} compares values that can never be equal", location=self.location)

    def _can_hold(self) -> bool:
        left, right = self.left, self.right
        if isinstance(right, Constant) and right.value is None:
            return True
        if left.eclass is None or right.eclass is None:
            return left.eclass is right.eclass and comparable(left.datatype, right.datatype)
        return self.symbol in ("==", "!=", "contains") and compatible(left.eclass, right.eclass)

    def evaluate(self, match: Match) -> bool:
        left, right = self.left.evaluate(match), self.right.evaluate(match)
        if self.symbol in "<>" and (left is None or right is None):
            return False
        return bool(_OPERATORS[self.symbol](left, right))

    def __str__(self) -> str:
        return f"{self.left} {self.symbol} {self.right}"


class Negation(Expression):
    """True if a condition is false, or if there is no value."""

    datatype = TRUTH

    def __init__(self, condition: Expression) -> None:
        super().__init__(condition)
        self.condition = condition

    def evaluate(self, match: Match) -> bool:
        return not self.condition.evaluate(match)

    def __str__(self) -> str:
        return f"not {self.condition}"


class Text(Expression):
    """A text with placeholders, such as ``"{channel.id}.publisher.{port.place.id}"``.

    The names are those in the rule; `bind` resolves them once the rule is complete.
    """

    datatype = TEXT

    def __init__(self, template: str, at: Location | None = None, /, **names: Expression) -> None:
        super().__init__(location=at)
        self.template = template
        self.parts: list[tuple[str, Expression | None]] = []
        self.names = dict(names)

    def bind(self, names: Mapping[str, object]) -> None:
        """Resolve the placeholders; names given to the constructor take precedence.

        Raises
        ------
        RuleError
            A placeholder is malformed, or names no element of the rule or an unknown feature.
        """
        known = {**names, **self.names}
        self.parts = []
        try:
            fields = list(string.Formatter().parse(self.template))
        except ValueError as error:
            raise RuleError(f"bad text {self.template!r}: {error}", location=self.location) from error
        for literal, field, _, _ in fields:
            self.parts.append((literal, None if field is None else self._placeholder(field, known)))

    def _placeholder(self, field: str, known: Mapping[str, object]) -> Expression:
        first, *features = field.split(".")
        expression = known.get(first)
        if not isinstance(expression, Expression):
            visible = [name for name, value in known.items() if isinstance(value, Expression)]
            raise RuleError(
                f"placeholder {{{field}}} is not an element of the rule",
                location=self.location,
                hint=near_matches(first, visible) or f"known: {', '.join(visible)}",
            )
        for feature in features:
            if expression.eclass is None:
                raise RuleError(f"{expression} has no {feature!r}", location=self.location)
            expression = Path(expression, feature, self.location)
        return expression

    def evaluate(self, match: Match) -> str:
        return "".join(
            literal if value is None else f"{literal}{value.evaluate(match)}" for literal, value in self.parts
        )

    def variables(self) -> Iterator[Variable]:
        for _, value in self.parts:
            if value is not None:
                yield from value.variables()

    def __str__(self) -> str:
        return self.template


def matching(datatype: Any, value: Expression) -> Expression:
    """Return a value to compare with, or assign to, a feature of a type: a text may name a literal."""
    if not isinstance(value, Constant):
        return value
    literal = literal_of(datatype, value.value, value.location)
    return value if literal is value.value else Constant(literal, value.location)


@remembered
def compatible(one: type[EObject], other: type[EObject]) -> bool:
    """Return whether an object can belong to both classes, according to their inheritance."""
    return one is EObject or other is EObject or issubclass(one, other) or issubclass(other, one)


def feature_of(eclass: type[EObject], name: str, location: Any) -> Any:
    """Return a feature of a class.

    Raises
    ------
    RuleError
        The class has no such feature; the hint names near matches.
    """
    features = features_of(eclass)
    if name not in features:
        raise RuleError(
            f"{eclass.__name__} has no feature {name!r}",
            location=location,
            hint=near_matches(name, features) or f"it has {', '.join(sorted(features))}",
        )
    return features[name]


def python_class(etype: Any) -> type[EObject]:
    """Return the typed class of a reference's type."""
    found: type[EObject] = etype.python_class if isinstance(etype, EClass) else etype
    return found


def require_compatible(value: Expression, eclass: type[EObject], what: str, location: Any) -> None:
    """Refuse a value that can never belong to a class.

    Raises
    ------
    RuleError
        The value is not a model element, or of an unrelated class.
    """
    if value.eclass is None or not compatible(value.eclass, eclass):
        found = value.eclass.__name__ if value.eclass else "a plain value"
        shown = found if str(value) == found else f"{value} ({found})"
        raise RuleError(f"{what} needs {eclass.__name__}, not {shown}", location=location)
