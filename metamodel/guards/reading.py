"""Guards and assignments of a transition, with their place and field names resolved in the model."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from itertools import product

from dineros.metamodel import pn
from dineros.metamodel.clauses.expressions import And, Or
from dineros.metamodel.errors import GuardError, near_matches
from dineros.metamodel.guards.conditions import (
    TURNED,
    Comparison,
    Condition,
    Constant,
    FieldName,
    comparisons,
    with_comparisons,
)
from dineros.metamodel.guards.parser import parse_assignments, parse_guard
from dineros.metamodel.guards.values import (
    Values,
    classes_of,
    contains,
    is_subset,
    sample,
    size,
    values_of,
    values_text,
)
from dineros.metamodel.token_data import FieldType

MOST_KINDS = 4096
"""Most kinds of tokens of one place that guards may distinguish."""

Fields = Callable[[pn.Place], Mapping[str, FieldType]]
"""Returns the fields of the tokens of a place, by name."""

Source = tuple[pn.Place, str]
"""A field of the token that is taken or read from a place."""


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
        places = dict.fromkeys(
            _place(field, seen, fields, "takes") for each in comparisons(part) for field in each.fields
        )
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
        known = fields(place)
        if satisfying(condition, known) is None:
            names = dict.fromkeys(each.field.field for each in comparisons(condition))
            ranges = "; ".join(f"{name}: {_all_values(known[name])}" for name in names)
            raise GuardError(
                f"no token of {place.id} can fulfil it", hint=f"its fields have values: {ranges}"
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
        field, values = _asked(fields(place), name)
        given = found.setdefault(place, {})
        if name in given:
            raise GuardError(f"it assigns {place.id}.{name} twice")
        if not isinstance(assignment.value, FieldName):
            value = _constant(assignment.value, field)
            if not contains(values, value):
                raise GuardError(f"{place.id}.{name} cannot be {_shown(assignment.value)}")
            given[name] = value
            continue
        source = _place(assignment.value, seen, fields, "takes")
        if seen[source] != 1:
            raise GuardError(
                f"it copies a field of {source.id}, of which the transition sees {seen[source]} tokens",
                hint="let it take or read one token, by one arc",
            )
        _, others = _asked(fields(source), assignment.value.field)
        if not is_subset(others, values):
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
            raise GuardError(f"the transition {does} no {name.place!r:.60}", hint=hint)
        return found[0]
    found = [place for place in places if name.field in fields(place)]
    if len(found) != 1:
        several = ", ".join(str(place.id) for place in found)
        if found:
            raise GuardError(
                f"several places have {name.field!r:.60}: {several}",
                hint=f"write {FieldName(str(found[0].id), name.field)}",
            )
        known = sorted({each for place in places for each in fields(place)})
        meant = near_matches(name.field, known)
        if meant is None and re.fullmatch("[A-Z_0-9]+", name.field):
            meant = f"write names of values in single quotes: state = '{name.field:.60}'"
        raise GuardError(f"no place has a field {name.field!r:.60}", hint=meant)
    return found[0]


def _asked(known: Mapping[str, FieldType], name: str) -> tuple[FieldType, Values]:
    """Return a field with its values."""
    field = known.get(name)
    if field is None:
        raise GuardError(f"the tokens have no field {name!r:.60}", hint=near_matches(name, known))
    values = values_of(field)
    if values is None:
        raise GuardError(
            f"the field {name!r:.60} is neither a boolean nor an integer", hint="use a boolean or an integer"
        )
    return field, values


def _constant(value: Constant, field: FieldType) -> int:
    """Return a constant as a number for a field."""
    if isinstance(value, str):
        number = field.range.value_of(value)
        if number is None:
            names = [name for name, _ in field.range.names]
            hint = near_matches(value, names) or (f"its values are {', '.join(names)}" if names else None)
            raise GuardError(f"the field {field.name!r} has no value {value!r:.60}", hint=hint)
        return number
    if isinstance(value, bool) != (field.kind == "boolean"):
        wanted = "true or false" if field.kind == "boolean" else "a number"
        raise GuardError(f"the field {field.name!r} takes {wanted}, not {_shown(value)}")
    return int(value)


def _all_values(field: FieldType) -> str:
    text = values_text(field, values_of(field) or ())
    return text if len(text) <= 80 else f"{text[:77]}..."


def _shown(value: Constant) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _resolved(comparison: Comparison, known: Mapping[str, FieldType]) -> Condition:
    field, values = _asked(known, comparison.field.field)
    if field.kind == "boolean" and comparison.sign not in ("=", "<>"):
        raise GuardError(
            f"the field {field.name!r} is true or false, which {comparison.sign!r} does not order"
        )
    own = FieldName(None, field.name)
    if not isinstance(comparison.value, FieldName):
        return replace(comparison, field=own, value=_constant(comparison.value, field))
    other, others = _asked(known, comparison.value.field)
    if (field.kind == "boolean") != (other.kind == "boolean"):
        raise GuardError(f"it compares a boolean with a number: {comparison.field} and {comparison.value}")
    return _of_two_fields(own, comparison.sign, FieldName(None, other.name), values, others)


def _of_two_fields(
    field: FieldName, sign: str, other: FieldName, values: Values, others: Values
) -> Condition:
    """Return a comparison of two fields of a token as comparisons with constants, one for each value."""
    kinds = size(values) * size(others)
    if kinds > MOST_KINDS:
        raise GuardError(
            f"comparing {field} with {other} tells {kinds} kinds of tokens apart, more than {MOST_KINDS}",
            hint="give both fields a range, or names for all their values",
        )
    each_value = (value for low, high in values for value in range(low, high + 1))
    return Or(
        tuple(
            And((Comparison(field, "=", value), Comparison(other, TURNED.get(sign, sign), value)))
            for value in each_value
        )
    )


def satisfying(condition: Condition, known: Mapping[str, FieldType]) -> dict[str, int] | None:
    """Return field values that fulfil a condition, close to zero; None if there are none.

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
    if total > MOST_KINDS:
        raise GuardError(f"it tells {total} kinds of tokens apart, more than {MOST_KINDS}")
    for choice in product(*classes):
        values = dict(zip(names, map(sample, choice), strict=True))
        if condition.evaluate(values):
            return {name.field: value for name, value in values.items()}
    return None
