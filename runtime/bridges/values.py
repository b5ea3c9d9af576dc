"""Truth values in the notations of brokers, sensors and users."""

from __future__ import annotations

from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.json_text import JsonTextError, decode_json

SIZE_LIMIT = 64 * 1024
"""Maximum size of a payload, in bytes or characters: far more than the signals of a node need."""

NAME_LIMIT = 255
"""Maximum length of a signal's name."""

_WORDS = {"true": True, "on": True, "1": True, "false": False, "off": False, "0": False}


class SignalValueError(DinerosError):
    """A payload for a signal is not a truth value."""


def read_truth(text: str | bytes) -> bool:
    """Return the truth value in a text.

    Parameters
    ----------
    text : str or bytes
        ``true``, ``on``, ``1`` or ``false``, ``off``, ``0``, or a JSON object with one of them as its
        ``value``.

    Raises
    ------
    SignalValueError
        It has no truth value, or is larger than `SIZE_LIMIT`.

    Examples
    --------
    >>> read_truth("ON"), read_truth(b'{"value": false}'), read_truth("1")
    (True, False, True)
    """
    plain = _plain(text)
    if plain.lstrip().startswith("{"):
        return _truth(_decoded(plain).get("value"), plain)
    return _truth(plain, plain)


def read_signals(text: str | bytes) -> dict[str, bool]:
    """Return the values of several signals in a JSON object, by the signals' ids or names.

    Raises
    ------
    SignalValueError
        It is not such an object, or is larger than `SIZE_LIMIT`.

    Examples
    --------
    >>> read_signals('{"Red": true, "Blue": "off"}')
    {'Red': True, 'Blue': False}
    """
    plain = _plain(text)
    if not plain.lstrip().startswith("{"):
        raise SignalValueError(
            f"{plain[:40]!r} is not an object of signals", hint='send {"NAME": true, "OTHER": false}'
        )
    values = {}
    for name, value in _decoded(plain).items():
        if len(name) > NAME_LIMIT:
            raise SignalValueError(f"a signal with a name of {len(name)} characters")
        values[name] = _truth(value, f"{name}: {value}" if isinstance(value, str) else name)
    return values


def _plain(text: str | bytes) -> str:
    if len(text) > SIZE_LIMIT:
        raise SignalValueError(f"not a truth value: {len(text)} bytes, and {SIZE_LIMIT} at most are read")
    try:
        return text.decode() if isinstance(text, bytes) else text
    except UnicodeDecodeError as error:
        raise SignalValueError(f"not a truth value: no UTF-8: {error.reason}") from None


def _decoded(plain: str) -> dict[str, Any]:
    try:
        found = decode_json(plain)
    except JsonTextError as error:
        raise SignalValueError(f"not a truth value: {error}") from None
    assert isinstance(found, dict)  # it begins with a brace
    return found


def _truth(found: object, shown: str) -> bool:
    if isinstance(found, bool):
        return found
    if isinstance(found, (str, int)):
        value = _WORDS.get(str(found)[:NAME_LIMIT].strip().lower())
        if value is not None:
            return value
    raise SignalValueError(f"{shown[:40]!r} is not a truth value", hint="send true or false")
