"""Guards and assignments of a transition, with their place and field names resolved in the model."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from itertools import product

from dineros.metamodel import pn
from dineros.metamodel.errors import GuardError, near_matches
from dineros.metamodel.guards.conditions import (
    And,
    Comparison,
    Condition,
    Constant,
    FieldName,
    comparisons,
    with_comparisons,
)
from dineros.metamodel.guards.parser import parse_assignments, parse_guard
from dineros.metamodel.token_data import FieldType

MOST_VALUES = 4096
"""Most values of a field that guards may use, and most combinations of the fields of one token."""

Fields = Callable[[pn.Place], Mapping[str, FieldType]]
"""Returns the fields of the tokens of a place, by name."""

Source = tuple[pn.Place, str]
"""A field of the token that is taken or read from a place."""

_WIDTHS = {"uint8": (0, 255), "char": (0, 255), "byte": (0, 255), "int8": (-128, 127)}


def finite_values(field: FieldType) -> tuple[int, ...] | None:
    """Return all values of a field in ascending order, truth values as 0 and 1; None: too many values."""
    if field.kind == "boolean":
        return (0, 1)
    if field.kind != "integer":
        return None
    if field.range.listed:
        return tuple(sorted(value for _, value in field.range.listed))
    low, high = _WIDTHS.get(field.ros or "", (None, None))
    low = low if field.range.minimum is None else field.range.minimum
    high = high if field.range.maximum is None else field.range.maximum
    if low is None or high is None or high - low >= MOST_VALUES:
        return None
    return tuple(range(low, high + 1))


def read_guard(text: str, seen: Mapping[pn.Place, int], fields: Fields) -> dict[pn.Place, Condition]:
    """Return the condition of a transition's guard on the token of each place that it names.

    Parameters
    ----------
    text : str
        The guard. Each part that ``and`` joins refers to one place.
    seen : mapping of place to int
        Number of tokens that the transition takes or reads.
    fields : callable
        The fields of a place's tokens.

    Returns
    -------
    dict of place to Condition
        Names are resolved: fields have no place, constants are numbers.

    Raises
    ------
    GuardError
        The guard cannot be read, names an element that does not exist, or can never hold.
    """
    parts: dict[pn.Place, list[Condition]] = {}
    guard = parse_guard(text)
    for part in _conjuncts(guard):
        places = dict.fromkeys(_place(each.field, seen, fields, "takes") for each in comparisons(part))
        if len(places) > 1:
            raise GuardError(
                f"one part compares fields of {' and '.join(str(place.id) for place in places)}",
                hint="join conditions about different places by 'and' only",
            )
        (place,) = places
        if seen[place] != 1:
            raise GuardError(
                f"it asks about {place.id}, of which the transition takes or reads {seen[place]} tokens",
                hint="let it take or read one token, by one arc",
            )
        known = fields(place)
        resolved = with_comparisons(part, partial(_resolved, known=known))
        parts.setdefault(place, []).append(resolved)
    found = {place: each[0] if len(each) == 1 else And(tuple(each)) for place, each in parts.items()}
    for place, condition in found.items():
        if satisfying(condition, fields(place)) is None:
            raise GuardError(
                f"no token of {place.id} can fulfil it", hint="compare with values of the fields"
            )
    return found


def read_assignments(
    text: str, seen: Mapping[pn.Place, int], puts: Iterable[pn.Place], fields: Fields
) -> dict[pn.Place, dict[str, int | Source]]:
    """Return the values that a transition assigns to fields of the tokens that it puts on each place.

    Raises
    ------
    GuardError
        The text cannot be read, names an element that does not exist, or assigns an unsuitable value.
    """
    targets = dict.fromkeys(puts, 1)
    found: dict[pn.Place, dict[str, int | Source]] = {}
    for assignment in parse_assignments(text):
        place = _place(assignment.field, targets, fields, "puts tokens on")
        name = assignment.field.field
        field, values = _finite(fields(place), name)
        given = found.setdefault(place, {})
        if name in given:
            raise GuardError(f"it assigns {place.id}.{name} twice")
        if not isinstance(assignment.value, FieldName):
            value = _constant(assignment.value, field)
            if value not in values:
                raise GuardError(f"{place.id}.{name} cannot be {_shown(assignment.value)}")
            given[name] = value
            continue
        source = _place(assignment.value, seen, fields, "takes")
        if seen[source] != 1:
            raise GuardError(
                f"it copies a field of {source.id}, of which the transition sees {seen[source]} tokens",
                hint="let it take or read one token, by one arc",
            )
        _, others = _finite(fields(source), assignment.value.field)
        if not set(others) <= set(values):
            raise GuardError(
                f"{source.id}.{assignment.value.field} has values that {place.id}.{name} cannot have",
                hint="give both fields the same range",
            )
        given[name] = (source, assignment.value.field)
    return found


def _conjuncts(condition: Condition) -> list[Condition]:
    if not isinstance(condition, And):
        return [condition]
    return [inner for part in condition.parts for inner in _conjuncts(part)]


def _place(name: FieldName, places: Mapping[pn.Place, int], fields: Fields, does: str) -> pn.Place:
    """Return the place that a field belongs to: the one with the id, or the only one with such a field."""
    if name.place is not None:
        found = [place for place in places if place.id == name.place]
        if not found:
            ids = [str(place.id) for place in places]
            hint = near_matches(name.place, ids) or f"its places are {', '.join(ids) or 'none'}"
            raise GuardError(f"the transition {does} no {name.place!r}", hint=hint)
        return found[0]
    found = [place for place in places if name.field in fields(place)]
    if len(found) != 1:
        several = ", ".join(str(place.id) for place in found)
        if found:
            raise GuardError(
                f"several places have {name.field!r}: {several}",
                hint=f"write {FieldName(str(found[0].id), name.field)}",
            )
        known = sorted({each for place in places for each in fields(place)})
        raise GuardError(f"no place has a field {name.field!r}", hint=near_matches(name.field, known))
    return found[0]


def _finite(known: Mapping[str, FieldType], name: str) -> tuple[FieldType, tuple[int, ...]]:
    field = known.get(name)
    if field is None:
        raise GuardError(f"the tokens have no field {name!r}", hint=near_matches(name, known))
    values = finite_values(field)
    if values is None:
        raise GuardError(
            f"the field {name!r} has no range of at most {MOST_VALUES} values",
            hint="use a boolean, or give an integer a minimum and a maximum, or named values",
        )
    return field, values


def _constant(value: Constant, field: FieldType) -> int:
    """Return a constant as a number for a field."""
    if isinstance(value, str):
        number = field.range.value_of(value)
        if number is None:
            names = [name for name, _ in field.range.names]
            hint = near_matches(value, names) or (f"its values are {', '.join(names)}" if names else None)
            raise GuardError(f"the field {field.name!r} has no value {value!r}", hint=hint)
        return number
    if isinstance(value, bool) != (field.kind == "boolean"):
        wanted = "true or false" if field.kind == "boolean" else "a number"
        raise GuardError(f"the field {field.name!r} takes {wanted}, not {_shown(value)}")
    return int(value)


def _shown(value: Constant) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _resolved(comparison: Comparison, known: Mapping[str, FieldType]) -> Comparison:
    field, _ = _finite(known, comparison.field.field)
    if field.kind == "boolean" and comparison.sign not in ("=", "<>"):
        raise GuardError(
            f"the field {field.name!r} is true or false, which {comparison.sign!r} does not order"
        )
    value = _constant(comparison.value, field)
    return replace(comparison, field=FieldName(None, field.name), value=value)


def satisfying(condition: Condition, known: Mapping[str, FieldType]) -> dict[str, int] | None:
    """Return field values that fulfil a condition, small values first; None if there are none.

    Parameters
    ----------
    condition : Condition
        A condition about one token, whose names are resolved.
    known : mapping of str to FieldType
        The fields of the token.

    Raises
    ------
    GuardError
        There are too many values.
    """
    names = list(dict.fromkeys(each.field for each in comparisons(condition)))
    classes = [
        classes_of(known[name.field], [c for c in comparisons(condition) if c.field == name])
        for name in names
    ]
    total = 1
    for each in classes:
        total *= len(each)
    if total > MOST_VALUES:
        raise GuardError(f"it tells {total} kinds of tokens apart, more than {MOST_VALUES}")
    for choice in product(*classes):
        values = dict(zip(names, (values[0] for values in choice), strict=True))
        if condition.holds(values):
            return {name.field: value for name, value in values.items()}
    return None


def classes_of(field: FieldType, asked: Iterable[Comparison]) -> list[tuple[int, ...]]:
    """Return the values of a field, grouped if no comparison distinguishes them; in ascending order."""
    distinct = list(dict.fromkeys(asked))
    classes: dict[tuple[bool, ...], list[int]] = {}
    for value in finite_values(field) or ():
        signature = tuple(each.holds({each.field: value}) for each in distinct)
        classes.setdefault(signature, []).append(value)
    return [tuple(values) for values in classes.values()]
