"""Finds the matches of a rule's left-hand side, in model order.

A greedy plan orders the pattern nodes once: lookups first, then nodes that a reference connects to a bound
node, then the class with the fewest objects. Objects are indexed by class, including superclasses.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, Protocol, TypeAlias

from dineros.metamodel.base import EObject, features_of, remembered
from dineros.transformations.language.copying import contents
from dineros.transformations.language.expressions import (
    Comparison,
    Constant,
    Expression,
    Match,
    Path,
    Variable,
)
from dineros.transformations.language.patterns import Absent, Index, Made, Node
from dineros.transformations.language.rule import conditions_of

Candidates: TypeAlias = Callable[[Match], Iterable[Any]]
Step: TypeAlias = "tuple[Variable, Candidates, list[Expression]]"
"""The variable to bind next, its candidate values, and the conditions that can then be checked."""


class Lookup(Protocol):
    """Interface with which `Made` is resolved."""

    def made(self, lookup: Made, sources: Sequence[Any]) -> list[Any]:
        """Return the results of a lookup for the values of its `of`."""


class Extents:
    """All objects of a model by class, including superclasses, in model order."""

    def __init__(self, root: EObject) -> None:
        self._by_class: dict[type, dict[EObject, None]] = {}
        self._by_value: dict[tuple[type[EObject], str], dict[Any, list[EObject]]] = {}
        self._order: dict[EObject, int] = {}
        self._count = 0
        self.add(root)

    def add(self, element: EObject) -> None:
        """Index an element with all its contents."""
        stack = [element]
        while stack:
            current = stack.pop()
            self._order[current] = self._count
            self._count += 1
            for eclass in _classes(type(current)):
                self._by_class.setdefault(eclass, {})[current] = None
            for (eclass, feature), index in self._by_value.items():
                if isinstance(current, eclass):
                    _note(index, current, feature)
            stack.extend(reversed(contents(current)))

    def discard(self, element: EObject) -> None:
        """Remove an element with all its contents."""
        stack = [element]
        while stack:
            current = stack.pop()
            self._order.pop(current, None)
            for eclass in _classes(type(current)):
                self._by_class.get(eclass, {}).pop(current, None)
            stack.extend(contents(current))
        self._by_value.clear()

    def of(self, eclass: type[EObject] | None) -> list[EObject]:
        """Return all objects of a class."""
        return list(self._by_class.get(eclass or EObject, ()))

    def size(self, eclass: type[EObject] | None) -> int:
        """Return the number of objects of a class."""
        return len(self._by_class.get(eclass or EObject, ()))

    def with_value(self, eclass: type[EObject], feature: str, value: Any) -> list[EObject]:
        """Return the objects of a class whose feature is, or contains, a value."""
        definition = features_of(eclass)[feature]
        if not isinstance(value, EObject):
            return self._indexed(eclass, feature).get(value, [])
        if definition.eOpposite is not None:
            opposite = definition.eOpposite
            held = getattr(value, opposite.name)
            found = held if opposite.many else (held,)
        elif definition.containment:
            found = (value.eContainer(),)
        else:
            return self._indexed(eclass, feature).get(value, [])
        known = self._by_class.get(eclass, {})
        return sorted((owner for owner in found if owner in known), key=self._order.__getitem__)

    def _indexed(self, eclass: type[EObject], feature: str) -> dict[Any, list[EObject]]:
        """Return the objects of a class by the values of a feature that has no opposite."""
        index = self._by_value.get((eclass, feature))
        if index is None:
            index = self._by_value[eclass, feature] = {}
            for element in self.of(eclass):
                _note(index, element, feature)
        return index


def _note(index: dict[Any, list[EObject]], element: EObject, feature: str) -> None:
    held = getattr(element, feature)
    for item in held if features_of(type(element))[feature].many else (held,):
        index.setdefault(item, []).append(element)


@remembered
def _classes(eclass: type[EObject]) -> list[type[EObject]]:
    """Return a class and its superclasses."""
    return [each for each in eclass.__mro__ if issubclass(each, EObject)]


class Matcher:
    """Matches pattern nodes against a model.

    Parameters
    ----------
    extents : Extents
        The model.
    lookup : Lookup
        Resolves lookups of elements that rules have made so far.
    """

    def __init__(self, extents: Extents, lookup: Lookup) -> None:
        self._extents = extents
        self._lookup = lookup
        self._plans: dict[tuple[tuple[int, ...], tuple[int, ...], frozenset[Variable]], list[Step]] = {}

    def matches(
        self,
        nodes: Sequence[Variable],
        where: Sequence[Expression] = (),
        absent: Sequence[Absent] = (),
        given: Match | None = None,
    ) -> Iterator[Match]:
        """Yield all bindings of the nodes that fulfil all conditions, in model order.

        `given` has the variables that are bound already. A match may bind two nodes to the same object.
        """
        given = given or {}
        key = tuple(map(id, nodes)), tuple(map(id, where)), frozenset(given)
        steps = self._plans.get(key)
        if steps is None:
            steps = self._plans[key] = self._plan(nodes, where, set(given))
        for match in self._search(steps, dict(given)):
            if not any(self._exists(pattern, match) for pattern in absent):
                yield match

    def _exists(self, pattern: Absent, match: Match) -> bool:
        return next(self.matches(pattern.nodes, pattern.where, given=match), None) is not None

    def _search(self, steps: list[Step], match: Match, depth: int = 0) -> Iterator[Match]:
        if depth == len(steps):
            yield dict(match)
            return
        variable, candidates, conditions = steps[depth]
        for value in candidates(match):
            match[variable] = value
            if all(condition.evaluate(match) for condition in conditions):
                yield from self._search(steps, match, depth + 1)
        match.pop(variable, None)

    def _plan(
        self, nodes: Sequence[Variable], where: Sequence[Expression], bound: set[Variable]
    ) -> list[Step]:
        pending = [node for node in nodes if node not in bound]
        conditions = [*where, *(condition for node in pending for condition in _equations(node))]
        steps = []
        while pending:
            ranked = [(self._cost(node, bound), place) for place, node in enumerate(pending)]
            node = pending.pop(min(ranked)[1])
            candidates = self._candidates(node, bound)
            bound.add(node)
            ready = [condition for condition in conditions if bound.issuperset(condition.variables())]
            conditions = [condition for condition in conditions if not any(condition is r for r in ready)]
            steps.append((node, candidates, ready))
        return steps

    def _cost(self, node: Variable, bound: set[Variable]) -> float:
        if isinstance(node, (Made, Index)):
            return 0 if bound.issuperset(conditions_of(node)) else float("inf")
        assert isinstance(node, Node)
        if node._of is not None:
            return 1 if bound.issuperset(node._of.variables()) else float("inf")
        if self._linked(node, bound) is not None:
            return 2
        return 3 + self._extents.size(node.eclass)

    def _linked(self, node: Node, bound: set[Variable]) -> tuple[str, Expression] | None:
        """Return a feature of the node whose value is already bound."""
        for name, value in node._features.items():
            if not isinstance(value, Constant) and bound.issuperset(value.variables()):
                return name, value
        return None

    def _candidates(self, node: Variable, bound: set[Variable]) -> Candidates:
        if isinstance(node, Made):
            sources = node._of
            return lambda match: self._lookup.made(node, [source.evaluate(match) for source in sources])
        if isinstance(node, Index):
            return lambda match: range(1, node._upto.evaluate(match) + 1)
        assert isinstance(node, Node) and node.eclass is not None
        eclass = node.eclass
        if node._of is not None:
            of = node._of
            return lambda match: [value for value in _values(of, match) if isinstance(value, eclass)]
        link = self._linked(node, bound)
        if link is None:
            return lambda match: self._extents.of(eclass)
        name, value = link
        return lambda match: self._extents.with_value(eclass, name, value.evaluate(match))


def _values(expression: Expression, match: Match) -> Iterable[Any]:
    value = expression.evaluate(match)
    if expression.many:
        return value  # type: ignore[no-any-return]
    return () if value is None else (value,)


def _equations(node: Variable) -> Iterator[Expression]:
    """Yield the equations for the features of a pattern node, as conditions."""
    if not isinstance(node, Node):
        return
    assert node.eclass is not None
    for name, value in node._features.items():
        many = features_of(node.eclass)[name].many
        yield Comparison("contains" if many else "==", Path(node, name), value)
