"""Values of signals as brokers, sensors and people write them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.errors import DinerosError, near_matches
from dineros.metamodel.json_text import JsonTextError, decode_json

SIZE_LIMIT = 64 * 1024
"""Maximum size of a payload, in bytes or characters: far more than the signals of a node need."""

NAME_LIMIT = 255
"""Maximum length of a signal's name."""

_WORDS = {"true": True, "on": True, "1": True, "false": False, "off": False, "0": False}


class SignalValueError(DinerosError):
    """The data received for a signal is not a truth value, or not one of its values."""


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


def read_setting(text: str | bytes, values: Sequence[str] = ()) -> SignalSetting:
    """Return what a signal becomes by a text: a truth value, or one of its values if it has some.

    Parameters
    ----------
    text : str or bytes
        As for `read_truth`, or the name of a value, as plain text or as the ``value`` of a JSON object.
    values : sequence of str
        The names of the signal's values.

    Raises
    ------
    SignalValueError
        It denotes none, or is larger than `SIZE_LIMIT`.

    Examples
    --------
    >>> read_setting("moving", ["idle", "moving"]), read_setting(b'{"value": "idle"}', ["idle", "moving"])
    ('moving', 'idle')
    """
    if not values:
        return read_truth(text)
    plain = _plain(text)
    return _setting(_decoded(plain).get("value") if plain.lstrip().startswith("{") else plain, plain, values)


def read_signals(
    text: str | bytes, values: Callable[[str], Sequence[str]] = lambda _: ()
) -> dict[str, SignalSetting]:
    """Return the values of several signals that a JSON object denotes, by the signals' ids or names.

    Parameters
    ----------
    text : str or bytes
        The object.
    values : callable
        Returns the names of the values of a signal, by its id or name; none: it is true or false.

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
    found = {}
    for name, value in _decoded(plain).items():
        if len(name) > NAME_LIMIT:
            raise SignalValueError(f"a signal with a name of {len(name)} characters")
        found[name] = _setting(value, f"{name}: {value}" if isinstance(value, str) else name, values(name))
    return found


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


def _setting(found: object, shown: str, values: Sequence[str]) -> SignalSetting:
    if not values:
        return _truth(found, shown)
    if isinstance(found, str) and found[:NAME_LIMIT].strip() in values:
        return found.strip()
    hint = isinstance(found, str) and near_matches(found[:NAME_LIMIT], values)
    raise SignalValueError(
        f"{shown[:40]!r} is not one of its values", hint=hint or f"send {' or '.join(values[:8])}"
    )


def _truth(found: object, shown: str) -> bool:
    if isinstance(found, bool):
        return found
    if isinstance(found, (str, int)):
        value = _WORDS.get(str(found)[:NAME_LIMIT].strip().lower())
        if value is not None:
            return value
    raise SignalValueError(f"{shown[:40]!r} is not a truth value", hint="send true or false")
