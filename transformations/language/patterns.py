"""The left-hand side of rules: pattern nodes, lookups of made elements, numbers, forbidden patterns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from pyecore.ecore import EReference

from dineros.metamodel.base import EObject
from dineros.transformations.language.creation import Copy, Fragment, Maker, Member, New
from dineros.transformations.language.datatypes import WHOLE, comparable, fits
from dineros.transformations.language.errors import RuleError, rule_line
from dineros.transformations.language.expressions import (
    Expression,
    Variable,
    as_expression,
    compatible,
    feature_of,
    matching,
    python_class,
    require_compatible,
)


class Node(Variable):
    """A pattern node: matches every object of a class that fulfils its conditions.

    Parameters
    ----------
    eclass : type of model object
        The class; objects of its subclasses match too.
    of : Expression, optional
        Restricts the node to the value of an expression, or to each of its values.
    **features
        Required values of its features; a many-valued feature must contain the value.

    Raises
    ------
    RuleError
        Unknown feature, or a value that can never fit.
    """

    def __init__(self, eclass: type[EObject], *, of: Expression | None = None, **features: object) -> None:
        super().__init__()
        self.eclass = eclass
        self._of = of
        if of is not None:
            require_compatible(of, eclass, "of", self.location)
        self._features: dict[str, Expression] = {}
        for name, value in features.items():
            definition = feature_of(eclass, name, self.location)
            expression = as_expression(value, self.location)
            if isinstance(definition, EReference) and expression.eclass is not None:
                require_compatible(expression, python_class(definition._eType), name, self.location)
            elif isinstance(definition, EReference) != (expression.eclass is not None):
                raise RuleError(f"{eclass.__name__}.{name} cannot equal {expression}", location=self.location)
            expression = matching(definition._eType, expression)
            if expression.many or not comparable(definition._eType, expression.datatype):
                raise RuleError(f"{eclass.__name__}.{name} cannot equal {expression}", location=self.location)
            self._features[name] = expression

    def conditions(self) -> Iterator[Variable]:
        """Yield the variables in its conditions."""
        if self._of is not None:
            yield from self._of.variables()
        for expression in self._features.values():
            yield from expression.variables()


class Context(Node):
    """A pattern node that is part of each rule that uses it, without being listed in its left-hand side."""


class Index(Variable):
    """A number from 1 to a value.

    Raises
    ------
    RuleError
        The value is not a number.
    """

    datatype = WHOLE

    def __init__(self, upto: Expression | int) -> None:
        super().__init__()
        self._upto = as_expression(upto)
        if self._upto.eclass is not None or self._upto.many or not fits(self._upto.datatype, WHOLE):
            raise RuleError(f"{self._upto} is not a number to count up to", location=self.location)


class Made(Variable):
    """An element that a rule made from elements of this match: a lookup in the trace, not by name.

    Parameters
    ----------
    role : New, Copy, Fragment, or Fragment class
        An element of the right-hand side of an earlier rule (``T1.place``), a group of elements
        (``T3.queue``), or all groups of a class, made by any rule (``OverflowQueue``).
    of : Expression or sequence of Expression
        Elements that the rule matched when it made this; each result gives a separate match.

    Raises
    ------
    RuleError
        The role belongs to no rule, or its rule cannot have matched `of`.
    """

    def __init__(
        self,
        role: New | Copy | Fragment | type[Fragment],
        of: Expression | Sequence[Expression] = (),
    ) -> None:
        super().__init__()
        self._of = (of,) if isinstance(of, Expression) else tuple(of)
        self._role = role
        self._fragment: type[Fragment] | None = None
        if isinstance(role, type) and issubclass(role, Fragment):
            self._fragment = role
            return
        if isinstance(role, type) or role.rule is None:
            raise RuleError(f"no rule creates {role}", location=self.location)
        self._require_sources(role.rule)
        if isinstance(role, Fragment):
            self._fragment = type(role)
        else:
            self.eclass = role.eclass

    def _require_sources(self, rule: type[Maker]) -> None:
        if not any(isinstance(node, (Node, Index)) for node in rule.lhs):
            return  # it has lookups only; sources of their rules are used instead
        for source in self._of:
            if not any(_could_match(node, source) for node in rule.lhs):
                kind = source.eclass.__name__ if source.eclass else "number"
                raise RuleError(
                    f"dangling lookup: {rule.__name__} matches no {kind} ({source})",
                    location=self.location,
                    hint="look it up by the elements that its pattern nodes and numbers matched",
                )

    def __getattr__(self, name: str) -> Any:
        fragment = self.__dict__.get("_fragment")
        if fragment is None or name.startswith("_"):
            return super().__getattr__(name)
        return Member(self, name, fragment.class_of(name, rule_line()))


class Pattern:
    """Elements of left-hand sides that several rules match, written once.

    A subclass makes them in its constructor, as attributes; its own subclasses may add elements. A rule has
    such a pattern among its elements: it matches these elements in order, at the position of the pattern, and
    placeholders use their names as if they were elements of the rule.
    """

    def elements(self) -> dict[str, Node | Made | Index]:
        """Return the elements by name, in the order they were made."""
        return {name: value for name, value in vars(self).items() if isinstance(value, (Node, Made, Index))}


class Absent:
    """A forbidden pattern: a match is rejected if these nodes can be matched as well."""

    def __init__(self, *nodes: Node | Made, where: Sequence[Expression] = ()) -> None:
        self.nodes = nodes
        self.where = tuple(where)


def _could_match(node: Variable, source: Expression) -> bool:
    """Return whether a rule with a node, or a number, may have matched it to a value."""
    if source.eclass is None:
        return isinstance(node, Index)
    return isinstance(node, Node) and node.eclass is not None and compatible(node.eclass, source.eclass)
