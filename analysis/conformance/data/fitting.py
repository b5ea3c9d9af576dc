"""Checks recorded values against the kinds, ROS types and ranges of the fields of tokens."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace

from dineros.metamodel.errors import FeatureValueError
from dineros.metamodel.records import Checkpoint, Data, Start
from dineros.metamodel.token_data import FieldType, check_length, within

_TYPES: dict[str, tuple[type, ...]] = {
    "text": (str,),
    "boolean": (bool,),
    "integer": (int,),
    "number": (int, float),
}
_ARTICLES = {"text": "a text", "boolean": "true or false", "integer": "an integer", "number": "a number"}


def misfit(place: str, data: Data, fields: Mapping[str, FieldType]) -> str | None:
    """Return the first field of a token whose value the field cannot have, in words; None: all fit.

    Fields that the record does not contain match, as do values stored outside of the trace.

    Examples
    --------
    >>> ok = FieldType("ok", "boolean", "text", None, False)
    >>> misfit("Done", {"ok": "yes"}, {"ok": ok})
    'Done.ok takes true or false, not "yes"'
    """
    for name, value in data.items():
        field = fields.get(name)
        if field is None or (type(value) is dict and "$stored" in value):
            continue
        try:
            _require(f"{place}.{name}", field, value)
        except FeatureValueError as error:
            return error.message
    return None


def held(record: Start) -> Iterator[tuple[str, Data]]:
    """Yield the data of the tokens on the places of a node that starts, with their places."""
    apart = record.apart.get("marking", {}) if isinstance(record, Checkpoint) else {}
    for place, tokens in record.marking.items():
        if place not in apart:
            yield from ((place, token.data) for token in tokens)


def _require(name: str, field: FieldType, value: object) -> None:
    if field.kind == "list":
        if type(value) is not list:
            raise _wrong(name, "a list", value)
        if field.length is not None or field.bound is not None:
            check_length(replace(field, name=name), len(value))
        for index, element in enumerate(value):
            _require_one(f"{name}[{index}]", field, element)
    elif field.kind == "map":
        if type(value) is not dict:
            raise _wrong(name, "a map", value)
        for key, element in value.items():
            _require_one(f"{name}.{key}", field, element)
    else:
        _require_one(name, field, value)


def _require_one(name: str, field: FieldType, value: object) -> None:
    """Refuse what a field, or an element of its list or map, cannot be."""
    if field.scalar == "record":
        if type(value) is not dict:
            raise _wrong(name, "a record", value)
        for part in field.fields:
            if part.name in value:
                _require(f"{name}.{part.name}", part, value[part.name])
        return
    if type(value) not in _TYPES[field.scalar]:
        raise _wrong(name, _ARTICLES[field.scalar], value)
    if field.ros is not None and not (field.scalar == "number" and type(value) is int):
        within(field.ros, name, value)  # type: ignore[arg-type]
    if type(value) is int and (allowed := field.range.fault(value)) is not None:
        raise _wrong(name, allowed, value)


def _wrong(name: str, takes: str, value: object) -> FeatureValueError:
    text = json.dumps(value, ensure_ascii=False)
    return FeatureValueError(f"{name} takes {takes}, not {text if len(text) <= 40 else f'{text[:37]}...'}")
