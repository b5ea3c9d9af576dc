"""What a model's tokens look like as ROS 2 messages and services (ROS 2 design, "Interface definition").

Field kinds become ``string``, ``int64``, ``float64``, ``bool``; a list becomes an array, of fixed length
where the token type says so; a map becomes an array of entries. Every message ends with the id of the
message, by which a node recognises what it has received before.
"""

from __future__ import annotations

import json
from dataclasses import dataclass

from dineros.generators.application.naming import (
    NOTHING_RESERVED,
    NamingError,
    Reserved,
    interface,
    message_fields,
    require_own_packages,
)
from dineros.generators.templates.filters import Name, Written
from dineros.metamodel import sym
from dineros.metamodel.elements import label
from dineros.metamodel.ros_names import camel_case, interfaces_package
from dineros.metamodel.token_data import Value, field_value, read_json

ROS_TYPES = {"text": "string", "integer": "int64", "number": "float64", "boolean": "bool"}
PYTHON_TYPES = {"text": "str", "integer": "int", "number": "float", "boolean": "bool"}
_EMPTY: dict[str, Value] = {"text": "", "integer": 0, "number": 0.0, "boolean": False}


@dataclass(frozen=True)
class Field:
    """A field of the token type.

    Attributes
    ----------
    name, message_name : str
        Its names in the model and in messages.
    kind : str
        In words: ``text``, ``list of 6 number``, ``map of text``.
    python_type, ros_type : str
        Its types in handlers and in messages.
    default : Value
        Its value where a token says nothing else.
    ros_default : str
        The default as the interface definition writes it; empty where it needs none or cannot say it.
    """

    name: str
    message_name: Name
    kind: str
    python_type: Written
    ros_type: Written
    default: Value
    ros_default: Written


@dataclass(frozen=True)
class Interfaces:
    """The interface package of a model.

    Attributes
    ----------
    package : str
        Its name.
    token : str
        Name of the message that carries a token, and of the type that handlers see.
    fields : tuple of Field
        What a token carries.
    entries : tuple of (str, str)
        Messages for the entries of maps: name, and ROS type of the value.
    services : tuple of str
        Names of the service types.
    """

    package: Name
    token: Name
    fields: tuple[Field, ...]
    entries: tuple[tuple[Name, Written], ...]
    services: tuple[Name, ...]

    @property
    def files(self) -> list[str]:
        """The interface files, as CMake wants them."""
        messages = [f"msg/{name}.msg" for name in (self.token, *(name for name, _ in self.entries))]
        return [*messages, *(f"srv/{name}.srv" for name in self.services)]


def token_name(token_type: sym.TokenType | None) -> str:
    """Return the name of the message that carries a token."""
    return camel_case(label(token_type)) if token_type else "Token"


def service_name(channel: str) -> str:
    """Return the name of a service's type, by the id of its channel."""
    return camel_case(channel)


def interfaces_of(model: sym.SystemModel, reserved: Reserved = NOTHING_RESERVED) -> Interfaces:
    """Return the interface package of a model, no name of which hides one of `reserved`.

    Raises
    ------
    NamingError
        Names of the model collide in ROS.
    """
    require_own_packages(model.id)
    fields = tuple(_fields(model.tokenType))
    used = {str(field.elementKind) for field in _token_fields(model.tokenType) if str(field.kind) == "map"}
    entries = tuple((entry_name(kind), Written(ros)) for kind, ros in ROS_TYPES.items() if kind in used)
    owner = model.tokenType.id if model.tokenType else None
    token = interface(f"the token type {owner!r}", token_name(model.tokenType), owner, reserved)
    if token.lower() in {entry.lower() for entry, _ in entries}:
        raise NamingError(
            f"the token type {token!r} has the name of a message for maps",
            element=owner,
            hint="rename the token type",
        )
    services: dict[Name, str] = {}
    files: dict[str, str] = {}  # case does not tell files apart everywhere, and headers have small letters
    for channel in model.channels:
        if isinstance(channel, sym.ServiceChannel) and not channel.type:
            name = interface(f"the service {channel.id[:40]!r}", service_name(channel.id), channel.id)
            same = files.setdefault(name.lower(), channel.id)
            if same != channel.id:
                raise NamingError(
                    f"services {same!r} and {channel.id!r} both become the type {name}",
                    element=channel.id,
                    hint="rename one of them",
                )
            services[name] = channel.id
    return Interfaces(Name(interfaces_package(model.id)), token, fields, entries, tuple(services))


def entry_name(kind: str) -> Name:
    """Return the name of the message for an entry of a map to elements of a kind."""
    return Name(f"{kind.capitalize()}Entry")


def _token_fields(token_type: sym.TokenType | None) -> list[sym.TokenField]:
    return list(token_type.fields) if token_type else []


def _fields(token_type: sym.TokenType | None) -> list[Field]:
    names = message_fields(token_type)
    return [_field(field, names[field.name]) for field in _token_fields(token_type)]


def _field(field: sym.TokenField, message_name: Name) -> Field:
    kind, element = str(field.kind), str(field.elementKind)
    default: Value
    if kind == "list":
        length = field.length
        text = f"list of {element}" if length is None else f"list of {length} {element}"
        python, ros = f"list[{PYTHON_TYPES[element]}]", f"{ROS_TYPES[element]}[{length or ''}]"
        default = [_EMPTY[element]] * (length or 0)
    elif kind == "map":
        text, python, ros = (
            f"map of {element}",
            f"dict[str, {PYTHON_TYPES[element]}]",
            f"{entry_name(element)}[]",
        )
        default = {}
    else:
        text, python, ros, default = kind, PYTHON_TYPES[kind], ROS_TYPES[kind], _EMPTY[kind]
    if field.default is not None:
        default = field_value(field, read_json(field.default))
    ros_default = _ros_default(default) if field.default is not None and kind != "map" else Written()
    return Field(field.name, message_name, text, Written(python), Written(ros), default, ros_default)


def _ros_default(value: Value) -> Written:
    """Write a default value; empty where the interface language cannot be trusted with the text."""
    texts = [
        element for element in (value if isinstance(value, list) else [value]) if isinstance(element, str)
    ]
    if any(not text.isascii() or not text.isprintable() or set(text) & set("\"'\\#") for text in texts):
        return Written()
    return Written(json.dumps(value))
