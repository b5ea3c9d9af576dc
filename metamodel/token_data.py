"""What tokens carry (paper, Sect. 5.2): reading JSON as the fields of a token type.

Files of the DiNeROS PNML extension hold every value as text, so a text counts where it denotes a value of the
field's kind: ``"1.5"`` is a number, ``"true"`` a boolean, ``"[1, 2]"`` a list.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping

from dineros.metamodel import sym
from dineros.metamodel.errors import FeatureValueError, near_matches

Value = str | int | float | bool | list["Value"] | dict[str, "Value"]
"""A value of a token field."""

_INTEGER = re.compile(r"[+-]?[0-9]{1,19}")
_INT64 = range(-(2**63), 2**63)  # what messages carry
_ARTICLES = {"text": "a text", "integer": "an integer", "number": "a number", "boolean": "true or false"}


def read_json(text: str) -> object:
    """Read a JSON value strictly: no NaN, no name twice in an object, nothing nested too deep.

    Raises
    ------
    FeatureValueError
        The text is no such JSON.
    """
    try:
        return json.loads(text, parse_constant=_no_constant, object_pairs_hook=_distinct)
    except json.JSONDecodeError as error:
        raise FeatureValueError(f"no JSON at column {error.pos + 1}: {error.msg}") from None
    except (ValueError, RecursionError) as error:
        reason = "nested too deep" if isinstance(error, RecursionError) else str(error)
        raise FeatureValueError(f"no JSON: {reason}") from None


def read_data(text: str, fields: Mapping[str, sym.TokenField]) -> dict[str, Value]:
    """Read the data of a balloon token: a JSON object with values for some of the fields.

    Raises
    ------
    FeatureValueError
        The text is no JSON object, names a field that is not there, or a value does not fit its field.
    """
    data = read_json(text)
    if not isinstance(data, dict):
        raise FeatureValueError("no JSON object", hint='write {"field": value}')
    for name in data:
        if name not in fields:
            hint = near_matches(name, fields) or f"known fields: {', '.join(fields)}"
            raise FeatureValueError(f"the token type has no field {name!r}", hint=hint)
    return {name: field_value(fields[name], value) for name, value in data.items()}


def field_value(field: sym.TokenField, value: object) -> Value:
    """Return a JSON value as a value of a token field.

    Raises
    ------
    FeatureValueError
        The value, or an element of it, is not of the field's kind, or a list has the wrong length.
    """
    if str(field.kind) not in ("list", "map"):
        return _scalar(field.name, str(field.kind), value)
    if isinstance(value, str):
        value = read_json(value)
    kind = str(field.elementKind)
    if field.kind == sym.FieldKind.map:
        if not isinstance(value, dict):
            raise FeatureValueError(f"{field.name} takes a map, not {_shown(value)}")
        return {key: _scalar(f"{field.name}.{key}", kind, element) for key, element in value.items()}
    if not isinstance(value, list):
        raise FeatureValueError(f"{field.name} takes a list, not {_shown(value)}")
    if field.length is not None and len(value) != field.length:
        raise FeatureValueError(f"{field.name} takes {field.length} elements, not {len(value)}")
    return [_scalar(f"{field.name}[{index}]", kind, element) for index, element in enumerate(value)]


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
            if number not in _INT64:
                raise FeatureValueError(f"{name} takes an integer of 64 bits, not {_shown(value)}")
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
    raise ValueError(f"{name} is no JSON number")


def _distinct(pairs: list[tuple[str, object]]) -> dict[str, object]:
    known = dict(pairs)
    if len(known) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"{twice!r} stands twice in one object")
    return known
