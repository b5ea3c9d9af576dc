"""The commands that change a model, and how they are read from untrusted data.

A command refers to objects by their handles (`handles`), or by a name that begins with ``$`` for an object
that an earlier command of the same group made. Groups are executed completely or not at all.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar, get_args

from dineros.metamodel.errors import DinerosError, near_matches

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

MOST_COMMANDS = 5_000
"""Maximum number of commands in a group."""

LONGEST_TEXT = 65_536
"""Maximum length of a name, a value, or the text of a clause, in characters."""

MOST_POINTS = 200
"""Maximum number of bend points of an arc."""

Value: TypeAlias = str | int | float | bool | None
"""Value of a feature: that of an attribute, the name of a literal, a handle, or None."""


class CommandError(DinerosError):
    """A command cannot be executed; the model is unchanged."""


@dataclass(frozen=True)
class Create:
    """Make an object in a containment of another object.

    Attributes
    ----------
    owner : str
        The object that contains it.
    feature : str
        The containment feature.
    type : str
        The class, such as ``sym.Place``.
    values : mapping of str to value
        Its attributes and single references; without an id, one is derived from the name of the class.
    index : int or None
        Position in the containment; None: at the end.
    called : str or None
        A name such as ``$p`` by which later commands of the group refer to it.
    """

    owner: str
    feature: str
    type: str
    values: Mapping[str, Value] = field(default_factory=dict)
    index: int | None = None
    called: str | None = None


@dataclass(frozen=True)
class Delete:
    """Delete objects with their parts, and objects that depend on them, such as a place's arcs."""

    elements: tuple[str, ...]


@dataclass(frozen=True)
class Set:
    """Set an attribute or a single reference; None means the default, or no object.

    A new name or id of a signal or token field is changed at all its uses, including clauses.
    """

    element: str
    feature: str
    value: Value


@dataclass(frozen=True)
class Add:
    """Add an object to a many-valued reference; `index` None: at the end."""

    element: str
    feature: str
    target: str
    index: int | None = None


@dataclass(frozen=True)
class Remove:
    """Remove an object from a many-valued reference."""

    element: str
    feature: str
    target: str


@dataclass(frozen=True)
class Place:
    """Move an object into another containment, or to another position in its own.

    `index` does not count the object itself; None: at the end.
    """

    element: str
    owner: str
    feature: str
    index: int | None = None


@dataclass(frozen=True)
class Move:
    """Move the centre of an element to a point of its page."""

    element: str
    x: float
    y: float


@dataclass(frozen=True)
class Bend:
    """Set the bend points of an arc; empty: a straight line."""

    element: str
    points: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Clause:
    """Set the clause of a transition: a Boolean expression over its node's signals; None: no clause."""

    element: str
    text: str | None


Command: TypeAlias = Create | Delete | Set | Add | Remove | Place | Move | Bend | Clause


def kind_of(cls: type[object]) -> str:
    """Return the name of a command in messages: its class, in lower case."""
    return cls.__name__.lower()


KINDS: dict[str, type[Command]] = {kind_of(each): each for each in get_args(Command)}
"""All commands, by their names in messages."""


def decode_commands(found: object) -> list[Command]:
    """Read a group of commands from JSON values, such as ``[{"kind": "move", "element": "e3", ...}]``.

    Raises
    ------
    CommandError
        It is not a list of commands, or too long; the message names the command and the field.
    """
    if not isinstance(found, list):
        raise CommandError("a group is a list of commands")
    if not 0 < len(found) <= MOST_COMMANDS:
        raise CommandError(f"a group has 1 to {MOST_COMMANDS} commands, not {len(found)}")
    return [decode(each, KINDS, f"command {number}") for number, each in enumerate(found, 1)]


def encode_command(command: Command) -> dict[str, Any]:
    """Return a command as JSON values."""
    values = {each.name: getattr(command, each.name) for each in dataclasses.fields(command)}
    return {"kind": kind_of(type(command)), **{name: _plain(value) for name, value in values.items()}}


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return dict(value)
    return [_plain(each) for each in value] if isinstance(value, tuple) else value


K = TypeVar("K", bound="DataclassInstance")


def decode(found: object, kinds: Mapping[str, type[K]], what: str) -> K:
    """Read one of several dataclasses from JSON values; `what` describes it in errors.

    Raises
    ------
    CommandError
        Kind, fields or values do not match any of the dataclasses.
    """
    if not isinstance(found, dict):
        raise CommandError(f"{what} is not an object")
    name = found.get("kind")
    kind = kinds.get(name) if isinstance(name, str) else None
    if kind is None:
        hint = near_matches(name[:100], kinds) if isinstance(name, str) else None
        raise CommandError(f"{what} has an unknown kind", hint=hint or f"kinds: {', '.join(kinds)}")
    called, fields = kind_of(kind), {each.name: each for each in dataclasses.fields(kind)}
    for given in found:
        if given != "kind" and given not in fields:
            known = near_matches(given[:100], fields)
            raise CommandError(f"{called} has no field {given[:100]!r}", hint=known)
    values: dict[str, Any] = {}
    for each in fields.values():
        if each.name not in found:
            if each.default is dataclasses.MISSING and each.default_factory is dataclasses.MISSING:
                raise CommandError(f"{called} needs {each.name}")
            continue
        read = _READ[str(each.type)]
        try:
            values[each.name] = read(found[each.name])
        except ValueError as error:
            raise CommandError(f"{each.name} of {called} {error}") from None
    return kind(**values)


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise ValueError("is a text")
    if len(value) > LONGEST_TEXT:
        raise ValueError(f"has more than {LONGEST_TEXT} characters")
    return value


def _texts(value: object) -> tuple[str, ...]:
    if not isinstance(value, list) or not 0 < len(value) <= MOST_COMMANDS:
        raise ValueError(f"is a list of 1 to {MOST_COMMANDS} texts")
    return tuple(map(_text, value))


def _number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError("is a number")
    if not math.isfinite(value) or abs(value) > 1e9:
        raise ValueError("is a number of at most 1e9")
    return float(value)


def _index(value: object) -> int | None:
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**31:
        raise ValueError("is a number from 0 on")
    return value


def _value(value: object) -> Value:
    if isinstance(value, str):
        return _text(value)
    if value is None or isinstance(value, bool | int | float):
        return value
    raise ValueError("is a text, a number, true, false or null")


def _values(value: object) -> dict[str, Value]:
    if not isinstance(value, dict):
        raise ValueError("is an object")
    return {name: _value(each) for name, each in value.items()}


def _points(value: object) -> tuple[tuple[float, float], ...]:
    if not isinstance(value, list) or len(value) > MOST_POINTS:
        raise ValueError(f"is a list of at most {MOST_POINTS} points")
    if any(not isinstance(each, list) or len(each) != 2 for each in value):
        raise ValueError("is a list of pairs of numbers")
    return tuple((_number(x), _number(y)) for x, y in value)


def _or_none(read: Callable[[object], str]) -> Callable[[object], str | None]:
    return lambda value: None if value is None else read(value)


_READ: dict[str, Callable[[object], object]] = {
    "str": _text,
    "str | None": _or_none(_text),
    "tuple[str, ...]": _texts,
    "float": _number,
    "int | None": _index,
    "Value": _value,
    "Mapping[str, Value]": _values,
    "tuple[tuple[float, float], ...]": _points,
}
