"""Sets of values of a field, as sorted disjoint intervals, and which values comparisons distinguish."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable

from dineros.metamodel.guards.conditions import Comparison
from dineros.metamodel.token_data import FieldType, integer_bounds

Values = tuple[tuple[int, int], ...]
"""Least and greatest value of each interval, in ascending order; truth values are 0 and 1."""


def values_of(field: FieldType) -> Values | None:
    """Return all values of a field; None: it is neither a boolean nor an integer."""
    if field.kind == "boolean":
        return ((0, 1),)
    if field.kind != "integer":
        return None
    if field.range.listed:
        return _joined((value, value) for value in sorted(value for _, value in field.range.listed))
    low, high = integer_bounds(field.ros)
    low = low if field.range.minimum is None else max(low, field.range.minimum)
    high = high if field.range.maximum is None else min(high, field.range.maximum)
    return ((low, high),)


def contains(values: Values, value: int) -> bool:
    """Return whether a value is in a set."""
    place = bisect_right(values, value, key=lambda each: each[0])
    return place > 0 and value <= values[place - 1][1]


def size(values: Values) -> int:
    """Return how many values are in a set."""
    return sum(high - low + 1 for low, high in values)


def is_subset(some: Values, others: Values) -> bool:
    """Return whether all values of one set are in another."""
    for low, high in some:
        place = bisect_right(others, low, key=lambda each: each[0])
        if place == 0 or high > others[place - 1][1]:
            return False
    return True


def sample(values: Values) -> int:
    """Return the value of a set that is closest to zero, the greater one of two."""
    return min((min(max(low, 0), high) for low, high in values), key=lambda value: (abs(value), -value))


def classes_of(field: FieldType, asked: Iterable[Comparison]) -> list[Values]:
    """Return the values of a field, grouped if no comparison distinguishes them; in ascending order.

    Parameters
    ----------
    field : FieldType
        A boolean or an integer.
    asked : iterable of Comparison
        Comparisons of the field with numbers.
    """
    equal: set[int] = set()
    bounds: set[int] = set()
    for each in asked:
        assert isinstance(each.value, int), "names are resolved"
        if each.sign in ("=", "<>"):
            equal.add(int(each.value))
        else:  # the least value above the bound
            bounds.add(int(each.value) + (each.sign in ("<=", ">")))
    steps = sorted(bounds)
    cuts = sorted(bounds | equal | {value + 1 for value in equal})
    classes: dict[tuple[int, int | None], list[tuple[int, int]]] = {}
    for low, high in values_of(field) or ():
        inner = cuts[bisect_right(cuts, low) : bisect_right(cuts, high)]
        for first, after in zip((low, *inner), (*inner, high + 1), strict=True):
            kind = bisect_right(steps, first), first if first in equal else None
            classes.setdefault(kind, []).append((first, after - 1))
    return [_joined(parts) for parts in classes.values()]


def values_text(field: FieldType, values: Values) -> str:
    """Return values by their names; values without a name as numbers and intervals."""
    names: dict[int, str] = {0: "false", 1: "true"} if field.kind == "boolean" else {}
    for name, value in field.range.names:
        names.setdefault(value, name)
    texts = []
    for low, high in values:
        named = sorted(value for value in names if low <= value <= high)
        for value, before in zip(named, (low, *(each + 1 for each in named)), strict=False):
            texts += [*_interval(before, value - 1), names[value]]
        texts += _interval(named[-1] + 1 if named else low, high)
    return "|".join(texts)


def _interval(low: int, high: int) -> list[str]:
    if low > high:
        return []
    return [str(low) if low == high else f"{low}..{high}"]


def _joined(parts: Iterable[tuple[int, int]]) -> Values:
    """Return intervals in ascending order, joined if no value is between them."""
    joined: list[tuple[int, int]] = []
    for low, high in parts:
        if joined and joined[-1][1] + 1 == low:
            joined[-1] = joined[-1][0], high
        else:
            joined.append((low, high))
    return tuple(joined)
