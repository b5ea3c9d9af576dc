"""Tokens as messages of existing ROS interfaces: the model maps fields of messages to fields of tokens.

So a net can communicate with nodes without DiNeROS. Unmapped fields have the interface's default in sent
messages, and the token's default in received ones. Messages have no id field; `companions` transfers the ids.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from dineros.metamodel.errors import near_matches
from dineros.metamodel.token_data import FieldType, TokenType, Value
from dineros.runtime.nets.ports import Data, FieldMapping, Message
from dineros.runtime.ros.conversion.interfaces import InterfaceError, load_interface
from dineros.runtime.ros.conversion.messages import finite

_INTEGERS = {f"{sign}int{size}": (sign, size) for sign in ("", "u") for size in (8, 16, 32, 64)}
_KINDS = {"boolean": "boolean", "float": "number", "double": "number", "string": "text", "wstring": "text"}
_KINDS |= dict.fromkeys(_INTEGERS, "integer") | {"octet": "octet"}
# Conversions without loss of meaning; a number is rounded if it is stored as an integer.
_CARRIED = {("integer", "number"), ("number", "integer")}
_SEQUENCE = re.compile(r"sequence<(.+?)(?:, (\d+))?>")
_ARRAY = re.compile(r"(.+)\[(\d+)\]")
_STEP = re.compile(r"(\w+)(?:\[(\d+)\])?")


class ConversionError(InterfaceError):
    """A token's value does not fit the ROS field that should carry it."""


class _Step(NamedTuple):
    """A step of a path: a field, its index if it is an element, and a function that makes new elements."""

    name: str
    element: int | None
    make: Callable[[], Any] | None


class _Type(NamedTuple):
    """The type of a ROS field: the type of its elements, their fixed number, and their maximum number."""

    element: str
    is_list: bool
    length: int | None
    bound: int | None


class _Path(NamedTuple):
    """The path to a field of a message; the last step is the field itself."""

    steps: tuple[_Step, ...]
    type: _Type


class MappedCodec:
    """Converts between tokens and messages of an existing ROS interface.

    Parameters
    ----------
    interface : class
        Class of the message, or of a request or response.
    name : str
        Name of the interface, for messages.
    mappings : sequence of FieldMapping
        The mappings of this part of the interface.
    token_type : TokenType
        Type of the tokens.

    Raises
    ------
    InterfaceError
        A mapping names a field that does not exist, or that cannot carry the token's field.
    """

    def __init__(
        self, interface: Any, name: str, mappings: Sequence[FieldMapping], token_type: TokenType
    ) -> None:
        self._interface = interface
        self._fields = {field.name: field for field in token_type.fields}
        self._defaults: dict[str, Value] = {field.name: field.default for field in token_type.fields}
        self._mapped = [self._resolve(name, mapping) for mapping in mappings]

    def _resolve(self, name: str, mapping: FieldMapping) -> tuple[FieldType, _Path, str]:
        field = self._fields.get(mapping.token_field)
        if field is None:
            raise InterfaceError(f"the token type has no field {mapping.token_field!r}, which {name} maps")
        path = _path(self._interface, name, mapping.message_field)
        if not _carries(path.type, field):
            raise InterfaceError(
                f"{mapping.message_field} of {name} ({_shown(path.type)}) cannot carry the token field "
                f"{field.name!r} ({_field_kind(field)})",
                hint="map fields of the same kind",
            )
        return field, path, f"{name} {mapping.message_field}"

    def encode(self, message: Message) -> Any:
        """Return a token as a ROS message.

        Raises
        ------
        ConversionError
            A value is outside the range of its ROS field.
        """
        made = self._interface()
        for field, path, name in self._mapped:
            _set(made, path, _converted(message.data[field.name], path.type, name))
        return made

    def check(self, data: Data) -> None:
        """Check that a token with this data can be sent.

        Raises
        ------
        ConversionError
            A value is outside the range of its ROS field.
        """
        for field, path, name in self._mapped:
            try:
                _converted(data[field.name], path.type, name)
            except ConversionError as error:
                raise ConversionError(f"{field.name} cannot be sent: {error}") from None

    def decode(self, ros_message: Any) -> Message:
        """Return the token of a ROS message, without an id."""
        data = dict(self._defaults)
        for field, path, _ in self._mapped:
            value = _get(ros_message, path)
            if value is not None:
                data[field.name] = _token_value(value, field)
        return Message("", data)


def _path(interface: Any, name: str, text: str) -> _Path:
    """Return the path to the field in a text such as ``poses[0].position.x``."""
    steps = []
    names = text.split(".")
    for position, part in enumerate(names):
        match = _STEP.fullmatch(part)
        fields = interface.get_fields_and_field_types()
        if match is None or match[1] not in fields:
            raise InterfaceError(
                f"{name} has no field {'.'.join(names[: position + 1])}",
                hint=near_matches(match[1] if match else part, list(fields)),
            )
        type_ = _type(fields[match[1]])
        index = None if match[2] is None else int(match[2])
        if index is not None:
            limit = type_.length if type_.length is not None else type_.bound
            if not type_.is_list or (limit is not None and index >= limit):
                raise InterfaceError(f"{name} has no element {'.'.join(names[: position + 1])}")
            type_ = _Type(type_.element, False, None, None)
        element = type_.element.partition("<")[0]
        nested = None if element in _KINDS else load_interface(element.replace("/", "/msg/", 1))
        steps.append(_Step(match[1], index, nested or _maker(element)))
        if position + 1 < len(names):
            if type_.is_list or nested is None:
                raise InterfaceError(
                    f"{'.'.join(names[: position + 1])} of {name} has no fields",
                    hint="name an element, such as poses[0]" if type_.is_list else None,
                )
            interface = nested
    return _Path(tuple(steps), type_)


def _type(text: str) -> _Type:
    if match := _SEQUENCE.fullmatch(text):
        return _Type(match[1], True, None, int(match[2]) if match[2] else None)
    if match := _ARRAY.fullmatch(text):
        return _Type(match[1], True, int(match[2]), None)
    return _Type(text, False, None, None)


def _maker(element: str) -> Callable[[], Any]:
    kinds: dict[str, Callable[[], Any]] = {
        "boolean": bool,
        "number": float,
        "text": str,
        "octet": lambda: b"\0",
    }
    return kinds.get(_KINDS[element], int)


def _carries(type_: _Type, field: FieldType) -> bool:
    ros = _KINDS.get(type_.element.partition("<")[0])
    if field.kind == "map" or ros is None:
        return False
    if type_.is_list != (field.kind == "list"):
        return False
    if type_.length is not None and type_.length != field.length:
        return False
    kind = field.element_kind if type_.is_list else field.kind
    return ros == kind or (ros, kind) in _CARRIED or (ros, kind) == ("octet", "integer")


def _set(message: Any, path: _Path, value: Any) -> None:
    """Set the field at a path; missing elements of sequences are created."""
    *before, last = path.steps
    for step in before:
        inner = getattr(message, step.name)
        if step.element is not None:
            _lengthen(inner, step)
            inner = inner[step.element]
        message = inner
    if last.element is None:
        setattr(message, last.name, value)
    else:
        elements = getattr(message, last.name)
        _lengthen(elements, last)
        elements[last.element] = value


def _lengthen(elements: Any, step: _Step) -> None:
    assert step.element is not None
    assert step.make is not None
    while len(elements) <= step.element:
        elements.append(step.make())


def _get(message: Any, path: _Path) -> Any:
    """Return the value at a path; None: a sequence on the path is too short."""
    for step in path.steps:
        message = getattr(message, step.name)
        if step.element is not None:
            if len(message) <= step.element:
                return None
            message = message[step.element]
    return message


def _converted(value: Value, type_: _Type, name: str) -> Any:
    """Return the value of a token's field as the value of a ROS field."""
    if not type_.is_list:
        return _value(value, type_.element, name)
    assert isinstance(value, list)
    if type_.bound is not None and len(value) > type_.bound:
        raise ConversionError(f"{name} takes at most {type_.bound} elements, not {len(value)}")
    return [_value(element, type_.element, name) for element in value]


def _value(value: Value, ros_type: str, name: str) -> Any:
    """Return a token's value as a value of a ROS type; the message classes themselves check nothing."""
    base, _, bound = ros_type.partition("<")
    kind = _KINDS[base]
    if kind == "text":
        limit = bound.rstrip(">").lstrip("=")
        # Bounds are in units that the middleware stores: bytes of UTF-8, or units of UTF-16.
        length = len(str(value).encode("utf-16-le")) // 2 if base == "wstring" else len(str(value).encode())
        if limit and length > int(limit):
            unit = "characters" if base == "wstring" else "bytes"
            raise ConversionError(f"{name} takes at most {limit} {unit}, not {length}")
        return value
    if kind == "boolean":
        return value
    assert isinstance(value, (int, float))
    if kind == "number":
        if base == "float" and abs(value) > 3.4028234663852886e38:
            raise ConversionError(f"{name} takes a single-precision number, not {value}")
        return float(value)
    sign, size = ("u", 8) if kind == "octet" else _INTEGERS[base]
    number = round(value)
    low, high = (0, 2**size) if sign else (-(2 ** (size - 1)), 2 ** (size - 1))
    if not low <= number < high:
        raise ConversionError(f"{name} takes {base}, not {number}")
    return bytes([number]) if kind == "octet" else number


def _token_value(value: Any, field: FieldType) -> Value:
    if field.kind == "list":
        elements = value.tolist() if hasattr(value, "tolist") else list(value)
        return [_scalar(element, field.element_kind) for element in elements]
    return _scalar(value, field.kind)


def _scalar(value: Any, kind: str) -> Value:
    if isinstance(value, bytes):
        value = value[0]
    if kind == "number":
        return finite(float(value))
    if kind == "integer":
        return min(max(round(finite(value)), -(2**63)), 2**63 - 1)
    return bool(value) if kind == "boolean" else str(value)


def _shown(type_: _Type) -> str:
    if not type_.is_list:
        return type_.element
    return f"{type_.element}[{'' if type_.length is None else type_.length}]"


def _field_kind(field: FieldType) -> str:
    return f"{field.kind} of {field.element_kind}" if field.kind in ("list", "map") else field.kind
