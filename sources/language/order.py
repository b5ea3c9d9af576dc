"""The order in which Python looks up names in a class and its bases."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from typing import TypeVar

T = TypeVar("T")
MOST_CLASSES = 100
"""Limit of the bases of a class."""


def look_up_order(cls: T, bases: Callable[[T], Sequence[T]], key: Callable[[T], Hashable]) -> list[T]:
    """Return a class and all its bases in the order of look-up (the C3 linearisation of Python).

    Bases that Python would refuse are in the order of their text.

    Parameters
    ----------
    cls : T
        The class.
    bases : callable
        Returns the bases of a class.
    key : callable
        Returns what distinguishes a class.

    Examples
    --------
    >>> bases = {"D": "BC", "B": "A", "C": "A"}
    >>> look_up_order("D", lambda each: list(bases.get(each, "")), hash)
    ['D', 'B', 'C', 'A']
    """
    plain: dict[Hashable, T] = {}
    todo = [cls]
    while todo and len(plain) < MOST_CLASSES:
        each = todo.pop(0)
        if key(each) not in plain:
            plain[key(each)] = each
            todo = [*bases(each), *todo]
    if todo:
        return list(plain.values())
    if all(len(bases(each)) < 2 for each in plain.values()):
        return list(plain.values())
    try:
        order = _merged(key(cls), plain, bases, key, {})
    except ValueError:
        return list(plain.values())
    return [plain[each] for each in order]


def _merged(
    of: Hashable,
    known: dict[Hashable, T],
    bases: Callable[[T], Sequence[T]],
    key: Callable[[T], Hashable],
    made: dict[Hashable, list[Hashable] | None],
) -> list[Hashable]:
    """Return the linearisation of one class. `made`: those of others; None for a class in work.

    Raises
    ------
    ValueError
        The class has no linearisation.
    """
    if of in made:
        ready = made[of]
        if ready is None:
            raise ValueError("a class is its own base")
        return ready
    made[of] = None
    direct = [key(each) for each in bases(known[of])]
    rows = [_merged(each, known, bases, key, made) for each in direct]
    rows.append(direct)
    found = [of]
    while any(rows):
        rows = [row for row in rows if row]
        first = next((row[0] for row in rows if not any(row[0] in other[1:] for other in rows)), None)
        if first is None:
            raise ValueError("the bases have no common order")
        found.append(first)
        rows = [row[1:] if row[0] == first else row for row in rows]
    made[of] = found
    return found
