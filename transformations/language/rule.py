"""Rules: a left-hand side to match and a right-hand side to make (paper, Sect. 5.5).

An element on both sides is kept, an element only on the right-hand side is created, an element only on the
left-hand side is deleted. A rule is a class; it is checked against the metamodels when it is defined.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, ClassVar

from dineros.metamodel.errors import near_matches, with_article
from dineros.transformations.language.creation import Copy, ForAll, Fragment, Maker, New
from dineros.transformations.language.errors import RuleError, UnknownRoleError, rule_line
from dineros.transformations.language.expressions import Expression, Text, Variable
from dineros.transformations.language.patterns import Absent, Context, Index, Made, Node, Pattern


class RuleType(type):
    """Metaclass that turns a misspelt role (``T1.plaec``) into an error with similar names."""

    def __getattr__(cls, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        known = [role for role, value in vars(cls).items() if isinstance(value, (Variable, Fragment))]
        raise UnknownRoleError(
            f"dangling lookup: {cls.__name__} has no {name!r}",
            location=rule_line(),
            hint=near_matches(name, known) or f"it has {', '.join(known)}",
        )


class Rule(Maker, metaclass=RuleType):
    """Base class of rules.

    A subclass with the keyword `is_base` is a base class itself, without left-hand and right-hand side.

    Attributes
    ----------
    lhs : sequence of Node, Made or Index, optional
        Elements to match; by default, all such elements of the class body and of its patterns, in order,
        except those in `Absent` or `ForAll`.
    rhs : sequence of Node, Made, Index, New, Copy or ForAll, optional
        Elements after the application; by default, the left-hand side without `deletes`, and all elements
        that the class body makes, in order.
    deletes : sequence of Node, optional
        Elements of the left-hand side that the application deletes.
    where : sequence of Expression
        Conditions that a match must fulfil.
    absent : sequence of Absent
        Forbidden patterns.
    """

    rhs: ClassVar[Sequence[Variable | ForAll]]
    deletes: ClassVar[Sequence[Node]] = ()
    where: ClassVar[Sequence[Expression]] = ()
    absent: ClassVar[Sequence[Absent]] = ()
    created: ClassVar[dict[str, New | Copy]] = {}
    """Elements that the right-hand side makes, by role, without those of `ForAll`."""
    for_all: ClassVar[list[ForAll]] = []
    deleted: ClassVar[list[Node]] = []
    context: ClassVar[list[Context]] = []
    """The context nodes it uses."""

    def __init_subclass__(cls, *, is_base: bool = False, **kwargs: object) -> None:
        super().__init_subclass__(**kwargs)
        if is_base:
            return
        names: dict[str, Any] = {}
        for base in reversed(cls.__mro__):
            for name, value in vars(base).items():
                if isinstance(value, Pattern):
                    names.update(value.elements())
                elif isinstance(value, _PARTS) or name in _LISTS:
                    names[name] = value
        if "lhs" not in names:
            cls.lhs = list(_matched(cls, names))
        if "rhs" not in names:
            gone = set(cls.deletes)
            cls.rhs = [*(element for element in cls.lhs if element not in gone), *_made(names)]
        _require_lists(cls)
        roles = _roles(names)
        _name(cls, names, roles)
        _bind(cls, names, roles)
        after = set(cls.rhs)
        cls.created = {role: element for role, element in roles.items() if element in after}
        cls.for_all = [item for item in cls.rhs if isinstance(item, ForAll)]
        cls.deleted = [node for node in cls.lhs if isinstance(node, Node) and node not in after]
        cls.context = []
        _check(cls, roles)


def _matched(cls: type[Rule], names: dict[str, Any]) -> Iterator[Variable]:
    """Yield the elements that a class body matches, without those of `Absent` and `ForAll` only."""
    inner: set[Variable] = {node for pattern in cls.absent for node in pattern.nodes}
    for value in names.values():
        for item in value if isinstance(value, list) else [value]:
            if isinstance(item, ForAll):
                inner.update(item.matched())
    for value in names.values():
        if isinstance(value, (Node, Made, Index)) and value not in inner:
            yield value


def _made(names: dict[str, Any]) -> Iterator[Variable | ForAll]:
    """Yield the elements that a class body makes, without those of `ForAll`."""
    repeated = {item for value in names.values() if isinstance(value, ForAll) for item in value.created()}
    for value in names.values():
        for item in value if isinstance(value, (list, Fragment)) else [value]:
            if isinstance(item, (New, Copy, ForAll)) and item not in repeated:
                yield item


_PARTS = (Expression, Fragment, ForAll, list)
"""What a class body defines as parts of its rule."""
_LISTS: dict[str, tuple[type, ...]] = {
    "lhs": (Node, Made, Index),
    "rhs": (Node, Made, Index, New, Copy, ForAll),
    "where": (Expression,),
    "absent": (Absent,),
}


def _require_lists(cls: type[Rule]) -> None:
    """Require that sides and conditions are lists of valid items."""
    for name, kinds in _LISTS.items():
        items = getattr(cls, name)
        if not isinstance(items, (list, tuple)):
            raise RuleError(
                f"{cls.__name__}.{name} is not a list", location=rule_line(), hint="put it into a list [ ]"
            )
        for item in items:
            if not isinstance(item, kinds):
                group = isinstance(item, (Fragment, list, tuple))
                raise RuleError(
                    f"{cls.__name__}.{name} cannot hold {_shown(cls, item)}",
                    location=getattr(item, "location", None) or rule_line(),
                    hint="write * in front of it" if group else f"it holds {_words(kinds)}",
                )


def _shown(cls: type[Rule], item: object) -> str:
    """Return the name of an item in the rule, or its description."""
    names = [name for name, value in vars(cls).items() if value is item]
    return names[0] if names else with_article(type(item).__name__)


def _words(kinds: tuple[type, ...]) -> str:
    return ", ".join(kind.__name__ for kind in kinds)


def _roles(names: dict[str, Any]) -> dict[str, New | Copy]:
    """Return all elements that the class body makes, by role; members of groups as ``queue.load``."""
    roles: dict[str, New | Copy] = {}
    for name, value in names.items():
        if isinstance(value, (New, Copy)):
            roles[name] = value
        elif isinstance(value, Fragment):
            roles.update({f"{name}.{role}": element for role, element in value.elements().items()})
        elif isinstance(value, list) and name not in ("lhs", "rhs"):
            roles.update(
                {f"{name}{number}": item for number, item in enumerate(value, 1) if isinstance(item, New)}
            )
    return roles


def _name(cls: type[Rule], names: dict[str, Any], roles: dict[str, New | Copy]) -> None:
    for name, value in names.items():
        if isinstance(value, Fragment):
            value.symbol, value.rule = name, cls
            missing = sorted(set(value.roles) - set(value.elements()) - set(value.shared()))
            if missing:
                raise RuleError(
                    f"{type(value).__name__} does not create {', '.join(missing)}", location=value.location
                )
        elif isinstance(value, Variable) and not value.symbol:
            value.symbol = name
    for role, element in roles.items():
        if element.rule not in (None, cls):
            raise RuleError(
                f"{cls.__name__}.{role} belongs to {element.rule.__name__}",
                location=rule_line(),
                hint=f"look it up: Made({element.rule.__name__}.{element.symbol}, of=...)",
            )
        element.symbol, element.rule = role, cls


def _texts(cls: type[Rule], roles: dict[str, New | Copy]) -> Iterator[Text]:
    elements: list[New | Copy] = list(roles.values())
    for item in cls.rhs:
        if isinstance(item, ForAll):
            elements.extend(item.created())
    for element in elements:
        if isinstance(element, Copy):
            yield element.id
        else:
            yield from (value for value in element.features.values() if isinstance(value, Text))


def _bind(cls: type[Rule], names: dict[str, Any], roles: dict[str, New | Copy]) -> None:
    visible = {name: value for name, value in names.items() if isinstance(value, Expression)}
    for item in cls.rhs:
        if isinstance(item, ForAll):
            visible |= {node.symbol: node for node in item.nodes if node.symbol}
    for text in _texts(cls, roles):
        text.bind(visible)


def _check(cls: type[Rule], roles: dict[str, New | Copy]) -> None:
    """Refuse errors that would otherwise occur only when the rule is applied."""
    bound: set[Variable] = set()
    bound.update(cls.lhs)
    for node in cls.lhs:
        _require_bound(cls, conditions_of(node), bound, node)
    for condition in cls.where:
        _require_bound(cls, condition.variables(), bound, condition)
    for pattern in cls.absent:
        inner = bound | set(pattern.nodes)
        for extra in pattern.nodes:
            _require_bound(cls, conditions_of(extra), inner, extra)
        for condition in pattern.where:
            _require_bound(cls, condition.variables(), inner, condition)
    made = set(bound)
    for item in cls.rhs:
        if isinstance(item, ForAll):
            _check_for_all(cls, item, made)
        elif isinstance(item, (New, Copy)):
            for expression in item.uses():
                _require_bound(cls, expression.variables(), made, item)
            made.add(item)
        elif item not in bound:
            raise RuleError(f"{cls.__name__}: {item} is not on the left-hand side", location=item.location)
    listed = {*cls.rhs, *(element for item in cls.for_all for element in item.created())}
    for role, element in roles.items():
        if element not in listed:
            raise RuleError(
                f"{cls.__name__}: {role} is not on the right-hand side", location=element.location
            )


def _check_for_all(cls: type[Rule], item: ForAll, made: set[Variable]) -> None:
    inner = made | set(item.nodes)
    for node in item.nodes:
        _require_bound(cls, conditions_of(node), inner, node)
    for condition in item.where:
        _require_bound(cls, condition.variables(), inner, condition)
    for element in item.make:
        if isinstance(element, ForAll):
            _check_for_all(cls, element, inner)
        else:
            for expression in element.uses():
                _require_bound(cls, expression.variables(), inner, element)
            inner.add(element)


def _require_bound(
    cls: type[Rule], variables: Iterable[Variable], bound: set[Variable], user: Expression
) -> None:
    for variable in variables:
        if isinstance(variable, Context):
            if all(known is not variable for known in cls.context):
                cls.context.append(variable)
        elif variable not in bound:
            raise RuleError(
                f"{cls.__name__}: {user} uses {variable}, which is not matched or created before it",
                location=user.location,
                hint="list it in lhs, or earlier in rhs",
            )


def conditions_of(node: Variable) -> Iterator[Variable]:
    """Yield the variables in a pattern node's own conditions."""
    if isinstance(node, Node):
        yield from node.conditions()
    elif isinstance(node, Made):
        for source in node._of:
            yield from source.variables()
    elif isinstance(node, Index):
        yield from node._upto.variables()
