"""Tokens in handlers and in messages: a class for each token type and each nested ROS type."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from dataclasses import field as dataclass_field

from dineros.generators.application.naming import (
    NOTHING_RESERVED,
    NamingError,
    Reserved,
    functions,
    interface,
    message_fields,
)
from dineros.generators.templates.filters import Name, Written, python
from dineros.metamodel import sym
from dineros.metamodel.elements import label, token_types
from dineros.metamodel.ros_names import camel_case, snake_case
from dineros.metamodel.token_data import FieldType, TokenType, Value
from dineros.metamodel.token_types.declared import token_type_of
from dineros.metamodel.token_types.installed import installed_constants
from dineros.metamodel.value_ranges import ValueRange

ROS_TYPES = {"text": "string", "integer": "int64", "number": "float64", "boolean": "bool"}
LONGEST_LITERAL = 60
"""Maximum length of the type of a field with named values; a longer one would break the line."""
PYTHON_TYPES = {"text": "str", "integer": "int", "number": "float", "boolean": "bool"}


@dataclass(frozen=True)
class Field:
    """A field of a token type."""

    name: str
    message_name: Name
    """`name`, `message_name`: its names in the model and in messages."""
    kind: str
    """Its kind as text: ``text``, ``list of 6 number``, ``map of text``."""
    python_type: Written
    ros_type: Written
    """`python_type`, `ros_type`: its types in handlers and in messages."""
    default: Value
    made: Written
    """The default as a Python expression."""
    ros_default: Written
    """The default in the interface definition; empty if it is not needed or cannot be expressed."""
    named_values: tuple[tuple[Name, int], ...] = ()
    """Its values, if they have names: constants of the message."""
    allowed: str = ""
    """The allowed values as text, if not all values of its type are allowed."""


@dataclass(frozen=True)
class TokenClass:
    """The class in handlers for a token type, or for a ROS type nested in one."""

    id: str | None
    """The token type in the model; None: the model declares none, or it is a nested type."""
    name: Name
    function: Name
    """`name`, `function`: the class, and the function that creates an object."""
    fields: tuple[Field, ...]
    ros: Written | None
    """The installed message that it represents; None: a message of its name is generated."""
    nested: frozenset[str] = frozenset()
    """The ROS types in it, at all levels."""
    constants: dict[Name, Value] = dataclass_field(default_factory=dict)
    """Constants of the installed message, or named values of the model's own type, by their names in Python:
    ``STATE_PRIMARY_STATE_ACTIVE``.
    """

    @property
    def message(self) -> Written:
        """Its type in definitions of the model's package, such as ``Order`` or ``std_msgs/String``."""
        return Written(self.ros.replace("/msg/", "/")) if self.ros else self.name

    @property
    def package(self) -> Name | None:
        """The package of the installed message."""
        return Name(self.ros.partition("/")[0]) if self.ros else None


def token_classes(
    model: sym.SystemModel, reserved: Reserved = NOTHING_RESERVED
) -> tuple[tuple[TokenClass, ...], tuple[TokenClass, ...]]:
    """Return the classes of the token types, the first one first, and of the ROS types nested in them.

    Raises
    ------
    NamingError
        Names of the model collide in ROS or in Python.
    UnknownInterfaceError
        A token type is a ROS message that is not installed.
    """
    declared: list[sym.TokenType | None] = list(token_types(model))
    if model.tokenType is None:
        declared.insert(0, None)
    names = _names(declared, reserved)
    types = [token_type_of(each) for each in declared]
    nested: dict[str, tuple[FieldType, ...]] = {}
    for type_ in types:
        _collect(type_.fields, nested)
    inner = _nested_names(nested, names, reserved)
    own = frozenset({"of_place"} if len(names) > 1 else ())
    made = functions([*names, *inner.values()], Reserved(handlers=reserved.tokens | own))
    makers = {ros: made[name] for ros, name in inner.items()}
    known: set[str] = set()

    def token_class(declared: sym.TokenType | None, type_: TokenType, name: Name) -> TokenClass:
        fields = _fields(declared, type_.fields, inner, makers)
        return TokenClass(
            declared.id if declared is not None else None,
            name,
            made[name],
            tuple(fields),
            Written(type_.ros) if type_.ros else None,
            frozenset(_collect(type_.fields, {})),
            _constants(type_, name, known),
        )

    first = tuple(token_class(*each) for each in zip(declared, types, names, strict=True))
    rest = (token_class(None, TokenType(inner[ros], nested[ros], ros), inner[ros]) for ros in nested)
    return first, tuple(rest)


def _constants(type_: TokenType, name: Name, known: set[str]) -> dict[Name, Value]:
    """Return the constants of a message under names that are not `known` yet."""
    constants: dict[Name, Value] = {}
    own_values: dict[str, Value] = {
        each: value for field in type_.fields for each, value in field.range.listed
    }
    for constant, value in (installed_constants(type_.ros) if type_.ros else own_values).items():
        own = Name(f"{snake_case(name).upper()}_{constant}")
        if own not in known:
            known.add(own)
            constants[own] = value
    return constants


def _names(declared: Sequence[sym.TokenType | None], reserved: Reserved) -> list[Name]:
    names: dict[str, Name] = {}
    for each in declared:
        owner = each.id if each else None
        name = interface(f"the token type {owner!r}", token_name(each), owner, reserved)
        if name.lower() in names:
            raise NamingError(
                f"two token types become the class {name}", element=owner, hint="rename one of them"
            )
        names[name.lower()] = name
    return list(names.values())


def _collect(
    fields: Sequence[FieldType], nested: dict[str, tuple[FieldType, ...]]
) -> dict[str, tuple[FieldType, ...]]:
    """Add the ROS types in some fields; a type follows the types nested in it."""
    for field in fields:
        if field.fields and field.ros and field.ros not in nested:
            _collect(field.fields, nested)
            nested[field.ros] = field.fields
    return nested


def _nested_names(
    nested: Sequence[str] | dict[str, tuple[FieldType, ...]], taken: Sequence[Name], reserved: Reserved
) -> dict[str, Name]:
    """Return the class of each nested ROS type: its name, prefixed with its package on a collision."""
    used = {name.lower() for name in taken} | {f"{name}Changes".lower() for name in taken}
    names: dict[str, Name] = {}
    for ros in nested:
        package, _, message = ros.split("/")
        name, number = message, 1
        while {name.lower(), f"{name}Changes".lower()} & used or {name, f"{name}Changes"} & reserved.tokens:
            name = f"{camel_case(package)}{message}" + (str(number) if number > 1 else "")
            number += 1
        used |= {name.lower(), f"{name}Changes".lower()}
        names[ros] = Name(name)
    return names


def token_name(token_type: sym.TokenType | None) -> str:
    """Return the name of a token type: that of its message and of the class in handlers."""
    return camel_case(label(token_type)) if token_type else "Token"


def entry_name(kind: str) -> Name:
    """Return the name of the message for an entry of a map with elements of this kind."""
    return Name(f"{kind.capitalize()}Entry")


def _fields(
    declared: sym.TokenType | None,
    fields: Sequence[FieldType],
    nested: dict[str, Name],
    makers: dict[str, Name],
) -> list[Field]:
    names = message_fields(declared)
    defaults = {field.name for field in declared.fields if field.default is not None} if declared else set()
    made = []
    for field in fields:
        python_type, ros_type, text = _types(field, nested)
        has_default = field.name in defaults and field.kind != "map"
        made.append(
            Field(
                field.name,
                names.get(field.name, Name(field.name)),
                text,
                Written(python_type),
                Written(ros_type),
                field.default,
                _made(field, makers) if field.name not in names else python(field.default),
                _ros_default(field.default) if has_default else Written(),
                tuple((Name(each), value) for each, value in field.range.listed),
                _allowed(field.range),
            )
        )
    return made


def _types(field: FieldType, nested: dict[str, Name]) -> tuple[str, str, str]:
    """Return the types of a field in Python and in ROS, and its kind as text."""
    kind, element = field.kind, field.scalar
    plain = nested[field.ros] if element == "record" and field.ros else PYTHON_TYPES[element]
    ros = field.ros or ROS_TYPES[element]
    if kind == "list":
        count = f"at most {field.bound} " if field.bound else f"{field.length} " if field.length else ""
        size = f"<={field.bound}" if field.bound else field.length or ""
        return f"list[{plain}]", f"{ros}[{size}]", f"list of {count}{element}"
    if kind == "map":
        return f"dict[str, {plain}]", f"{entry_name(element)}[]", f"map of {element}"
    literal = f"Literal[{', '.join(str(value) for _, value in field.range.listed)}]"
    if field.range.listed and len(literal) <= LONGEST_LITERAL:
        return literal, ros, kind
    return plain, ros, kind


def _allowed(values: ValueRange) -> str:
    """Return the values of a range in words: ``IDLE=0, BUSY=1``, or ``0 to 100``; empty: all."""
    if values.listed:
        return ", ".join(f"{name}={value}" for name, value in values.listed)
    return values.bounds


def _made(field: FieldType, makers: dict[str, Name]) -> Written:
    """Write the default of a field of an installed message as a short expression."""
    if field.scalar == "record" and field.ros:
        maker = f"{makers[field.ros]}()"
        if field.kind == "list":
            return Written(f"[{maker} for _ in range({field.length})]" if field.length else "[]")
        return Written(maker)
    value = field.default
    if isinstance(value, list) and len(value) > 8 and all(element == value[0] for element in value):
        return Written(f"[{python(value[0])}] * {len(value)}")
    return python(value)


def _ros_default(value: Value) -> Written:
    """Write a default value; empty if the text may not be safe in the interface language."""
    texts = [
        element for element in (value if isinstance(value, list) else [value]) if isinstance(element, str)
    ]
    if any(not text.isascii() or not text.isprintable() or set(text) & set("\"'\\#") for text in texts):
        return Written()
    return Written(json.dumps(value))
