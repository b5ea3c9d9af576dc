"""Data of balloon tokens, by the fields of their token type."""

from __future__ import annotations

import json
from typing import Any

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.constraints.wording import describe
from dineros.metamodel.editing import commands as c
from dineros.metamodel.errors import DinerosError, near_matches
from dineros.metamodel.json_text import decode_json
from dineros.metamodel.token_data import FieldType, field_value, read_json
from dineros.metamodel.token_types.declared import token_type_of, type_of_place


def fields_of(root: pn.Net, token: sym.BalloonToken) -> dict[str, FieldType]:
    """Return the fields that a balloon token can have, by name.

    Raises
    ------
    CommandError
        Its token type is unknown.
    """
    place = token.eContainer()
    if not isinstance(place, sym.Place):
        return {}
    try:
        return {field.name: field for field in token_type_of(type_of_place(place, root)).fields}
    except DinerosError as error:
        raise c.CommandError(error.message, hint=error.hint) from error


def filled(root: pn.Net, token: EObject, handle: str, field: str, text: str | None) -> list[c.Command]:
    """Return the commands that set a field of a balloon token; the text of other fields is unchanged.

    Raises
    ------
    CommandError
        There is no such token or field, the value does not fit, or the token's data is not an object.
    """
    if not isinstance(token, sym.BalloonToken):
        raise c.CommandError(f"{describe(token)} carries no data")
    known = fields_of(root, token)
    if field not in known:
        raise c.CommandError(
            f"the token type has no field {field[:100]!r}", hint=near_matches(field[:100], known)
        )
    try:
        data = decode_json(token.data)
    except DinerosError as error:
        raise c.CommandError(
            f"its data is not JSON: {error.message}", hint="correct the data itself"
        ) from error
    if not isinstance(data, dict):
        raise c.CommandError("its data is not a JSON object", hint="correct the data itself")
    if text is None:
        data.pop(field, None)
    else:
        data[field] = _value(known[field], text)
    return [c.Set(handle, "data", json.dumps(data, ensure_ascii=False))]


def _value(field: FieldType, text: str) -> Any:
    try:
        named = field.range.value_of(text)  # the data has the name, which is easier to read
        value: Any = text if field.kind == "text" or named is not None else read_json(text)
        field_value(field, value)
    except DinerosError as error:
        raise c.CommandError(error.message, hint=error.hint) from error
    return value
