"""Checked values of cached facts: JSON from a cache may be damaged, so each value has the type it needs.

Each function raises a TypeError, ValueError or IndexError if the value is something else.
"""

from __future__ import annotations

from typing import Any, TypeVar

from dineros.sources.places import Place

MOST_LETTERS = 1 << 20
"""Limit of the length of a text."""
_Item = TypeVar("_Item")


def item_of(items: list[_Item], number: Any) -> _Item:
    """Return the item of a list with a number."""
    at = number_of(number)
    if at < 0:
        raise IndexError
    return items[at]


def plain_place(place: Place) -> list[Any]:
    """Return a line of code as JSON."""
    return [place.file, place.line]


def place_of(said: Any) -> Place:
    """Return the line of code of JSON."""
    file, line = said
    return Place(text_of(file), number_of(line))


def text_of(said: Any) -> str:
    """Return a text of at most `MOST_LETTERS` letters."""
    if not isinstance(said, str) or len(said) > MOST_LETTERS:
        raise TypeError
    return said


def number_of(said: Any) -> int:
    """Return a whole number."""
    if isinstance(said, bool) or not isinstance(said, int):
        raise TypeError
    return said


def truth_of(said: Any) -> bool:
    """Return a truth value."""
    if not isinstance(said, bool):
        raise TypeError
    return said


def value_of(said: Any) -> Any:
    """Return a value of the details of an entity."""
    if said is not None and not isinstance(said, (str, int, float, bool, list)):
        raise TypeError
    return said
