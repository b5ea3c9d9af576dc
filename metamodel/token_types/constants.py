"""Which field of a ROS message its constants are values of: ``uint8 STATE_IDLE=0`` of ``uint8 state``.

ROS 2 does not say to which field a constant belongs, and lets a field have other values, such as sums of
flags. So constants are names of values, and only if one field fits: the one whose name the constant begins
with, else the only integer field of the constant's type.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

from dineros.metamodel.token_data import FieldType, Value
from dineros.metamodel.value_ranges import ValueRange


class Constant(NamedTuple):
    """A constant of a message."""

    type: str
    name: str
    value: Value


def with_named_values(fields: Sequence[FieldType], constants: Iterable[Constant]) -> tuple[FieldType, ...]:
    """Return fields of a message, with the constants that are values of them as open ranges.

    Parameters
    ----------
    fields : sequence of FieldType
        The fields.
    constants : iterable of Constant
        The constants, in the order of the definition.

    Examples
    --------
    >>> state = FieldType("state", "integer", "text", None, 0, "uint8", None, ())
    >>> constants = [Constant("uint8", "STATE_IDLE", 0), Constant("uint8", "BUSY", 1)]
    >>> (named,) = with_named_values([state], constants)
    >>> named.range.names, named.range.is_open
    ((('STATE_IDLE', 0), ('BUSY', 1)), True)
    """
    integers = {each.name: each for each in fields if each.kind == "integer" and each.ros is not None}
    named: dict[str, list[tuple[str, int]]] = {}
    others: list[Constant] = []
    for constant in constants:
        if isinstance(constant.value, bool) or not isinstance(constant.value, int):
            continue
        same = [name for name, field in integers.items() if field.ros == constant.type]
        begun = [name for name in same if constant.name.startswith(f"{name.upper()}_")]
        if begun:
            named.setdefault(max(begun, key=len), []).append((constant.name, constant.value))
        else:
            others.append(constant)
    for constant in others:
        same = [name for name, field in integers.items() if field.ros == constant.type]
        if len(same) == 1:
            named.setdefault(same[0], []).append((constant.name, int(constant.value)))  # type: ignore[arg-type]
    return tuple(
        replace(each, range=ValueRange(names=tuple(named[each.name]), is_open=True))
        if each.name in named
        else each
        for each in fields
    )
