"""JSON from strangers: read in one place, within limits, with one error for everything that can be wrong.

`json.loads` alone ends in `RecursionError` on deep nesting, in a bare `ValueError` on a number of thousands
of digits, and lets infinite numbers and texts pass that no file or message can hold (RFC 8259, sections 6
and 8).
"""

from __future__ import annotations

import json
import math
import re
from typing import Any

from dineros.metamodel.errors import DinerosError, Location

DEPTH_LIMIT = 64
"""Lists and objects inside each other, at most."""

DIGITS_LIMIT = 400
"""Characters of one number, at most: more than any finite double needs."""


class JsonTextError(DinerosError):
    """A text is not JSON, or no JSON within the limits."""


def decode_json(
    text: str | bytes,
    *,
    limit: int | None = None,
    location: Location | None = None,
    keys_once: bool = False,
) -> Any:
    """Read a JSON text of untrusted origin.

    Parameters
    ----------
    text : str or bytes
        The text; bytes are UTF-8.
    limit : int, optional
        Characters or bytes that it may have.
    location : Location, optional
        Where it stands.
    keys_once : bool
        Whether a key that an object has twice is an error, for files that state something. Otherwise the last
        value counts.

    Raises
    ------
    JsonTextError
        It is longer than the limit, no UTF-8, no JSON, nested deeper than `DEPTH_LIMIT`, holds a number of
        more than `DIGITS_LIMIT` characters or without a finite value, or half of a surrogate pair; or an
        object has a key twice, if that is an error.

    Examples
    --------
    >>> decode_json(b'{"value": true}')
    {'value': True}
    >>> decode_json("[1e999]")
    Traceback (most recent call last):
    dineros.metamodel.json_text.JsonTextError: no JSON: a number without a finite value
    """
    try:
        if limit is not None and len(text) > limit:
            raise ValueError(f"longer than {limit} characters")
        plain = text.decode("utf-8") if isinstance(text, bytes) else text
        if plain.startswith("\ufeff"):
            plain = plain[1:]
        decoder = _CAREFUL if _may_have_long_number(plain) else _QUICK
        found = (_STRICT if keys_once else decoder).decode(plain)
        if plain.count("[") + plain.count("{") > DEPTH_LIMIT:
            _check_depth(found)
        if "\\u" in plain and ("\\ud" in plain or "\\uD" in plain):
            json.dumps(found, ensure_ascii=False).encode("utf-8")
    except RecursionError:
        reason = "nested too deep"
    except UnicodeDecodeError as error:
        reason = f"no UTF-8: {error.reason}"
    except UnicodeEncodeError:
        reason = "half of a surrogate pair"
    except ValueError as error:
        reason = str(error)
    else:
        return found
    raise JsonTextError(f"no JSON: {reason}", location=location) from None


_STEP = 40
_PART_OF_NUMBER = re.compile(f"[0-9.eE+-]{{{DIGITS_LIMIT // _STEP}}}")


def _may_have_long_number(text: str) -> bool:
    """Return whether a number could be too long, so that the checks of every number are paid for only then.

    A number with more characters than the limit has this many successive characters among every 40th.
    """
    return len(text) > DIGITS_LIMIT and _PART_OF_NUMBER.search(text[::_STEP]) is not None


def _integer(text: str) -> int:
    _check_digits(text)
    return int(text)


def _finite(text: str) -> float:
    _check_digits(text)
    value = float(text)
    if not math.isfinite(value):
        raise ValueError("a number without a finite value")
    return value


def _check_digits(text: str) -> None:
    if len(text) > DIGITS_LIMIT:
        raise ValueError(f"a number of {len(text)} characters")


def distinct(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return the object of keys and values, for `json` as ``object_pairs_hook``.

    Raises
    ------
    ValueError
        An object has a key twice.
    """
    known = dict(pairs)
    if len(known) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"{twice!r} occurs twice in one object")
    return known


def _no_constant(text: str) -> float:
    raise ValueError(f"{text} is not a number of JSON")


_QUICK = json.JSONDecoder(parse_float=_finite, parse_constant=_no_constant)
_CAREFUL = json.JSONDecoder(parse_int=_integer, parse_float=_finite, parse_constant=_no_constant)
_STRICT = json.JSONDecoder(
    parse_int=_integer, parse_float=_finite, parse_constant=_no_constant, object_pairs_hook=distinct
)


def _check_depth(found: Any) -> None:
    """Look level by level, since a walk by recursion is what deep nesting breaks."""
    level: list[Any] = [found]
    for _ in range(DEPTH_LIMIT + 1):
        level = [value for value in level if isinstance(value, (dict, list))]
        if not level:
            return
        level = [inner for value in level for inner in (value.values() if isinstance(value, dict) else value)]
    raise ValueError("nested too deep")
