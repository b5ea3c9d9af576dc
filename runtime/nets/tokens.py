"""Balloon tokens: data of their place's token type, checked when it enters the engine (paper, Sect. 5.2).

A token's data is never changed once the token exists, so that tokens can share it; handlers get copies.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, cast

from dineros.metamodel.errors import FeatureValueError, near_matches
from dineros.metamodel.token_data import FieldType, TokenType, Value, check_length, within
from dineros.metamodel.value_ranges import UNLIMITED
from dineros.runtime.nets.ports import Data

__all__ = ["CheckedData", "Token", "TokenChecker", "copy_data"]


class Token(NamedTuple):
    """A balloon token.

    Attributes
    ----------
    id : int
        Unique in its node; it is never reused.
    data : dict
        A value for every field of the token type.
    """

    id: int
    data: Data


_INT64 = range(-(2**63), 2**63)
_WIDEST = range(-(2**64), 2**64 + 1)  # values outside of a ROS type's range are refused by `within`
_ARTICLES = {"text": "a text", "integer": "an integer", "number": "a finite number", "boolean": "a boolean"}


def copy_data(data: Data) -> dict[str, Value]:
    """Return a copy of token data that shares no mutable object with it."""
    return {name: _copy(value) if type(value) in (list, dict) else value for name, value in data.items()}


def _copy(value: Value) -> Value:
    if isinstance(value, list):
        return [_copy(element) for element in value]
    if isinstance(value, dict):
        return {key: _copy(element) for key, element in value.items()}
    return value


class CheckedData(dict[str, Value]):
    """Data that a checker has completed: it fits `token_type` and need not be checked again.

    Like all token data it is never changed; handlers get plain copies.
    """

    __slots__ = ("token_type",)

    token_type: TokenType


class TokenChecker:
    """Checks and completes data from handlers, messages and user input.

    It is stricter than the reader of model files: a text is not accepted as a number.
    """

    def __init__(self, token_type: TokenType) -> None:
        self.token_type = token_type
        self._checks = {field.name: _check_for(field) for field in token_type.fields}
        self.default: Data = self._checked({field.name: field.default for field in token_type.fields})

    def complete(self, data: object, base: Data | None = None) -> Data:
        """Return data with all fields: from `data`, else from `base` (default: the defaults of the fields).

        Raises
        ------
        FeatureValueError
            `data` is not a mapping, has a field that the token type does not have, or a value does not fit.
        """
        if type(data) is CheckedData and (
            data.token_type is self.token_type or data.token_type == self.token_type
        ):
            return data
        if not isinstance(data, Mapping):
            raise FeatureValueError(f"token data is a mapping of fields to values, not {_shown(data)}")
        completed = dict(self.default if base is None else base)
        checks = self._checks
        for name, value in data.items():
            check = checks.get(name)
            if check is None:
                raise self._unknown(name)
            completed[name] = check(value)
        return self._checked(completed)

    def _checked(self, data: Data) -> CheckedData:
        checked = CheckedData(data)
        checked.token_type = self.token_type
        return checked

    def _unknown(self, name: object) -> FeatureValueError:
        known = list(self._checks)
        hint = near_matches(name, known) if isinstance(name, str) else None
        return FeatureValueError(
            f"tokens have no field {name!r}",
            hint=hint or (f"their fields are {', '.join(known)}" if known else "the model declares none"),
        )


_Check = Callable[[object], Value]


def _check_for(field: FieldType) -> _Check:
    if field.kind == "list":
        return _list_check(field)
    if field.kind == "map":
        return _map_check(field)
    return _single_check(field, field.name)


def _single_check(field: FieldType, name: str) -> _Check:
    """Return the check of a single value of a field, or of an element of its list."""
    if field.scalar == "record":
        return _record_check(field, name)
    ros, values = field.ros, field.range
    if ros is None:
        check = _scalar_check(name, field.scalar)
    else:
        any_width = _scalar_check(name, field.scalar, _WIDEST)

        def check(value: object) -> Value:
            return within(ros, name, any_width(value))

    if values == UNLIMITED:
        return check
    return lambda value: values.require(name, cast("int", check(value)))


def _scalar_check(name: str, kind: str, integers: range = _INT64) -> _Check:
    def text(value: object) -> Value:
        if not isinstance(value, str) or not (value.isascii() or _encodable(value)):
            raise _wrong(name, kind, value)
        if "\0" in value:  # ROS sends a text only up to its first NUL
            raise FeatureValueError(f"{name} takes a string without NUL, not {_shown(value)}")
        return str(value)

    def boolean(value: object) -> Value:
        if isinstance(value, bool):
            return value
        raise _wrong(name, kind, value)

    def integer(value: object) -> Value:
        if isinstance(value, int) and not isinstance(value, bool) and value in integers:
            return int(value)
        raise _wrong(name, kind, value)

    def number(value: object) -> Value:
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            try:
                if math.isfinite(value):
                    return float(value)
            except OverflowError:
                pass
        raise _wrong(name, kind, value)

    return {"text": text, "boolean": boolean, "integer": integer, "number": number}[kind]


def _list_check(field: FieldType) -> _Check:
    check = _single_check(field, f"an element of {field.name}")

    def checked(value: object) -> Value:
        if not isinstance(value, (list, tuple)):
            raise FeatureValueError(f"{field.name} takes a list, not {_shown(value)}")
        check_length(field, len(value))
        return [check(element) for element in cast("Sequence[Any]", value)]

    return checked


def _map_check(field: FieldType) -> _Check:
    check = _single_check(field, f"a value of {field.name}")
    key_check = _scalar_check(f"a key of {field.name}", "text")

    def checked(value: object) -> Value:
        if not isinstance(value, Mapping):
            raise FeatureValueError(f"{field.name} takes a map, not {_shown(value)}")
        return {str(key_check(key)): check(element) for key, element in value.items()}

    return checked


def _record_check(field: FieldType, name: str) -> _Check:
    """Return the check of a nested ROS type: missing fields get their defaults."""
    checks = {part.name: _check_for(replace(part, name=f"{name}.{part.name}")) for part in field.fields}
    defaults = {part.name: part.default for part in field.fields}

    def checked(value: object) -> Value:
        if not isinstance(value, Mapping):
            raise FeatureValueError(f"{name} takes a dictionary, not {_shown(value)}")
        completed = dict(defaults)
        for key, element in value.items():
            if key not in checks:
                hint = near_matches(str(key), checks) or f"its fields are {', '.join(checks)}"
                raise FeatureValueError(f"{name} has no field {key!r}", hint=hint)
            completed[key] = checks[key](element)
        return completed

    return checked


def _encodable(text: str) -> bool:
    """Return whether a text can be encoded: it has no lone surrogate."""
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _wrong(name: str, kind: str, value: object) -> FeatureValueError:
    return FeatureValueError(f"{name} takes {_ARTICLES[kind]}, not {_shown(value)}")


def _shown(value: object) -> str:
    try:
        text = json.dumps(value, ensure_ascii=True)
    except (TypeError, ValueError, RecursionError):
        text = f"an object of class {type(value).__name__}"
    return text if len(text) <= 40 else f"{text[:37]}..."
