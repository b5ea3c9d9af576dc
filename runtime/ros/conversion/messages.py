"""Tokens as messages: of the interface package generated from the model, or of installed packages.

Each field of the token type is a field of the message. Generated messages also have the message's id; so have
services whose tokens are installed messages. Values are already checked: values to send by the engine,
received values by the typed message.
"""

from __future__ import annotations

import math
import sys
from array import array
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from dineros.metamodel.ros_names import camel_case, interfaces_package, snake_case
from dineros.metamodel.token_data import FieldType, TokenType, Value
from dineros.runtime.nets.ports import Check, Message
from dineros.runtime.ros.conversion.interfaces import InterfaceError, load_interface

ARRAY_CODES = {"integer": "q", "number": "d", "int64": "q", "uint64": "Q", "int32": "i", "uint32": "I"}
ARRAY_CODES |= {"int16": "h", "uint16": "H", "int8": "b", "uint8": "B", "char": "B"}
ARRAY_CODES |= {"float32": "f", "float64": "d"}


class Codec(Protocol):
    """Converts messages of the net to ROS messages and back.

    Attributes
    ----------
    check : callable or None
        Raises an error for data that no ROS message can carry; None: all tokens can be sent.
    """

    @property
    def check(self) -> Check | None:  # noqa: D102
        ...

    def encode(self, message: Message) -> Any:
        """Return the ROS message."""

    def decode(self, ros_message: Any) -> Message:
        """Return the message."""


def token_interface(model: str, token_type: TokenType) -> str:
    """Return the name of the message that carries tokens of a type."""
    if token_type.ros is not None:
        return token_type.ros
    return f"{interfaces_package(model)}/msg/{camel_case(token_type.name)}"


def service_interface(model: str, channel: str) -> str:
    """Return the name of the type of a model's service."""
    return f"{interfaces_package(model)}/srv/{camel_case(channel)}"


def action_interface(model: str, channel: str) -> str:
    """Return the name of the type of a model's action."""
    return f"{interfaces_package(model)}/action/{camel_case(channel)}"


class TokenCodec:
    """Converts between tokens and their messages.

    Parameters
    ----------
    interface : class
        The message's class.
    model : str
        Id of the system model; its package has the messages for entries of maps.
    token_type : TokenType
        Type of the tokens.
    """

    def __init__(self, interface: Any, model: str, token_type: TokenType) -> None:
        self._interface = interface
        self.has_ids = token_type.ros is None
        there = interface.get_fields_and_field_types()
        case = snake_case if self.has_ids else str
        fields = [(field, case(field.name)) for field in token_type.fields]
        for name in [*(name for _, name in fields), *(["message_id"] if self.has_ids else [])]:
            if name not in there:
                package = interface.__module__.partition(".")[0]
                raise InterfaceError(
                    f"the message {package}/{interface.__name__} has no field {name}",
                    hint="it was generated from another version of the model: generate and build it again",
                )
        self._encoders = [(field.name, name, _encoder(field, model)) for field, name in fields]
        self._decoders = [(field.name, name, _decoder(field)) for field, name in fields]

    check = None  # message and token have the same fields

    def encode(self, message: Message) -> Any:
        """Return a token as a ROS message."""
        made = self._interface()
        data = message.data
        for field, name, convert in self._encoders:
            value = data[field]
            setattr(made, name, convert(value) if convert else value)
        if self.has_ids:
            made.message_id = message.id
        return made

    def decode(self, ros_message: Any) -> Message:
        """Return the token of a ROS message; an installed message has no id."""
        data: dict[str, Value] = {}
        for field, name, convert in self._decoders:
            value = getattr(ros_message, name)
            data[field] = convert(value) if convert else value
        return Message(ros_message.message_id if self.has_ids else "", data)


class PartCodec:
    """Converts between tokens and the parts of a generated service or action.

    Each part contains a token. A part of a service has an id if its token has none, because it is an
    installed message; a part of an action has none, since the goal has an id.

    Parameters
    ----------
    interface : class
        The class of the part, such as the request or the feedback.
    token : TokenCodec
        Converts what it holds.
    Converts the token in the part.
    """

    def __init__(self, interface: Any, token: TokenCodec) -> None:
        self._interface = interface
        self._token = token
        self._has_id = "message_id" in interface.get_fields_and_field_types()

    check = None

    def encode(self, message: Message) -> Any:
        """Return the part for a token."""
        made = self._interface()
        made.token = self._token.encode(message)
        if self._has_id:
            made.message_id = message.id
        return made

    def decode(self, ros_message: Any) -> Message:
        """Return the token of a part."""
        message = self._token.decode(ros_message.token)
        return Message(ros_message.message_id, message.data) if self._has_id else message


def finite(value: float) -> float:
    """Return a number that a token can carry: the largest one for infinity, 0 for NaN.

    Sensors report "nothing in range" as infinity, which JSON, and therefore a journal, does not have.
    """
    if math.isfinite(value):
        return value
    return 0.0 if math.isnan(value) else math.copysign(sys.float_info.max, value)


_Conversion = Callable[[Any], Any]


def _encoder(field: FieldType, model: str) -> _Conversion | None:
    if field.kind == "map":
        entry = load_interface(f"{interfaces_package(model)}/msg/{field.element_kind.capitalize()}Entry")

        def entries(value: Mapping[str, Value]) -> list[Any]:
            return [entry(key=key, value=element) for key, element in value.items()]

        return entries
    single = _single_encoder(field, model)
    if field.kind != "list":
        return single
    code = ARRAY_CODES.get(field.ros or field.element_kind)
    if code is not None and field.length is None:
        return lambda value: array(code, value)
    if code is not None:
        import numpy

        return lambda value: numpy.array(value, dtype=code)
    return list if single is None else lambda value: [single(element) for element in value]


def _single_encoder(field: FieldType, model: str) -> _Conversion | None:
    if field.ros == "byte":
        return lambda value: bytes([value])
    if field.scalar != "record":
        return None
    interface = load_interface(str(field.ros))
    parts = [(part.name, _encoder(part, model)) for part in field.fields]

    def message(value: Mapping[str, Value]) -> Any:
        made = interface()
        for name, convert in parts:
            setattr(made, name, convert(value[name]) if convert else value[name])
        return made

    return message


def _decoder(field: FieldType) -> _Conversion | None:
    single = _single_decoder(field)
    if field.kind == "map":
        if single is None:
            return lambda value: {entry.key: entry.value for entry in value}
        return lambda value: {entry.key: single(entry.value) for entry in value}
    if field.kind != "list":
        return single
    # Arrays of the standard library and of numpy have `tolist`; those of bool, str and others are lists.
    if single is None:
        return lambda value: value.tolist() if hasattr(value, "tolist") else list(value)
    return lambda value: [single(each) for each in (value.tolist() if hasattr(value, "tolist") else value)]


def _single_decoder(field: FieldType) -> _Conversion | None:
    if field.ros == "byte":
        return lambda value: value[0]
    if field.scalar == "number":
        return finite
    if field.scalar != "record":
        return None
    parts = [(part.name, _decoder(part)) for part in field.fields]

    def record(value: Any) -> dict[str, Value]:
        return {
            name: convert(getattr(value, name)) if convert else getattr(value, name)
            for name, convert in parts
        }

    return record
