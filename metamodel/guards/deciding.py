"""Guards and assignments for single tokens: conditions on their data, and values assigned to their fields.

All code that fires transitions with data, or checks such firings, uses this module.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from dineros.metamodel import pn, sym
from dineros.metamodel.errors import GuardError
from dineros.metamodel.guards.colours import Step
from dineros.metamodel.guards.conditions import Condition, comparisons
from dineros.metamodel.guards.reading import Fields, read_assignments, read_guard
from dineros.metamodel.token_data import FieldType, Value


def read_step(
    transition: sym.Transition, seen: Mapping[pn.Place, int], puts: Iterable[pn.Place], fields: Fields
) -> Step:
    """Return the guard and the assignments of a transition.

    Parameters
    ----------
    transition : sym.Transition
        The transition.
    seen : mapping of place to int
        Number of tokens that it takes or reads.
    puts : iterable of place
        Places where it puts tokens.
    fields : callable
        The fields of a place's tokens.

    Raises
    ------
    GuardError
        The texts cannot be read, or name an element that does not exist.
    """
    try:
        guard = {} if transition.guard is None else read_guard(transition.guard, seen, fields)
        assigned = (
            {} if transition.assigns is None else read_assignments(transition.assigns, seen, puts, fields)
        )
    except GuardError as error:
        error.element = transition.id
        raise
    return Step(guard, assigned)


def fulfils(condition: Condition, data: Mapping[str, object]) -> bool:
    """Return whether a token with some data fulfils a condition whose names are resolved."""
    values = {}
    for each in comparisons(condition):
        value = data[each.field.field]
        assert isinstance(value, int), "a field with a range is a number or a truth value"
        values[each.field] = int(value)
    return condition.evaluate(values)


def as_value(number: int, field: FieldType) -> Value:
    """Return the value that a number stands for in a field of a token."""
    return bool(number) if field.kind == "boolean" else number


def value_text(value: object, field: FieldType) -> str:
    """Return a value of a field as guards write it: by its name, if it has one."""
    if isinstance(value, bool):
        return str(value).lower()
    return next((name for name, number in field.range.names if number == value), str(value))
