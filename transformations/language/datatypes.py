"""Compatibility of plain values and features: texts, numbers, Booleans, literals of enumerations."""

from __future__ import annotations

from typing import Any

from pyecore.ecore import EBoolean, EDouble, EEnum, EInt, EString

from dineros.metamodel.base import EnumLiteral, literals_of
from dineros.metamodel.errors import Location, near_matches
from dineros.transformations.language.errors import RuleError

TEXT, WHOLE, REAL, TRUTH = EString, EInt, EDouble, EBoolean

_OF_PYTHON: dict[type, Any] = {str: TEXT, bool: TRUTH, int: WHOLE, float: REAL}


def datatype_of(value: object) -> Any:
    """Return the Ecore type of a plain Python value; None: it has none."""
    if isinstance(value, EnumLiteral):
        return value.eContainer()  # type: ignore[attr-defined]
    return _OF_PYTHON.get(type(value))


def fits(given: Any, wanted: Any) -> bool:
    """Return whether a value of one type fits another type; unknown types (None) always fit."""
    if given is None or wanted is None:
        return True
    if isinstance(given, EEnum) or isinstance(wanted, EEnum):
        return given is wanted
    sides = [_OF_PYTHON.get(_python_type(each)) for each in (given, wanted)]
    return None in sides or sides[0] is sides[1] or sides == [WHOLE, REAL]


def comparable(one: Any, other: Any) -> bool:
    """Return whether values of two types can be equal."""
    return fits(one, other) or fits(other, one)


def _python_type(datatype: Any) -> type:
    found: type = datatype.eType
    return found


def literal_of(datatype: Any, value: object, location: Location) -> object:
    """Return the literal that a text names if an enumeration is required; other values are unchanged.

    Raises
    ------
    RuleError
        The enumeration has no such literal.
    """
    if not isinstance(datatype, EEnum) or not isinstance(value, str):
        return value
    literals = literals_of(datatype)
    literal = literals.get(value)
    if literal is None:
        names = list(literals)
        raise RuleError(
            f"{datatype.name} has no literal {value!r}",
            location=location,
            hint=near_matches(value, names) or f"it has {', '.join(names)}",
        )
    return literal
