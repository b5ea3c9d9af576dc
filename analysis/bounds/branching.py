"""Whether guards choose between branches: for all data of a token, one of them holds."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from dineros.metamodel import pn, sym
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.guards.conditions import Condition, FieldName, comparisons
from dineros.metamodel.guards.reading import read_guard
from dineros.metamodel.guards.values import classes_of, sample, values_of
from dineros.metamodel.token_data import FieldType
from dineros.metamodel.token_types.declared import token_type_of, type_of_place


def is_complete(steps: Iterable[tuple[sym.Transition, Counter[pn.Place]]], model: sym.SystemModel) -> bool:
    """Return whether one of some transitions has a guard that holds, whatever data a token has.

    Each guard asks one field of the token of one place, which is the same for all of them.

    Parameters
    ----------
    steps : iterable of (Transition, Counter)
        Transitions with guards, and how many tokens each takes or reads.
    model : SystemModel
        With the token types.
    """
    guards: dict[pn.Place, list[Condition]] = {}
    try:
        for step, seen in steps:
            read = read_guard(str(step.guard), seen, lambda place: _fields(place, model))
            if len(read) == 1:
                ((place, condition),) = read.items()
                guards.setdefault(place, []).append(condition)
    except DinerosError:
        return False
    return any(_covers(conditions, _fields(place, model)) for place, conditions in guards.items())


def _covers(conditions: list[Condition], fields: dict[str, FieldType]) -> bool:
    names = {each.field for condition in conditions for each in comparisons(condition)}
    if len(names) != 1:
        return False
    (name,) = names
    field = fields.get(name.field)
    if field is None or values_of(field) is None:
        return False
    asked = (each for condition in conditions for each in comparisons(condition))
    return all(
        any(condition.evaluate({FieldName(*name): sample(values)}) for condition in conditions)
        for values in classes_of(field, asked)
    )


def _fields(place: pn.Place, model: sym.SystemModel) -> dict[str, FieldType]:
    return {field.name: field for field in token_type_of(type_of_place(place, model)).fields}
