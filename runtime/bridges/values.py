"""Truth values as brokers, sensors and people write them."""

from __future__ import annotations

import json

from dineros.metamodel.errors import DinerosError

_WORDS = {"true": True, "on": True, "1": True, "false": False, "off": False, "0": False}


class SignalValueError(DinerosError):
    """What came for a signal is no truth value."""


def read_truth(text: str | bytes) -> bool:
    """Return the truth value that a text denotes.

    Parameters
    ----------
    text : str or bytes
        ``true``, ``on``, ``1`` or ``false``, ``off``, ``0``, or a JSON object with one of them as its
        ``value``.

    Raises
    ------
    SignalValueError
        It denotes none.

    Examples
    --------
    >>> read_truth("ON"), read_truth(b'{"value": false}'), read_truth("1")
    (True, False, True)
    """
    try:
        plain = text.decode() if isinstance(text, bytes) else text
        found = json.loads(plain) if plain.strip().startswith("{") else plain
    except (UnicodeDecodeError, json.JSONDecodeError) as error:
        raise SignalValueError(f"no truth value: {error}") from None
    if isinstance(found, dict):
        found = found.get("value")
    if isinstance(found, bool):
        return found
    value = _WORDS.get(str(found).strip().lower())
    if value is None:
        raise SignalValueError(f"{plain[:40]!r} is no truth value", hint="send true or false")
    return value
