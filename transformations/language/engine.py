"""Applies rules to a model and records the results of each application.

For each rule, all matches are first collected in model order, and then applied; so the same model and rules
give the same result. The engine is independent of Petri nets.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, TypeVar

from dineros.metamodel.base import EObject
from dineros.metamodel.limits import exceeds
from dineros.metamodel.times.once import unchanged
from dineros.transformations.language.creation import IMAGES, Copy, ForAll, Fragment, Maker, New
from dineros.transformations.language.errors import RuleError
from dineros.transformations.language.expressions import Match, Variable
from dineros.transformations.language.matcher import Extents, Matcher
from dineros.transformations.language.patterns import Index, Made, Node
from dineros.transformations.language.rule import Rule

_AnyRule = TypeVar("_AnyRule", bound=type[Rule])


@dataclass(eq=False)
class Application:
    """One application of a rule.

    Attributes
    ----------
    rule : type of Rule
        The rule.
    number : int
        Number of the application, from 0.
    sources : list
        Values of the pattern nodes and numbers of the left-hand side, without lookups.
    made : dict
        The elements made, by role.
    repeated : list
        The elements made by its for-alls, by role.
    """

    rule: type[Rule]
    number: int
    sources: list[Any]
    made: dict[str, EObject] = field(default_factory=dict)
    repeated: list[tuple[str, EObject]] = field(default_factory=list)

    def elements(self) -> Iterator[tuple[str, EObject]]:
        """Yield all elements made, with their roles."""
        yield from self.made.items()
        yield from self.repeated


class Engine:
    """Applies rules to one model, in place.

    Parameters
    ----------
    root : model object
        The model.

    Attributes
    ----------
    images : dict
        For each copy made by rules, a dictionary from original parts to copied parts.
    """

    def __init__(self, root: EObject) -> None:
        self.extents = Extents(root)
        self.applications: list[Application] = []
        self.images: dict[EObject, dict[EObject, EObject]] = {}
        self._planned = 0
        self._sizes: dict[EObject, int] = {}
        self._matcher = Matcher(self.extents, self)
        self._maker: dict[EObject, Application] = {}
        self._by_rule: dict[type[Maker], list[Application]] = {}
        self._by_source: dict[tuple[type[Maker], Any], list[Application]] = {}
        self._groups: dict[Any, list[tuple[Application, dict[str, EObject]]]] = {}

    def run(self, rules: Iterable[type[Rule]]) -> list[Application]:
        """Apply rules in the given order; return all applications so far."""
        for rule in rules:
            self.apply(rule)
        return self.applications

    def apply(self, rule: type[Rule], given: Match | None = None) -> list[Application]:
        """Find all matches of a rule, then apply it to each; `given` binds some of its pattern nodes.

        Raises
        ------
        SizeLimitError
            It would make too many elements; then it makes none.
        """
        matches = []
        try:
            nodes = [*rule.lhs, *rule.context]
            bound = {IMAGES: self.images, **(given or {})}
            with unchanged():
                for match in self._matcher.matches(nodes, rule.where, rule.absent, bound):
                    self._plan(rule, sum(self._size(item, match) for item in rule.rhs))
                    matches.append(match)
        except (AttributeError, TypeError, ValueError) as error:
            raise RuleError(
                f"{rule.__name__} cannot be matched: {error}", location=rule.lhs[0].location
            ) from error
        return [self._apply(rule, match) for match in matches]

    def _plan(self, rule: type[Rule], elements: int) -> None:
        """Count the elements to be made; refuse too many before any is made."""
        self._planned += elements
        what = f"with {rule.__name__}, the rules create more than"
        if (error := exceeds("elements", self._planned, what, is_all=False)) is not None:
            raise error

    def _size(self, item: Any, match: Match) -> int:
        """Return the number of elements an item makes; elements of for-alls are counted later."""
        if not isinstance(item, Copy) or not match.keys() >= set(item.original.variables()):
            return int(isinstance(item, (New, Copy)))
        original = item.original.evaluate(match)
        if original not in self._sizes:
            self._sizes[original] = 1 + sum(1 for _ in original.eAllContents())
        return self._sizes[original]

    def _apply(self, rule: type[Rule], match: Match) -> Application:
        sources = self._sources(rule, match)
        application = Application(rule, len(self.applications), sources)
        for item in rule.rhs:
            if isinstance(item, ForAll):
                self._repeat(item, match, application)
            elif isinstance(item, (New, Copy)):
                application.made[item.symbol] = self._create(item, match)
        for node in rule.deleted:
            self.extents.discard(match[node])
            match[node].delete()
        self._remember(application, match)
        return application

    def _sources(self, rule: type[Rule], match: Match) -> list[Any]:
        """Return the matched elements; for a rule with lookups only, those that their rules matched."""
        sources = [match[node] for node in rule.lhs if isinstance(node, (Node, Index))]
        if sources:
            return sources
        found: dict[Any, None] = {}
        for node in rule.lhs:
            bound = match[node]
            members = bound.values() if isinstance(bound, dict) else (bound,)
            element = next(member for member in members if member in self._maker)
            found.update(dict.fromkeys(self._maker[element].sources))
        return list(found)

    def _create(self, item: New | Copy, match: Match) -> EObject:
        try:
            made = item.create(match)
        except RuleError:
            raise
        except (AttributeError, TypeError) as error:
            name = item.rule.__name__ if item.rule else "rule"
            raise RuleError(
                f"{name}.{item.symbol} cannot be created: {error}", location=item.location
            ) from error
        match[item] = made
        self.extents.add(made)
        return made

    def _repeat(self, item: ForAll, match: Match, application: Application) -> None:
        for extended in list(self._matcher.matches(item.nodes, item.where, given=match)):
            for element in item.make:
                if isinstance(element, ForAll):
                    self._repeat(element, extended, application)
                else:
                    self._plan(application.rule, 1)
                    application.repeated.append((element.symbol or "each", self._create(element, extended)))

    def _remember(self, application: Application, match: Match) -> None:
        rule = application.rule
        self.applications.append(application)
        self._maker.update((element, application) for element in application.made.values())
        self._by_rule.setdefault(rule, []).append(application)
        for source in dict.fromkeys(application.sources):
            self._by_source.setdefault((rule, source), []).append(application)
        for group in _groups(rule):
            found = (application, group.members(application.made, match))
            for kind in (group, *type(group).__mro__):
                self._groups.setdefault(kind, []).append(found)
                for source in dict.fromkeys(application.sources):
                    self._groups.setdefault((kind, source), []).append(found)

    def groups(self, kind: type[Fragment] | Fragment) -> list[tuple[Application, dict[str, EObject]]]:
        """Return all groups of a kind, each with the application that made it."""
        return self._groups.get(kind, [])

    def made(self, lookup: Made, sources: Sequence[Any]) -> list[Any]:
        """Return the results of a lookup, in the order in which they were made."""
        role = lookup._role
        if isinstance(role, (New, Copy)):
            assert role.rule is not None
            return [
                element
                for application in self.applications_of(role.rule, sources)
                for made_as, element in application.elements()
                if made_as == role.symbol
            ]
        found = self._groups.get((role, sources[0]) if sources else role, [])
        return [members for application, members in found if _has(application, sources[1:])]

    def applications_of(self, rule: type[Maker], sources: Sequence[Any] = ()) -> list[Application]:
        """Return the applications of a rule that matched all the sources."""
        if not sources:
            return self._by_rule.get(rule, [])
        found = self._by_source.get((rule, sources[0]), [])
        return [application for application in found if _has(application, sources[1:])]


def _has(application: Application, sources: Sequence[Any]) -> bool:
    return all(source in application.sources for source in sources)


@cache
def _groups(rule: type[Rule]) -> tuple[Fragment, ...]:
    """Return the fragments of a rule; cached, as it is called for each pair of rules to order them."""
    return tuple(
        value
        for base in reversed(rule.__mro__)
        for value in vars(base).values()
        if isinstance(value, Fragment)
    )


def require_makers(rules: Sequence[type[Rule]]) -> None:
    """Check that each lookup refers to a rule that runs earlier.

    Raises
    ------
    RuleError
        A rule looks up an element that no earlier rule makes.
    """
    earlier: set[type[Rule]] = set()
    for rule in rules:
        for node in _lookups(rule):
            role = node._role
            maker = None if isinstance(role, type) else role.rule
            if maker is not None and maker not in earlier:
                raise RuleError(
                    f"dangling lookup: {rule.__name__} needs {maker.__name__} to run before it",
                    location=node.location,
                )
        earlier.add(rule)


def makers(rule: type[Rule], among: Iterable[_AnyRule]) -> set[_AnyRule]:
    """Return the given rules that make elements which a rule looks up, except the rule itself."""
    roles = [node._role for node in _lookups(rule)]
    kinds = tuple(role for role in roles if isinstance(role, type))
    named = {role.rule for role in roles if not isinstance(role, type)}
    return {
        other
        for other in among
        if other is not rule and (other in named or any(isinstance(group, kinds) for group in _groups(other)))
    }


def _lookups(rule: type[Rule]) -> Iterator[Made]:
    nodes: list[Variable] = list(rule.lhs)
    for pattern in rule.absent:
        nodes.extend(pattern.nodes)
    pending = list(rule.for_all)
    while pending:
        item = pending.pop()
        nodes.extend(item.nodes)
        pending.extend(inner for inner in item.make if isinstance(inner, ForAll))
    yield from (node for node in nodes if isinstance(node, Made))
