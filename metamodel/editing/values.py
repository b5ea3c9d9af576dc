"""Attribute values from untrusted data: only values that all file formats can store."""

from __future__ import annotations

import math
from typing import Any

from pyecore.ecore import EEnum

from dineros.metamodel.editing.commands import LONGEST_TEXT, CommandError, Value
from dineros.metamodel.errors import near_matches
from dineros.metamodel.files.schema import INTEGERS, NOT_XML

LONGEST_ID = 500

_NUMBERS = ("EDouble", "EDoubleObject")


def checked(feature: Any, value: Value) -> Any:
    """Return the value of an attribute; None means its default.

    Raises
    ------
    CommandError
        It is of another type, out of bounds, or cannot be stored in a file.
    """
    if value is None:
        default = feature.get_default_value()
        if default is None and feature.lower > 0:
            raise CommandError(f"{feature.name} must have a value")
        return default
    kind = feature._eType
    if isinstance(kind, EEnum):
        return _literal(feature.name, kind, value)
    if kind.name in INTEGERS:
        return _integer(feature.name, value)
    if kind.name in _NUMBERS:
        return _number(feature.name, value)
    if kind.name == "EBoolean":
        if not isinstance(value, bool):
            raise CommandError(f"{feature.name} must be true or false")
        return value
    text = _text(feature.name, value)
    return checked_id(text) if feature.iD else text


def _literal(name: str, kind: EEnum, value: Value) -> Any:
    names = [str(each.name) for each in kind.eLiterals]
    if not isinstance(value, str) or value not in names:
        hint = near_matches(value[:100], names) if isinstance(value, str) else None
        raise CommandError(f"{name} must be one of {', '.join(names)}", hint=hint)
    return kind.getEEnumLiteral(value)


def _integer(name: str, value: Value) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise CommandError(f"{name} must be a whole number")
    if not -(2**31) <= value < 2**31:
        raise CommandError(f"{name} must be a whole number of 32 bits")
    return value


def _number(name: str, value: Value) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise CommandError(f"{name} must be a number")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise CommandError(f"{name} must be a finite number")
    return number


def _text(name: str, value: Value) -> str:
    if not isinstance(value, str):
        raise CommandError(f"{name} must be a string")
    if len(value) > LONGEST_TEXT:
        raise CommandError(f"{name} has more than {LONGEST_TEXT} characters")
    if found := NOT_XML.search(value):
        raise CommandError(f"{name} holds the character {found.group()!r}, which files cannot store")
    return value


def checked_id(text: str) -> str:
    """Return an id.

    Raises
    ------
    CommandError
        Some format cannot store it, or would take it for a path.
    """
    if not text or len(text) > LONGEST_ID:
        raise CommandError(f"an id has 1 to {LONGEST_ID} characters")
    if any(character.isspace() for character in text):
        raise CommandError(f"the id {text!r} has white space", hint="only names may contain white space")
    if text.startswith(("/", "$")) or "#" in text:
        raise CommandError(f"the id {text!r} looks like a path", hint="omit '#', and '/' or '$' at the start")
    return text
