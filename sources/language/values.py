"""Partly known values of expressions of a program."""

from __future__ import annotations

import ast
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from math import prod
from typing import TYPE_CHECKING, Any

from dineros.sources.facts import CallbackFact, Effect, Entity, NodeFact
from dineros.sources.language.order import look_up_order
from dineros.sources.places import Place

if TYPE_CHECKING:
    from dineros.sources.language.modules import Module


class Value:
    """Any value."""


@dataclass(eq=False)
class Open(Value):
    """An unknown value."""

    text: str = "?"
    """Its text in the code."""


@dataclass(eq=False)
class Message(Open):
    """What the callback of a subscription receives."""

    entity: Entity | None = None


@dataclass(eq=False)
class Response(Open):
    """The response of a service: what its callback makes, or what a client gets by a call."""

    effect: Effect | None = None


SETTINGS = ("parameter", "environment", "option")
"""How the origin of a value begins that people can set from outside."""


@dataclass(eq=False)
class SomeFunction(Open):
    """An unknown function of the program, which may do anything that its node can."""


@dataclass(eq=False)
class Const(Value):
    """A constant."""

    value: Any
    """Number, text, truth value, or None."""
    origin: str = ""
    """Empty for a literal. Otherwise its origin, if it may have another value in other runs: ``variable``,
    ``parameter NAME``, ``environment NAME``, ``option NAME`` (of the command line).
    """
    enum: Class | None = None
    """The enumeration whose member it is."""

    @property
    def is_setting(self) -> bool:
        """Whether users can set it."""
        return self.origin.startswith(SETTINGS)


@dataclass(eq=False)
class Text(Value):
    """A string with unknown parts, which are in braces."""

    text: str


QUEUE = "queue"
"""Kind of a queue between threads."""


@dataclass(eq=False)
class Items(Value):
    """A list, tuple, set or queue."""

    items: list[Value]
    """As far as known."""
    is_open: bool = False
    """Whether there may be others, or another order."""
    kind: str = "list"
    name: str = ""
    """The variable that holds a queue."""
    is_bounded: bool = False
    """Whether a queue may be full."""


@dataclass(eq=False)
class Mapping(Value):
    """A dictionary."""

    items: dict[Any, Value] = field(default_factory=dict)
    rest: list[Value] = field(default_factory=list)
    is_open: bool = False
    factory: Value | None = None
    """Makes the missing values of a ``defaultdict``."""
    holder: Holder | None = None
    """Whose ``__dict__`` it is."""


@dataclass(eq=False)
class Frame:
    """Variables of a function, of a module, or of the body of a class."""

    module: Module
    names: dict[str, Value] = field(default_factory=dict)
    outer: Frame | None = None
    globals: set[str] = field(default_factory=set)
    nonlocals: set[str] = field(default_factory=set)
    function: Function | None = None
    instance: Value | None = None
    returns: list[Value] = field(default_factory=list)
    holder: Holder | None = None  # of a module: its variables


@dataclass(eq=False)
class Function(Value):
    """A function, method or lambda of the program.

    `original`: the function that decorators of the program have replaced by this one.
    """

    node: ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda
    frame: Frame
    owner: Class | None = None
    defaults: dict[str, Value] = field(default_factory=dict)
    decorators: tuple[str, ...] = ()
    original: Function | None = None
    registered: list[Value] = field(default_factory=list)
    """Of ``functools.singledispatch``: the functions for other types."""
    attributes: dict[str, Value] = field(default_factory=dict)
    """What code has set as ``function.name``."""
    around: tuple[Value, ...] = ()
    """The managers that decorators enter around each call."""

    @property
    def name(self) -> str:
        """Its name; ``lambda``."""
        return "lambda" if isinstance(self.node, ast.Lambda) else self.node.name

    @property
    def code(self) -> ast.AST:
        """What distinguishes it from other functions: one decorator makes many functions of one text."""
        return self.node if self.original is None else self.original.node


@dataclass(eq=False)
class Generator(Value):
    """What a call of a function with ``yield`` gives: its body runs when something asks for values."""

    function: Function
    args: list[Value]
    keys: dict[str, Value]
    instance: Value | None


@dataclass(eq=False)
class LateItems(Value):
    """What ``(run() for run in jobs)`` gives: it runs when something asks for values."""

    node: ast.GeneratorExp
    frame: Frame


@dataclass(eq=False)
class Class(Value):
    """A class of the program."""

    node: ast.ClassDef
    frame: Frame
    bases: list[Value] = field(default_factory=list)
    names: dict[str, Value] = field(default_factory=dict)
    meta: Class | None = None
    subclasses: list[Class] = field(default_factory=list)

    def order(self) -> list[Value]:
        """Return the class and its bases in the order of look-up; without repetition, those outside last."""
        return [*self.inside, *self._order[len(self.inside) :]]

    @cached_property
    def inside(self) -> list[Class]:
        """The class and its bases in the folder, in the order of look-up; bases do not change."""
        return [each for each in self._order if isinstance(each, Class)]

    @cached_property
    def _order(self) -> list[Value]:
        found: list[Value] = look_up_order(self, _bases, _class_key)
        return [*(e for e in found if isinstance(e, Class)), *(e for e in found if not isinstance(e, Class))]

    def outside(self) -> list[str]:
        """Return the dotted names of the bases that are not in the folder."""
        return [each.path for each in self.order() if isinstance(each, Outside)]

    @cached_property
    def own_reading(self) -> Function | None:
        """Its ``__getattribute__``, if it has one."""
        found = next(
            (each.names["__getattribute__"] for each in self.inside if "__getattribute__" in each.names), None
        )
        return found if isinstance(found, Function) else None

    def is_enum(self) -> bool:
        """Return whether it is an enumeration."""
        return any(path.startswith("enum.") for path in self.outside())

    def is_complete(self) -> bool:
        """Return whether every base is known, if only by name."""
        return all(isinstance(each, (Class, Outside)) for each in self.order())


def _bases(value: Value) -> list[Value]:
    return value.bases if isinstance(value, Class) else []


def _class_key(value: Value) -> Hashable:
    return value.path if isinstance(value, Outside) else id(value)


@dataclass(eq=False, slots=True)
class Slot:
    """An attribute of an object, or a variable of a module: its current value, and all that it has had.

    `is_perhaps`: it may also have what the object was made with; `is_off`: it has, for certain; `is_setting`:
    people can set one of its values. Results that depend on all values are cached until a value is added, as
    each callback reads most attributes.
    """

    current: Value
    run: int
    is_perhaps: bool = False
    is_off: bool = False
    values: list[Value] = field(default_factory=list)
    is_setting: bool = False
    is_late: bool = False
    """Whether its object was made before, without it."""
    is_mixed: bool = False
    """Whether the value of this run may still be the one from before."""
    _joined: Value | None = field(default=None, init=False)
    _holders: list[Port | Object] | None = field(default=None, init=False)

    def add(self, value: Value, most: int, name: str) -> bool:
        """Add a value, and return whether it is new; if there are more than `most`, the attribute is open."""
        self.is_setting |= isinstance(value, Const) and value.is_setting
        if any(same(value, each) for each in self.values):
            return False
        self.values = [Open(name)] if len(self.values) >= most else [*self.values, value]
        self._joined = self._holders = None
        return True

    def any(self) -> Value:
        """Return a value that stands for all that the attribute has had."""
        if self._joined is None:
            self._joined = join(self.values)
        return self._joined

    def holders(self) -> list[Port | Object]:
        """Return the ports, and the objects that may have ports, among the values."""
        if self._holders is None:
            found = [each for value in self.values for each in options(value)]
            self._holders = [each for each in found if isinstance(each, (Port, Object))]
        return self._holders


class Holder(Value):
    """A value with attributes."""

    def __init__(self) -> None:
        self.slots: dict[str, Slot] = {}


class Object(Holder):
    """An instance of a class of the program."""

    def __init__(self, cls: Class, at: Place) -> None:
        super().__init__()
        self.cls = cls
        self.at = at
        self.node: NodeFact | None = None
        self.made: Made | None = None
        self.name = ""
        self.run = 0  # in which it was made


class Made(Holder):
    """The result of a call outside of the folder: a profile, a group, a thread, an unknown value."""

    def __init__(self, path: str, args: list[Value], keys: dict[str, Value], at: Place) -> None:
        super().__init__()
        self.path = path
        self.args = args
        self.keys = keys
        self.at = at
        self.name = ""
        self.entity: Entity | None = None
        self.nodes: list[NodeFact] = []
        self.enum: Class | None = None  # whose member it is
        self.level = 0  # number of branches around the call
        self.effect: Effect | None = None

    def argument(self, index: int, *names: str) -> Value | None:
        """Return an argument by its place or one of its names."""
        for name in names:
            if name in self.keys:
                return self.keys[name]
        return self.args[index] if 0 <= index < len(self.args) else None


@dataclass(eq=False)
class ModuleValue(Value):
    """A module of the folder."""

    module: Module


@dataclass(eq=False)
class Outside(Value):
    """Something that is not in the folder: module, class, function or constant, by its dotted name."""

    path: str
    is_star: bool = False
    """Whether all names of its module are imported, so that another module may have it."""


@dataclass(eq=False)
class Bound(Value):
    """A method of the program with its instance."""

    function: Function
    instance: Value


@dataclass(eq=False)
class OutsideMethod(Value):
    """A method that no class of the program has: of a library, on a value; `at`: where the code names it."""

    instance: Value
    name: str
    text: str = ""
    at: Place | None = None

    @property
    def is_followed(self) -> bool:
        """Whether all that a call of it does is known: of a container, a queue, an event."""
        value = self.instance
        is_event = isinstance(value, Made) and value.path.rpartition(".")[2] in ("Event", "Semaphore")
        return self.at is not None and (is_event or isinstance(value, (Items, Mapping)))


@dataclass(eq=False)
class Partial(Value):
    """``functools.partial``."""

    function: Value
    args: list[Value]
    keys: dict[str, Value]


@dataclass(eq=False)
class Port(Value):
    """A publisher, client, timer and so on, in the hands of the program."""

    entity: Entity
    node: NodeFact | None


@dataclass(eq=False)
class RunningNode(Holder):
    """A node that is not an instance of a class of the program: made by ``rclpy.create_node``."""

    fact: NodeFact

    def __post_init__(self) -> None:
        super().__init__()


@dataclass(eq=False)
class Future(Value):
    """The result of an asynchronous call."""

    of: str
    """``call``, ``goal``, ``result``, ``cancel``, ``task``."""
    effect: Effect | None = None
    entity: Entity | None = None


@dataclass(eq=False)
class Goal(Value):
    """A goal in the hands of a client or of a server."""

    side: str
    entity: Entity | None = None


@dataclass(eq=False)
class SuperOf(Value):
    """``super()``: look-up begins after a class."""

    instance: Value
    cls: Class


@dataclass(eq=False)
class Either(Value):
    """One of several values."""

    options: list[Value]


@dataclass(eq=False)
class Callback:
    """A callback that is to be read: a function with its arguments."""

    function: Value
    fact: CallbackFact
    node: NodeFact | None
    args: list[Value]
    parent: Callback | None = None
    again: Callback | None = None

    def first(self) -> Callback:
        """Return the callback whose entities this one makes again: itself, or an earlier turn."""
        return self if self.again is None else self.again.first()


NONE = Const(None)


def join(values: Iterable[Value | None]) -> Value:
    """Return a value that stands for any of several."""
    values = list(values)
    one = values[0] if values else None
    if one is not None and (
        len(values) == 1 or values.count(one) == len(values)
    ):  # these compare by identity
        return one
    found: dict[Hashable, Value] = {}
    for value in values:
        for each in value.options if isinstance(value, Either) else [value]:
            if each is not None:
                found.setdefault(identity(each), each)
                if len(found) > MOST_OPTIONS:
                    return _many(found.values())
    if not found:
        return NONE
    first = next(iter(found.values()))
    return first if len(found) == 1 else Either(list(found.values()))


def _many(values: Iterable[Value]) -> Open:
    """Return what stands for any of many values."""
    has_code = any(isinstance(each, (Function, Bound, Partial, SomeFunction)) for each in values)
    return SomeFunction("many functions") if has_code else Open("many values")


def spread(values: list[Value], made: Callable[[list[Value]], Value]) -> Value:
    """Return what is made of values of which some are one of several constants: one of several, too."""
    choices = [
        each.options
        if isinstance(each, Either) and all(isinstance(option, (Const, Text)) for option in each.options)
        else [each]
        for each in values
    ]
    if prod(map(len, choices)) > MOST_OPTIONS:
        return made(values)
    return join(made(list(each)) for each in product(*choices))


_PLAIN = (str, int, float, complex, bytes, type(None))
MOST_OPTIONS = 24
"""Limit of the values of one variable."""


def key_of(value: Value) -> Any:
    """Return the representation of a value as a key of a dictionary; None: not known exactly."""
    if isinstance(value, Const):
        return value.value if isinstance(value.value, (str, int, float, bool, bytes)) else None
    return value if isinstance(value, (Object, Class, Port, RunningNode)) else None


def of_key(key: Any) -> Value:
    """Return the value of a key of a dictionary."""
    return key if isinstance(key, Value) else Const(key)


def same(one: Value, other: Value) -> bool:
    """Return whether two values are certainly the same."""
    return one is other or identity(one) == identity(other)


def identity(value: Value) -> Hashable:
    """Return a key that two values share if they are certainly the same."""
    of_type = _IDENTITIES.get(type(value))
    return id(value) if of_type is None else of_type(value)


def _of_constant(value: Const) -> Hashable:
    known = value.value
    return type(known), known if isinstance(known, _PLAIN) else id(known)


def _of_unknown(value: Open) -> Hashable:
    return type(value), value.text, id(getattr(value, "effect", None))


_IDENTITIES: dict[type[Value], Callable[[Any], Hashable]] = {
    Const: _of_constant,
    **dict.fromkeys((Open, Message, Response, SomeFunction), _of_unknown),
    Text: lambda value: (Text, value.text),
    Outside: lambda value: (Outside, value.path, value.is_star),
    Bound: lambda value: (Bound, id(value.function), id(value.instance)),
    Port: lambda value: (Port, id(value.entity)),
    Goal: lambda value: (Goal, value.side, id(value.entity)),
    Future: lambda value: (Future, value.of, id(value.effect), id(value.entity)),
}
"""The keys of values that are the same although they are other objects, by type."""


def options(value: Value | None) -> list[Value]:
    """Return the possible values of a value."""
    if value is None:
        return []
    return value.options if isinstance(value, Either) else [value]


def is_none(value: Value | None) -> bool:
    """Return whether a value is missing, or None."""
    return value is None or (isinstance(value, Const) and value.value is None)


def constant(value: Value | None) -> Any:
    """Return the value of a constant; None: not a constant."""
    return value.value if isinstance(value, Const) else None


def text_of(value: Value | None) -> str:
    """Return a value as a text of the facts: unknown parts are open, or in braces."""
    if isinstance(value, Const):
        return str(value.value)
    if isinstance(value, Text):
        return value.text
    if isinstance(value, Either):
        known = [str(each.value) for each in value.options if isinstance(each, Const)]
        return "open: " + (" or ".join(known) if len(known) == len(value.options) else "several values")
    return f"open: {value.text}" if isinstance(value, (Open, OutsideMethod)) else "open"


def hole(value: Value | None) -> str:
    """Return a value as a part of a text."""
    if isinstance(value, Const):
        return str(value.value)
    if isinstance(value, Text):
        return value.text
    name = value.text if isinstance(value, (Open, OutsideMethod)) else "?"
    return "{" + name.replace("{", "(").replace("}", ")") + "}"
