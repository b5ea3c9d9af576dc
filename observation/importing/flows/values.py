"""Values of the fields of messages, as code writes them and as guards write them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.token_types.installed import installed_constants
from dineros.observation.importing.flows.labels import Deciding
from dineros.sources.interfaces import Interfaces
from dineros.sources.variables import Known

ANOTHER = "ANOTHER_VALUE"
"""Name of all values of a field that the code does not name."""
_PARTS = ("Request", "Response", "Goal", "Result", "Feedback")
_MOST_VALUES = 16
"""Limit of the values of a field that a model distinguishes."""
_WORDS = {"AND", "BETWEEN", "FALSE", "NOT", "OR", "TRUE", ANOTHER}


_RANGES = {
    **{f"int{bits}": (-(1 << bits - 1), (1 << bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": (0, (1 << bits) - 1) for bits in (8, 16, 32, 64)},
    "char": (0, 127),
}
"""Least and greatest numbers of ROS types; C++ converts others without an error."""
KINDS = frozenset((*_RANGES, "bool"))
"""ROS types of fields that may decide. A ``byte`` is not a number in Python: it equals no integer."""


def number_of(known: Known, interfaces: Interfaces) -> bool | int | None:
    """Return the truth value or whole number that code names; None: it is unknown.

    Parameters
    ----------
    known : Known
        A constant, or the path of a constant of an interface: ``arm_msgs.msg.State.IDLE``.
    interfaces : Interfaces
        Those of the folders.
    """
    if known[0] == "const":
        return known[2] if isinstance(known[2], int) else None
    path = str(known[1]).split(".")
    if len(path) not in (4, 5) or (len(path) == 5 and path[3] not in _PARTS):
        return None
    package, kind, *names, constant = path
    part = f"{package}/{kind}/{'_'.join(names)}"
    found: Any = interfaces.constants(part).get(constant)
    if found is None and kind == "msg" and part not in interfaces.types:
        try:
            found = installed_constants(part).get(constant)
        except DinerosError:
            return None
    return found if isinstance(found, int) else None


def deciding(
    type: str,
    name: str,
    kind: str,
    possible: Iterable[Known],
    asked: Iterable[Known],
    interfaces: Interfaces,
    *,
    has_others: bool,
) -> Deciding | None:
    """Return a field that decides about branches; None: its values are not known, or too many.

    Parameters
    ----------
    type : str
        Of the messages, or of the service.
    name, kind : str
        Of the field; its ROS type.
    possible : iterable of Known
        What the code assigns to it.
    asked : iterable of Known
        With what the code compares it.
    interfaces : Interfaces
        Those of the folders.
    has_others : bool
        Whether it may have values that the code does not name.
    """
    given = list(possible)
    numbers: dict[Known, int] = {}
    for each in sorted({*given, *asked}, key=repr):
        found = number_of(each, interfaces)
        if found is not None and is_of(kind, each, interfaces):
            numbers[each] = found
    if kind == "bool":
        return Deciding(type, name, known={each: str(bool(truth)).lower() for each, truth in numbers.items()})
    names: dict[int, str] = {}
    for each, number in numbers.items():
        constant = str(each[1]).rpartition(".")[2] if each[0] == "outside" else ""
        if constant.upper() not in _WORDS and constant and constant not in names.values():
            names.setdefault(number, constant)
    for number in sorted(set(numbers.values()) - set(names)):
        free = f"VALUE_{'MINUS_' if number < 0 else ''}{abs(number)}"
        while free in names.values():
            free += "_OF_CODE"
        names[number] = free
    distinct = sorted(
        {numbers[each] for each in given if each in numbers} | (set(names) if has_others else set())
    )
    other = max(names, default=0) + 1
    if has_others:
        distinct.append(other)
        names[other] = ANOTHER
    if not 0 < len(distinct) <= _MOST_VALUES:
        return None
    known = {each: names[number] for each, number in numbers.items()}
    return Deciding(type, name, tuple(names[each] for each in distinct), tuple(distinct), known)


def is_of(kind: str, known: Known, interfaces: Interfaces) -> bool:
    """Return whether a value in the code is a known one of the fields of a ROS type."""
    found = number_of(known, interfaces)
    if found is None or isinstance(found, bool) != (kind == "bool"):
        return False
    least, most = _RANGES.get(kind, (0, 1))
    return least <= found <= most
