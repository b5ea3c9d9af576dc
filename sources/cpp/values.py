"""Values of C++ expressions: constants, objects, ports, callables; all others are open."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from dineros.sources.facts import CallbackFact, Effect, Entity, NodeFact

if TYPE_CHECKING:
    from tree_sitter import Node

    from dineros.sources.cpp.entries import ClassInfo, Routine


PAIRS = ("pair", "::value_type")
"""Ends of names of classes with a key and a value."""


class Value:
    """A value of an expression."""


@dataclass(frozen=True)
class Const(Value):
    """A number, truth value or text; None: a null pointer."""

    value: Any


@dataclass(frozen=True)
class Seconds(Value):
    """A duration."""

    value: float


@dataclass(frozen=True)
class Open(Value):
    """An unknown value; `text` is the text of the code. `parts` is a text with ``{...}``."""

    text: str
    parts: str = ""


MOST_VALUES = 8
"""Maximum number of different values that a variable, or the result of an operator, is known to have."""

NO_VALUE = Open("a variable without a value")
"""The value of a variable that is only declared."""


@dataclass(frozen=True)
class Either(Value):
    """One of several values; each is there once, and none is another choice."""

    options: tuple[Value, ...]

    def __post_init__(self) -> None:
        """Replace choices among the values by their own values."""
        object.__setattr__(self, "options", tuple(dict.fromkeys(_single(self.options))))


def _single(values: Sequence[Value]) -> Iterator[Value]:
    for each in values:
        yield from each.options if isinstance(each, Either) else (each,)


@dataclass(eq=False)
class Obj(Value):
    """An object of a class of the folder, or a node of rclcpp."""

    cls: ClassInfo | None
    fields: dict[str, Value] = field(default_factory=dict)
    node: NodeFact | None = None
    types: dict[str, str] = field(default_factory=dict)
    parameters: dict[str, Value] = field(default_factory=dict)
    unset: set[str] = field(default_factory=set)
    """Parameters that are declared without a value, and may have none."""
    made_at: int = 0
    """The expression that created it: evaluated again, it gives the same object."""
    made_by: int = 0
    """The same, with the calls that led to it."""
    policies: list[ClassInfo] = field(default_factory=list)
    """Its base classes that arguments of templates name."""
    is_held: bool = False
    """Whether a variable holds the object itself, and not a pointer to it: a list stores a copy."""


@dataclass(eq=False)
class Port(Value):
    """An entity of a node."""

    entity: Entity
    owner: Obj
    extra: list[Entity] = field(default_factory=list)
    methods: dict[str, Any] = field(default_factory=dict)


@dataclass(eq=False)
class Made(Value):
    """An object of a class of a library, or the result of a function of one."""

    path: str
    args: list[Value] = field(default_factory=list)
    fields: dict[str, Value] = field(default_factory=dict)
    effect: Effect | None = None
    node: Node | None = None


@dataclass(eq=False)
class Items(Value):
    """A list of values; `is_open`: there may be others. `kind`: the class of its items, if it is known.

    `of`: the name of their type. `keys`: of a map, the items of known keys.
    """

    values: list[Value] = field(default_factory=list)
    is_open: bool = False
    kind: ClassInfo | None = None
    of: str = ""
    keys: dict[object, Value] = field(default_factory=dict)
    is_map: bool = False
    """Whether it is a map, whose items are values, or pairs of a key and a value."""


@dataclass(eq=False)
class Frame:
    """Variables of a routine that runs."""

    path: str
    space: str
    this: Obj | None = None
    cls: ClassInfo | None = None
    values: dict[str, Value] = field(default_factory=dict)
    types: dict[str, str] = field(default_factory=dict)
    outer: Frame | None = None
    has_left: bool = False
    is_done: bool = False
    result: Value | None = None
    level: int = 0
    off: int = 0
    routine: Node | None = None


@dataclass(eq=False)
class Lambda(Value):
    """A lambda, with the variables around it."""

    node: Node
    frame: Frame


@dataclass(eq=False)
class Method(Value):
    """Methods or functions of one name; with the object, if it is bound, and bound arguments."""

    routines: list[Routine]
    name: str
    this: Obj | None = None
    args: list[Value] = field(default_factory=list)


@dataclass(eq=False)
class Todo:
    """A callback whose code is to be read."""

    fact: CallbackFact
    target: Value
    owner: Obj
    entity: Entity | None = None


def constant(value: Value | None) -> Any:
    """Return the value of a constant; None: not a constant."""
    return value.value if isinstance(value, (Const, Seconds)) else None


def shown(value: Value | None) -> str:
    """Return a value as a text of the facts: ``open: ...`` or with ``{...}`` where it is not known."""
    if isinstance(value, Const):
        return "true" if value.value is True else "false" if value.value is False else str(value.value)
    if isinstance(value, Open):
        return value.parts or f"open: {value.text}"
    if isinstance(value, Either):
        return "open: " + " or ".join(shown(each).removeprefix("open: ") for each in value.options)
    return "open"


def alternatives(name: Value) -> list[Const]:
    """Return the names that an entity may have, if there are several and all are known."""
    found = [each for each in options(name) if isinstance(each, Const) and isinstance(each.value, str)]
    return found if 1 < len(found) == len(options(name)) else []


def part(value: Value) -> str:
    """Return a value as a part of a text."""
    if isinstance(value, Const):
        return shown(value)
    if isinstance(value, Open) and value.parts:
        return value.parts
    words = value.text if isinstance(value, Open) else "value"
    return "{" + words.replace("{", "").replace("}", "")[:40] + "}"


def joined(old: Value | None, new: Value) -> Value:
    """Return the value of a variable that may have been assigned a new value."""
    if isinstance(old, Obj) and isinstance(new, Obj) and old is not new and is_same(old, new):
        for name, value in old.fields.items():  # what others gave it is not lost
            if new.fields.get(name) in (None, NO_VALUE, Const(None)):
                new.fields[name] = value
    if (
        old is None
        or old is new
        or old is NO_VALUE
        or is_same(old, new)
        or (isinstance(old, Const) and old.value in (None, ""))
    ):
        return new
    if new is NO_VALUE or (isinstance(new, Const) and new.value is None):
        return old
    is_object = isinstance(new, (Obj, Port, Made, Lambda, Method)) and not is_quality(new)
    if isinstance(old, Open) and is_object:
        return new
    found: list[Value] = []
    for each in (old, new):
        for option in each.options if isinstance(each, Either) else (each,):
            same = next((at for at, known in enumerate(found) if is_same(known, option)), None)
            if same is None:
                found.append(option)
            else:
                found[same] = option
    return Either(tuple(found)) if len(found) <= MOST_VALUES else Open("many values")


def one_of(values: Sequence[Value]) -> Value:
    """Return one of several values; the value itself if there is only one."""
    found = Either(tuple(values))
    return found.options[0] if len(found.options) == 1 else found


def is_quality(value: Value | None) -> bool:
    """Return whether a value is a quality of service, of `rclcpp` or of `rmw`."""
    last = value.path.rpartition("::")[2] if isinstance(value, Made) else ""
    return last.endswith("QoS") or last.startswith("rmw_qos_profile_")


def is_same(one: Value, other: Value) -> bool:
    """Return whether two values are equal, or objects of one expression."""
    if isinstance(one, Obj) and isinstance(other, Obj) and one.made_at:
        return one.cls is other.cls and one.made_at == other.made_at
    if isinstance(one, Port) and isinstance(other, Port):
        return one.entity is other.entity
    if isinstance(one, Made) and isinstance(other, Made) and one.path.endswith("Params") and one.fields:
        return one.fields.keys() == other.fields.keys() and all(
            is_same(each, other.fields[name]) for name, each in one.fields.items()
        )
    return one == other


def is_same_item(one: Value, other: Value) -> bool:
    """Return whether two items of a list are one: objects of one expression are not, if two calls run it."""
    if isinstance(one, Obj) and isinstance(other, Obj):
        return one is other or (is_same(one, other) and one.made_by == other.made_by)
    return is_same(one, other)


def members_of(value: Value) -> list[Value]:
    """Return the parts of a pair, a tuple or an object in the order of their declaration."""
    if isinstance(value, Obj) and value.cls is not None:
        return [value.fields.get(name, Open(name)) for name in value.cls.fields]
    return value.values if isinstance(value, Items) else value.args if isinstance(value, Made) else []


def value_of(item: Value) -> Value:
    """Return the value of an item of a map: the second part of a pair, or the item itself."""
    parts = item.values if isinstance(item, Items) else item.args if isinstance(item, Made) else []
    is_pair = isinstance(item, Items) or (isinstance(item, Made) and item.path.endswith(PAIRS))
    return parts[1] if is_pair and len(parts) == 2 else item


def node_in(value: Value | None, depth: int = 2) -> Obj | None:
    """Return the node that a value is or holds, as interfaces of a node do."""
    for each in options(value):
        if isinstance(each, Obj) and each.node is not None:
            return each
        if isinstance(each, Made) and depth and each.effect is None:
            found = next((one for arg in each.args if (one := node_in(arg, depth - 1)) is not None), None)
            if found is not None:
                return found
    return None


def options(value: Value | None) -> tuple[Value, ...]:
    """Return the possible values of a value."""
    if value is None:
        return ()
    return value.options if isinstance(value, Either) else (value,)
