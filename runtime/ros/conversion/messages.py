"""Tokens as messages of the interface package that is generated from the model.

Every field of the token type is a field of the message; the last field is the message's id. Values were
checked before they come here: what a node sends by its engine, what it receives by the typed message.
"""

from __future__ import annotations

import math
import sys
from array import array
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from dineros.metamodel.ros_names import camel_case, interfaces_package, snake_case
from dineros.metamodel.token_data import Value
from dineros.runtime.nets.ports import Check, FieldType, Message, TokenType
from dineros.runtime.ros.conversion.interfaces import InterfaceError, load_interface

ARRAY_CODES = {"integer": "q", "number": "d"}


class Codec(Protocol):
    """Turns messages of the net into ROS messages and back.

    Attributes
    ----------
    check : callable or None
        Raises an error for data that no ROS message can carry; None: every token can be sent.
    """

    @property
    def check(self) -> Check | None:  # noqa: D102
        ...

    def encode(self, message: Message) -> Any:
        """Return the ROS message."""

    def decode(self, ros_message: Any) -> Message:
        """Return the message."""


def token_interface(model: str, token_type: TokenType) -> str:
    """Return the name of the message that carries the tokens of a model."""
    return f"{interfaces_package(model)}/msg/{camel_case(token_type.name)}"


def service_interface(model: str, channel: str) -> str:
    """Return the name of the type of a model's service."""
    return f"{interfaces_package(model)}/srv/{camel_case(channel)}"


class TokenCodec:
    """Converts tokens and messages of the generated interface.

    Parameters
    ----------
    interface : class
        The message's class.
    model : str
        Id of the system model, whose package holds the entries of maps.
    token_type : TokenType
        What tokens carry.
    """

    def __init__(self, interface: Any, model: str, token_type: TokenType) -> None:
        self._interface = interface
        there = interface.get_fields_and_field_types()
        fields = [(field, snake_case(field.name)) for field in token_type.fields]
        for name in [*(name for _, name in fields), "message_id"]:
            if name not in there:
                package = interface.__module__.partition(".")[0]
                raise InterfaceError(
                    f"the message {package}/{interface.__name__} has no field {name}",
                    hint="it was made from another version of the model: generate and build it again",
                )
        self._encoders = [(field.name, name, _encoder(field, model)) for field, name in fields]
        self._decoders = [(field.name, name, _decoder(field)) for field, name in fields]

    check = None  # the fields of the message are those of the token

    def encode(self, message: Message) -> Any:
        """Return a token as a ROS message."""
        made = self._interface()
        data = message.data
        for field, name, convert in self._encoders:
            value = data[field]
            setattr(made, name, convert(value) if convert else value)
        made.message_id = message.id
        return made

    def decode(self, ros_message: Any) -> Message:
        """Return a ROS message as a token."""
        data: dict[str, Value] = {}
        for field, name, convert in self._decoders:
            value = getattr(ros_message, name)
            data[field] = convert(value) if convert else value
        return Message(ros_message.message_id, data)


class PartCodec:
    """Converts tokens and the parts of a generated service: each holds a token as its only field.

    Parameters
    ----------
    interface : class
        The request's or response's class.
    token : TokenCodec
        Converts what it holds.
    """

    def __init__(self, interface: Any, token: TokenCodec) -> None:
        self._interface = interface
        self._token = token

    check = None

    def encode(self, message: Message) -> Any:
        """Return a token as a request or response."""
        made = self._interface()
        made.token = self._token.encode(message)
        return made

    def decode(self, ros_message: Any) -> Message:
        """Return a request or response as a token."""
        return self._token.decode(ros_message.token)


def finite(value: float) -> float:
    """Return a number that a token can carry: for infinity the largest one there is, 0 for what is no number.

    Sensors say "nothing within reach" with infinity; JSON, and so a journal, cannot.
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
    if field.kind == "list":
        code = ARRAY_CODES.get(field.element_kind)
        if code is None:
            return list
        if field.length is None:
            return lambda value: array(code, value)
        import numpy

        return lambda value: numpy.array(value, dtype=code)
    return None


def _decoder(field: FieldType) -> _Conversion | None:
    is_number = "number" in (field.kind, field.element_kind)
    if field.kind == "map":
        if is_number:
            return lambda value: {entry.key: finite(entry.value) for entry in value}
        return lambda value: {entry.key: entry.value for entry in value}
    if field.kind == "list":
        if is_number:
            return lambda value: [finite(element) for element in value.tolist()]
        # Arrays of the standard library and of numpy both have it; bool and str arrays are lists.
        return lambda value: value.tolist() if hasattr(value, "tolist") else list(value)
    return finite if is_number else None
