"""What tokens carry (paper, Sect. 5.2): fields, and reading JSON as their values.

Files of the DiNeROS PNML extension hold every value as text, so a text counts where it denotes a value of the
field's kind: ``"1.5"`` is a number, ``"true"`` a boolean, ``"[1, 2]"`` a list.
"""

from __future__ import annotations

import json
import math
import re
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from dineros.metamodel import sym
from dineros.metamodel.errors import FeatureValueError, near_matches
from dineros.metamodel.json_text import distinct
from dineros.metamodel.value_ranges import UNLIMITED, ValueRange, named_values

Value = str | int | float | bool | list["Value"] | dict[str, "Value"]
"""A value of a token field."""


@dataclass(frozen=True, slots=True)
class FieldType:
    """One field of a token type.

    Attributes
    ----------
    name : str
        Its name.
    kind, element_kind : {"text", "integer", "number", "boolean", "list", "map", "record"}
        Type of the value, and of the elements of a list or map. Records are the nested types of installed
        ROS interfaces.
    length : int, optional
        Number of elements of a list of fixed length.
    default : Value
        The value of a token for which no other is given.
    ros : str, optional
        ROS type of the value or of the elements: ``uint8``, ``string<=20``, ``std_msgs/msg/Header``;
        None: the widest of the kind.
    bound : int, optional
        Number of elements of a list at most.
    fields : tuple of FieldType
        Those of a record.
    range : ValueRange
        The values of an integer.
    """

    name: str
    kind: str
    element_kind: str
    length: int | None
    default: Value
    ros: str | None = None
    bound: int | None = None
    fields: tuple[FieldType, ...] = ()
    range: ValueRange = UNLIMITED

    @property
    def scalar(self) -> str:
        """Kind of the value, or of the elements."""
        return self.element_kind if self.kind in ("list", "map") else self.kind


@dataclass(frozen=True, slots=True)
class TokenType:
    """What tokens of a place carry; without fields where the model declares no type.

    Attributes
    ----------
    name : str
        Its name.
    fields : tuple of FieldType
        What a token has.
    ros : str, optional
        The installed ROS message that its tokens are; None: a message is generated.
    """

    name: str
    fields: tuple[FieldType, ...]
    ros: str | None = None


_INTEGER = re.compile(r"[+-]?[0-9]{1,20}")
_ARTICLES = {"text": "a text", "integer": "an integer", "number": "a number", "boolean": "true or false"}
EMPTY: dict[str, Value] = {"text": "", "integer": 0, "number": 0.0, "boolean": False}
"""The default of a field of a kind."""

_ROS_TYPE = re.compile(r"([a-z]+[0-9]*)(?:<=([1-9][0-9]{0,8}))?")
_KINDS = {"bool": "boolean", "float32": "number", "float64": "number", "string": "text", "wstring": "text"}
_WIDTHS = {"byte": (0, 8), "char": (0, 8)}
_WIDTHS |= {f"{sign}int{size}": (sign == "", size) for sign in ("", "u") for size in (8, 16, 32, 64)}
_KINDS |= dict.fromkeys(_WIDTHS, "integer")
_LARGEST_SINGLE = 3.4028234663852886e38


class RosScalar(NamedTuple):
    """A ROS type without fields: its name, its kind, and for a bounded text how long it may be."""

    name: str
    kind: str
    bound: int | None


def ros_scalar(text: str) -> RosScalar | None:
    """Return the ROS type that a text such as ``uint8`` or ``string<=20`` names; None: it names none."""
    match = _ROS_TYPE.fullmatch(text)
    kind = _KINDS.get(match[1]) if match else None
    if match is None or kind is None or (match[2] and kind != "text"):
        return None
    return RosScalar(match[1], kind, int(match[2]) if match[2] else None)


def integer_bounds(ros: str | None) -> tuple[int, int]:
    """Return the least and the greatest integer of a ROS type; None, or no integer type: int64."""
    signed, size = _WIDTHS.get(ros or "", (True, 64))
    return (-(2 ** (size - 1)), 2 ** (size - 1) - 1) if signed else (0, 2**size - 1)


def within(ros: str | None, name: str, value: Value) -> Value:
    """Return a text, number or integer that a ROS type can carry.

    Parameters
    ----------
    ros : str, optional
        The ROS type; None: int64 for integers, no limit for texts and numbers.
    name : str
        The name of the value, for messages.
    value : Value
        A value of the type's kind.

    Raises
    ------
    FeatureValueError
        The type cannot carry it.
    """
    type_ = ros_scalar(ros) if ros else None
    if isinstance(value, bool):
        return value
    if isinstance(value, int):
        low, high = integer_bounds(ros)
        if not low <= value <= high:
            kind = f"{type_.name}, {low} to {high}" if type_ is not None else "an integer of 64 bits"
            raise FeatureValueError(f"{name} takes {kind}, not {_shown(value)}")
    elif isinstance(value, float) and type_ is not None and type_.name == "float32":
        if abs(value) > _LARGEST_SINGLE:
            raise FeatureValueError(f"{name} takes float32, not {_shown(value)}")
        return float(struct.unpack("f", struct.pack("f", value))[0])  # what the receiver gets
    elif isinstance(value, str) and type_ is not None and type_.bound is not None:
        # Bounds count what the middleware stores: bytes of UTF-8, or units of UTF-16.
        wide = type_.name == "wstring"
        coded = value.encode("utf-16-le" if wide else "utf-8", "surrogatepass")
        length = len(coded) // 2 if wide else len(coded)
        if length > type_.bound:
            unit = "characters" if wide else "bytes"
            raise FeatureValueError(f"{name} takes at most {type_.bound} {unit}, not {length}")
    return value


def check_length(field: FieldType, count: int) -> None:
    """Refuse a number of elements that a list does not have.

    Raises
    ------
    FeatureValueError
        The list has a fixed length, or a bound, and the number is another one.
    """
    if field.length is not None and count != field.length:
        raise FeatureValueError(f"{field.name} takes {field.length} elements, not {count}")
    if field.bound is not None and count > field.bound:
        raise FeatureValueError(f"{field.name} takes at most {field.bound} elements, not {count}")


def field_type(field: sym.TokenField) -> FieldType:
    """Return a declared field with the empty value of its kind as default, of a list one without elements.

    Lists are not filled up to their length here, because the length has not been checked yet.
    """
    kind, element = str(field.kind), str(field.elementKind)
    default: Value = [] if kind == "list" else {} if kind == "map" else EMPTY.get(kind, "")
    try:
        values = range_of(field)
    except FeatureValueError:
        values = UNLIMITED  # the constraint about it says what is wrong
    return FieldType(field.name, kind, element, field.length, default, field.ros, field.bound, range=values)


def range_of(field: sym.TokenField) -> ValueRange:
    """Return the values that a declared field may have.

    Raises
    ------
    FeatureValueError
        It has a range that no field has, or one that is empty or wider than its ROS type.
    """
    low, high, text = field.minimum, field.maximum, field.values
    if low is None and high is None and text is None:
        return UNLIMITED
    if field.kind != sym.FieldKind.integer:
        raise FeatureValueError(f"a field of the kind {field.kind} has no range")
    if text is not None and (low is not None or high is not None):
        raise FeatureValueError("it has named values, and a minimum or maximum")
    if low is not None and high is not None and low > high:
        raise FeatureValueError(f"the minimum {low} is greater than the maximum {high}")
    made = named_values(text) if text is not None else ValueRange(low, high)
    for value in (low, high, *(value for _, value in made.names)):
        if value is not None:
            within(field.ros, field.name, value)
    return made


def read_json(text: str) -> object:
    """Read a JSON value strictly: no NaN, no name twice in an object, nothing nested too deep.

    Raises
    ------
    FeatureValueError
        The text is not such JSON.
    """
    try:
        return json.loads(text, parse_constant=_no_constant, object_pairs_hook=distinct)
    except json.JSONDecodeError as error:
        raise FeatureValueError(f"no JSON at column {error.pos + 1}: {error.msg}") from None
    except (ValueError, RecursionError) as error:
        reason = "nested too deep" if isinstance(error, RecursionError) else str(error)
        raise FeatureValueError(f"no JSON: {reason}") from None


def read_data(text: str, fields: Mapping[str, FieldType]) -> dict[str, Value]:
    """Read the data of a balloon token: a JSON object with values for some of the fields.

    Raises
    ------
    FeatureValueError
        The text is not a JSON object, names a field that is not there, or a value does not fit its field.
    """
    data = read_json(text)
    if not isinstance(data, dict):
        raise FeatureValueError("no JSON object", hint='write {"field": value}')
    for name in data:
        if name not in fields:
            hint = near_matches(name, fields) or f"known fields: {', '.join(fields)}"
            raise FeatureValueError(f"the token type has no field {name!r}", hint=hint)
    return {name: field_value(fields[name], value) for name, value in data.items()}


def field_value(field: FieldType, value: object) -> Value:
    """Return a JSON value as a value of a token field.

    Raises
    ------
    FeatureValueError
        The value, or an element of it, is not of the field's kind or outside the range of its ROS type, or a
        list has the wrong length.
    """
    if field.kind not in ("list", "map"):
        return _single(field, field.name, value)
    if isinstance(value, str):
        value = read_json(value)
    if field.kind == "map":
        if not isinstance(value, dict):
            raise FeatureValueError(f"{field.name} takes a map, not {_shown(value)}")
        return {key: _single(field, f"{field.name}.{key}", element) for key, element in value.items()}
    if not isinstance(value, list):
        raise FeatureValueError(f"{field.name} takes a list, not {_shown(value)}")
    check_length(field, len(value))
    return [_single(field, f"{field.name}[{index}]", element) for index, element in enumerate(value)]


def _single(field: FieldType, name: str, value: object) -> Value:
    """Return what a field has once, or an element of it."""
    kind = field.scalar
    if kind != "record":
        if isinstance(value, str) and kind == "integer" and field.range.names:
            value = value if (named := field.range.value_of(value)) is None else named
        read = within(field.ros, name, _scalar(name, kind, value))
        return field.range.require(name, read) if isinstance(read, int) and kind == "integer" else read
    if isinstance(value, str):
        value = read_json(value)
    if not isinstance(value, dict):
        raise FeatureValueError(f"{name} takes an object, not {_shown(value)}")
    inner = {part.name: part for part in field.fields}
    for key in value:
        if key not in inner:
            hint = near_matches(key, inner) or f"known fields: {', '.join(inner)}"
            raise FeatureValueError(f"{name} has no field {key!r}", hint=hint)
    given = {key: field_value(inner[key], element) for key, element in value.items()}
    return {part.name: given.get(part.name, part.default) for part in field.fields}


def _scalar(name: str, kind: str, value: object) -> Value:
    if kind == "text" and isinstance(value, str):
        return value
    if kind == "boolean":
        if isinstance(value, bool):
            return value
        if value in ("true", "false"):
            return value == "true"
    if kind == "integer":
        number = value
        if isinstance(value, str) and _INTEGER.fullmatch(value.strip()):
            number = int(value)
        if isinstance(number, int) and not isinstance(number, bool):
            return number
    if kind == "number":
        real = _number(value)
        if real is not None and math.isfinite(real):
            return real
    raise FeatureValueError(f"{name} takes {_ARTICLES.get(kind, kind)}, not {_shown(value)}")


def _number(value: object) -> float | None:
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        return None
    try:
        return float(value)
    except (ValueError, OverflowError):
        return None


def _shown(value: object) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 40 else f"{text[:37]}..."


def _no_constant(name: str) -> object:
    raise ValueError(f"{name} is not a JSON number")
