"""Checks the entries of a table of idioms: each key with the shape of its value."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from dineros.metamodel.errors import DinerosError, Location, near_matches
from dineros.sources.facts import KINDS

_MOST = 1 << 31
"""Limit of the numbers of a table."""


class _Shape(NamedTuple):
    """A shape of values: its description for error messages, and a test."""

    words: str
    fits: Callable[[Any], bool]


def _is_count(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < _MOST


def _is_seconds(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and 0 <= value < _MOST


def _is_text(value: object) -> bool:
    return isinstance(value, str)


def _among(*words: str) -> _Shape:
    return _Shape(f"one of {', '.join(words)}", lambda value: value in words if _is_text(value) else False)


_TEXT = _Shape("a string", lambda value: _is_text(value) and value != "")
_TEXTS = _Shape("a list of strings", lambda value: isinstance(value, list) and all(map(_is_text, value)))
_COUNT = _Shape("a whole number from 0", _is_count)
_TRUTH = _Shape("true or false", lambda value: isinstance(value, bool))
_TABLE = _Shape("a table", lambda value: isinstance(value, dict))
_TABLES = _Shape(
    "a list of tables",
    lambda value: isinstance(value, list) and all(isinstance(each, dict) for each in value),
)
_SECONDS = _Shape("a number of seconds", _is_seconds)
_PERIOD = _Shape(
    "a number of seconds, or an argument in braces", lambda value: _is_seconds(value) or _is_text(value)
)
_USUAL = _Shape("true or false, or seconds", lambda value: isinstance(value, bool) or _is_seconds(value))
_WORD_OR_COLUMN = _Shape(
    "a string, or the number of a column", lambda value: _is_text(value) or _is_count(value)
)
_ARGUMENT = _Shape("an argument, or its number", lambda value: _is_text(value) or _is_count(value))

_QUALITY = {
    "depth": _COUNT,
    "reliability": _among("reliable", "best_effort"),
    "durability": _among("volatile", "transient_local"),
}
_ENTRY = {
    "path": _TEXT,
    "also": _TEXTS,
    "arguments": _TEXTS,
    "makes": _TABLES,
    "methods": _TABLE,
    "node": _TEXT,
    "do": _TEXT,
    "what": _TEXT,
    "how": _TEXT,
    "synchronizes": _TEXT,
    "quality": _TABLE,
    "managed": _TRUTH,
    "others": _TEXT,
}
_MAKE = {
    "kind": _among(*(each for each in KINDS if each not in ("groups", "parameters"))),
    "name": _WORD_OR_COLUMN,
    "type": _WORD_OR_COLUMN,
    "via": _TEXT,
    "qos": _TEXT,
    "usual": _USUAL,
    "group": _TEXT,
    "period": _PERIOD,
    "publishes": _COUNT,
    "callback": _ARGUMENT,
    "each": _TEXT,
    "attribute": _COUNT,
    "latched": _COUNT,
    **_QUALITY,
}
_METHOD = {
    "do": _TEXT,
    "what": _TEXT,
    "how": _TEXT,
    "entity": _COUNT,
    "and": _COUNT,
    "callback": _COUNT,
    "timeout": _SECONDS,
}
_COLUMNS = ("attribute", "name", "type", "latched")
"""Keys of a list of entities that an argument gives, by columns."""


def checked(entry: Mapping[str, Any], number: int, file: Path) -> None:
    """Check one entry of a table.

    Parameters
    ----------
    entry : mapping
        As written in the file.
    number : int
        Of the entry, from 1: used in errors if it has no path.
    file : Path
        The table, for errors.

    Raises
    ------
    DinerosError
        A key is unknown or missing, or a value has another shape.
    """
    path = entry.get("path")
    at = f"idiom {path}" if isinstance(path, str) and path else f"idiom {number}"
    _shaped(entry, _ENTRY, at, file, needs=("path",))
    if "do" not in entry and ("what" in entry or "how" in entry):
        raise _wrong(file, at, "has `what` or `how` without `do`", 'write it like do = "call"')
    makes = entry.get("makes", [])
    for index, make in enumerate(makes):
        of_make = f"{at}: makes[{index}]"
        _shaped(make, _MAKE, of_make, file, needs=("kind",))
        _checked_make(make, of_make, file)
        if "publishes" in make:
            before = makes[: min(index, make["publishes"] + 1)]
            if len(before) <= make["publishes"] or before[-1]["kind"] != "publishers":
                raise _wrong(
                    *(file, f"{of_make}: publishes", "is not an earlier publisher of `makes`"),
                    "it is the number of the publisher, counted from 0",
                )
    _shaped(entry.get("quality", {}), _QUALITY, f"{at}: quality", file)
    for name, method in entry.get("methods", {}).items():
        of_method = f"{at}: methods.{name}"
        if not isinstance(method, dict):
            raise _wrong(file, of_method, "is not a table", 'write it like { do = "publish", entity = 0 }')
        _shaped(method, _METHOD, of_method, file)
        if not {"do", "callback"} & set(method):
            raise _wrong(file, of_method, "has neither `do` nor `callback`", 'write it like do = "publish"')
        _numbered(method, "entity", makes, of_method, file)
        _numbered(method, "and", makes, of_method, file)


def _checked_make(make: Mapping[str, Any], at: str, file: Path) -> None:
    if "each" in make:
        for key in _COLUMNS:
            if not _is_count(make.get(key)):
                raise _wrong(file, f"{at}: {key}", "is not the number of a column", "`each` needs columns")
        if not _is_count(make.get("callback", 0)):
            raise _wrong(file, f"{at}: callback", "is not the number of a column", "`each` needs columns")
        return
    for key in ("name", "type", "callback"):
        if key in make and not _is_text(make[key]):
            raise _wrong(file, f"{at}: {key}", "is not a string", "numbers are columns of `each`")
    if make["kind"] == "timers" and "period" not in make:
        raise _wrong(file, at, "is a timer without a period", "write it like period = 1.0")
    if make["kind"] != "timers" and not {"name", "type"} <= set(make):
        raise _wrong(file, at, "has no name or no type", 'write it like name = "scan", type = "pkg/msg/Scan"')


def _numbered(table: Mapping[str, Any], key: str, makes: list[Any], at: str, file: Path) -> None:
    if table.get(key, 0) >= max(len(makes), 1):
        raise _wrong(
            file, f"{at}: {key}", "is not an entity of `makes`", f"it makes {len(makes)}, counted from 0"
        )


def _shaped(
    table: Mapping[str, Any], known: Mapping[str, _Shape], at: str, file: Path, needs: tuple[str, ...] = ()
) -> None:
    for key in needs:
        if key not in table:
            raise _wrong(file, at, f"has no {key}", f"known are {', '.join(known)}")
    for key, value in table.items():
        if key not in known:
            hint = near_matches(key, known) or f"known are {', '.join(known)}"
            raise _wrong(file, f"{at}: {key}", "is unknown", hint)
        if not known[key].fits(value):
            raise _wrong(file, f"{at}: {key}", f"is not {known[key].words}", "the guide describes the table")


def _wrong(file: Path, at: str, what: str, hint: str) -> DinerosError:
    return DinerosError(f"{at} {what}", location=Location(file), hint=hint)
