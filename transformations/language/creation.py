"""The right-hand side of rules: elements to make, groups of elements, copies, and for-alls."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, ClassVar

from pyecore.ecore import EReference

from dineros.metamodel.base import EObject, features_of, remembered
from dineros.metamodel.errors import Location, near_matches
from dineros.transformations.language.copying import deep_copy
from dineros.transformations.language.datatypes import TEXT, fits
from dineros.transformations.language.errors import RuleError, rule_line
from dineros.transformations.language.expressions import (
    Constant,
    Expression,
    Item,
    Match,
    Path,
    Text,
    Variable,
    as_expression,
    feature_of,
    matching,
    python_class,
    require_compatible,
)
from dineros.transformations.language.meaning import Meaning

IMAGES = Variable()
"""Bound in every match: for each copy made by rules, a dictionary from original parts to copied parts."""


class Maker:
    """A rule from the view of its created elements: its name and its left-hand side."""

    lhs: ClassVar[Sequence[Variable]]


class New(Variable):
    """An element that a rule creates.

    Parameters
    ----------
    eclass : type of model object
        Its class; not an abstract one.
    into : Path, optional
        The containment feature to which it is added (``model.channels``), if its class has no feature for its
        container.
    **features
        Its features: expressions or values; texts may have placeholders.

    Raises
    ------
    RuleError
        Abstract class, unknown feature, value of the wrong type, missing required feature or container.
    """

    meaning: Meaning | None = None
    """Its meaning for readers of the net, if it has one beyond the rule."""
    is_prompt = False
    """Whether it fires without delay, if time is modelled."""
    repeats = False
    """Whether it is a transition that repeats the transition of the model that its rule matches."""
    carries = False
    """Whether it is a place whose tokens carry the data of messages, requests, goals or their answers."""

    def __init__(self, eclass: type[EObject], *, into: Path | None = None, **features: object) -> None:
        super().__init__()
        self.eclass = eclass
        self.rule: type[Maker] | None = None
        self.into = require_containment(into, eclass) if into is not None else None
        if eclass.eClass.abstract:
            raise RuleError(f"{eclass.__name__} is abstract and cannot be created", location=self.location)
        self.features: dict[str, Expression] = {}
        for name, value in features.items():
            self.features[name] = self._checked(name, value)
        self._require_features()

    def _checked(self, name: str, value: object) -> Expression:
        assert self.eclass is not None
        definition = feature_of(self.eclass, name, self.location)
        whose = f"{self.eclass.__name__}.{name}"
        if isinstance(value, str) and definition._eType is TEXT:
            return Text(value, self.location)
        expression = matching(definition._eType, as_expression(value, self.location))
        if expression.many != definition.many and not isinstance(expression, Constant):
            one, many = "a single value", "a list"
            raise RuleError(
                f"{whose} takes {many if definition.many else one}, "
                f"but {expression} is {many if expression.many else one}",
                location=self.location,
            )
        if isinstance(definition, EReference):
            require_compatible(expression, python_class(definition._eType), whose, self.location)
        elif expression.eclass is not None:
            raise RuleError(
                f"{whose} takes {definition._eType.name}, not an element: {expression}",
                location=self.location,
            )
        elif not fits(expression.datatype, definition._eType):
            raise RuleError(
                f"{whose} takes {definition._eType.name}, not {expression}",
                location=self.location,
            )
        return expression

    def _require_features(self) -> None:
        assert self.eclass is not None
        required, containers = _required_of(self.eclass)
        missing = [name for name in required if name not in self.features]
        if missing:
            raise RuleError(
                f"{self.eclass.__name__} needs {', '.join(missing)}",
                location=self.location,
                hint="required by the metamodel",
            )
        if self.into is None and not any(name in self.features for name in containers):
            raise RuleError(
                f"missing container: a new {self.eclass.__name__} needs {' or '.join(containers) or 'into='}",
                location=self.location,
            )

    def uses(self) -> Iterator[Expression]:
        """Yield the expressions that its creation evaluates."""
        yield from self.features.values()
        if self.into is not None:
            yield self.into

    def create(self, match: Match) -> EObject:
        """Make the element for a match."""
        assert self.eclass is not None
        made = self.eclass(**{name: value.evaluate(match) for name, value in self.features.items()})
        if self.into is not None:
            self.into.put(match, made)
        return made

    def __getattr__(self, name: str) -> Any:
        if name in ("eclass", "features", "rule", "into"):
            raise AttributeError(name)
        return super().__getattr__(name)


@remembered
def _required_of(eclass: type[EObject]) -> tuple[list[str], list[str]]:
    """Return the features that each object of a class must have, and those that refer to its container."""
    features = features_of(eclass).items()
    required = sorted(name for name, feature in features if feature.lowerBound > 0)
    return required, [
        name for name, feature in features if isinstance(feature, EReference) and feature.container
    ]


class Copy(Variable):
    """A deep copy of an element; references inside it stay inside, all others are shared.

    Parameters
    ----------
    original : Expression
        The element to copy, with all its contents.
    into : Path
        The many-valued containment feature to which the copy is added.
    named : type of model object
        Class of the contained elements that get their own ids.
    id : str
        Text for these ids; ``{original}`` is the copied element.
    """

    def __init__(self, original: Expression, *, into: Path, named: type[EObject], id: str) -> None:
        super().__init__()
        self.eclass = original.eclass
        self.rule: type[Maker] | None = None
        self.original = original
        assert self.eclass is not None
        self.into = require_collection(into, self.eclass)
        feature_of(named, "id", self.location)
        self.named = named
        self.item = Item(named)
        self.id = Text(id, original=self.item)

    def uses(self) -> Iterator[Expression]:
        """Yield the expressions that its creation evaluates."""
        yield self.original
        yield self.into

    def create(self, match: Match) -> EObject:
        """Make the copy for a match; `image` finds the parts of the copy."""
        copied, images = deep_copy(self.original.evaluate(match))
        for original, image in images.items():
            if isinstance(original, self.named):
                setattr(image, "id", self.id.evaluate({**match, self.item: original}))  # noqa: B010
        match[IMAGES][copied] = images
        self.into.collection(match).append(copied)
        return copied


class Image(Expression):
    """The part of a copy that corresponds to a part of the original."""

    def __init__(self, part: Expression, copy: Variable) -> None:
        super().__init__()
        self.part = part
        self.copy = copy
        self.eclass = part.eclass

    def evaluate(self, match: Match) -> Any:
        """Return the copied part; a part outside the original is shared and is its own image.

        Raises
        ------
        RuleError
            The element was not copied by a rule.
        """
        images = match[IMAGES].get(match[self.copy])
        if images is None:
            raise RuleError(f"{self.copy} is not a copy", location=self.location)
        part = self.part.evaluate(match)
        return images.get(part, part)

    def variables(self) -> Iterator[Variable]:
        """Yield the variables of the part, and the copy."""
        yield from self.part.variables()
        yield self.copy

    def __str__(self) -> str:
        return f"copy of {self.part}"


image = Image  # rules call it as a function


class Member(Expression):
    """An element of a group found by a lookup, such as `queue.load`."""

    def __init__(self, group: Variable, role: str, eclass: type[EObject]) -> None:
        super().__init__()
        self._group = group
        self._role = role
        self.eclass = eclass

    def evaluate(self, match: Match) -> Any:
        """Return the element."""
        return match[self._group][self._role]

    def variables(self) -> Iterator[Variable]:
        """Yield the lookup."""
        yield self._group

    def __str__(self) -> str:
        return f"{self._group}.{self._role}"


class Fragment:
    """A group of elements that several rules create: written once, looked up as one.

    A subclass declares the classes of its elements by role (``roles``). Its constructor makes the elements or
    receives them.
    """

    roles: Mapping[str, type[EObject]] = {}
    rule: type[Maker] | None = None
    symbol = ""

    def __init__(self, **given: Expression) -> None:
        self.location: Location = rule_line()
        self.given = given

    def elements(self) -> dict[str, New]:
        """Return the group's elements by role, in the order they were made."""
        found: dict[str, New] = {}
        for name, value in vars(self).items():
            if isinstance(value, New):
                found[name] = value
            elif isinstance(value, list):
                found.update({f"{name}{number}": item for number, item in enumerate(value, 1)})
        return found

    def __iter__(self) -> Iterator[New]:
        return iter(self.elements().values())

    def shared(self) -> dict[str, Expression]:
        """Return the members that the group does not make: those given to it, and those of another rule."""
        made = {role: member for role in self.roles if isinstance(member := vars(self).get(role), Member)}
        return {**self.given, **made}

    def members(self, made: Mapping[str, EObject], match: Mapping[Variable, Any]) -> dict[str, EObject]:
        """Return the elements that an application made for this group, and the shared ones, by role."""
        shared = self.shared()
        return {
            role: shared[role].evaluate(dict(match)) if role in shared else made[f"{self.symbol}.{role}"]
            for role in self.roles
        }

    @classmethod
    def class_of(cls, role: str, location: Location) -> type[EObject]:
        """Return the class of the element with a role.

        Raises
        ------
        RuleError
            The group has no such role.
        """
        if role not in cls.roles:
            raise RuleError(
                f"dangling lookup: {cls.__name__} has no {role!r}",
                location=location,
                hint=near_matches(role, cls.roles) or f"it has {', '.join(cls.roles)}",
            )
        return cls.roles[role]


class ForAll:
    """Elements to make once for every match of further pattern nodes; may nest.

    Parameters
    ----------
    nodes : sequence of pattern nodes
        Matched in addition to the rule's left-hand side.
    make : sequence of New or ForAll
        Elements added to the right-hand side for each such match.
    """

    def __init__(
        self, nodes: Sequence[Variable], make: Sequence[New | ForAll], where: Sequence[Expression] = ()
    ) -> None:
        self.nodes = tuple(nodes)
        self.make = tuple(make)
        self.where = tuple(where)
        self.location = rule_line()

    def matched(self) -> Iterator[Variable]:
        """Yield all its pattern nodes, including nested ones."""
        yield from self.nodes
        for item in self.make:
            if isinstance(item, ForAll):
                yield from item.matched()

    def created(self) -> Iterator[New]:
        """Yield all elements that it makes, including nested ones."""
        for item in self.make:
            if isinstance(item, ForAll):
                yield from item.created()
            else:
                yield item


def require_containment(into: Expression, eclass: type[EObject]) -> Path:
    """Require a containment feature of one element for elements of a class.

    Raises
    ------
    RuleError
        It is another kind of expression.
    """
    if not isinstance(into, Path) or not into.is_containment():
        raise RuleError(f"{into} is not a containment feature of one element", location=rule_line())
    require_compatible(into, eclass, "into", rule_line())
    return into


def require_collection(into: Expression, eclass: type[EObject]) -> Path:
    """Require a many-valued containment feature of one element for elements of a class.

    Raises
    ------
    RuleError
        It is another kind of expression.
    """
    if not isinstance(into, Path) or not into.is_collection():
        raise RuleError(f"{into} is not a many-valued containment feature", location=rule_line())
    require_compatible(into, eclass, "into", rule_line())
    return into
