"""Finds what one turn of a loop leaves for the next: functions, ports and lists of them, in variables."""

from __future__ import annotations

import ast
from dataclasses import dataclass, field

from dineros.sources.language.values import (
    Const,
    Frame,
    Holder,
    Items,
    Mapping,
    Open,
    OutsideMethod,
    Text,
    Value,
    identity,
    is_none,
    join,
    options,
)

MOST_TURNS_AGAIN = 2
"""Limit of the loops inside each other whose bodies are followed for a second turn."""


@dataclass(frozen=True)
class _Uses:
    """What the body of a loop reads and assigns."""

    names: tuple[str, ...]
    """Variables that it reads before it assigns them."""
    attributes: tuple[tuple[str, str], ...]
    """The same of attributes: the variable of the object, and the attribute."""
    read: tuple[str, ...]
    """All variables that it reads."""


@dataclass
class Carried:
    """The variables of a loop before its body was followed.

    Parameters
    ----------
    body : list of ast.stmt
        The body of the loop.
    frame : Frame
        Its variables.
    """

    body: list[ast.stmt]
    frame: Frame
    _before: dict[str, Value] = field(init=False)
    _slots: dict[tuple[str, str], Value] = field(init=False, default_factory=dict)
    _sizes: dict[str, int] = field(init=False)

    def __post_init__(self) -> None:
        uses = _uses(self.body)
        self._before = {name: self.frame.names[name] for name in uses.names if name in self.frame.names}
        self._sizes = {name: _size(self.frame.names.get(name)) for name in uses.read}
        for name, attribute in uses.attributes:
            holder = self.frame.names.get(name)
            if isinstance(holder, Holder) and attribute in holder.slots:
                self._slots[name, attribute] = holder.slots[attribute].current

    def matters(self) -> bool:
        """Return whether the next turn may do other things than the first one; give it all values."""
        names, found = self.frame.names, False
        for name, before in self._before.items():
            if _is_new(before, names.get(name, before)):
                names[name] = join([before, names[name]])
                found = True
        for (name, attribute), before in self._slots.items():
            holder = self.frame.names.get(name)
            slot = holder.slots[attribute] if isinstance(holder, Holder) else None
            if slot is not None and _is_new(before, slot.current):
                slot.current = join([before, slot.current])
                found = True
        return found or any(_size(names.get(name)) > size for name, size in self._sizes.items())


def _is_new(before: Value, after: Value) -> bool:
    """Return whether a value has new functions, objects or ports, or was None and is not now."""
    known = options(before)
    if all(isinstance(each, Const) for each in known) and any(map(is_none, known)):
        known = [Const(None)]
    had = {identity(each) for each in known}
    new = [each for each in options(after) if identity(each) not in had]
    was_none = all(is_none(each) for each in known)
    return any(was_none or not isinstance(each, (Const, Open, OutsideMethod, Text)) for each in new)


def _size(value: Value | None) -> int:
    """Return how many functions, objects and ports the lists and dictionaries of a value hold."""
    count = 0
    for each in options(value):
        inner = each.items if isinstance(each, Items) else []
        if isinstance(each, Mapping):
            inner = [*each.items.values(), *each.rest]
        count += sum(not isinstance(item, (Const, Open, OutsideMethod, Text)) for item in inner)
    return count


def _uses(body: list[ast.stmt]) -> _Uses:
    """Return what the body of a loop reads and assigns; it is found once."""
    known: _Uses | None = getattr(body[0], "uses_from_here", None)
    if known is None:
        known = body[0].uses_from_here = _uses_in(body)  # type: ignore[attr-defined]
    return known


def _uses_in(body: list[ast.stmt]) -> _Uses:
    read: dict[str, tuple[int, int]] = {}
    assigned: dict[str, tuple[int, int]] = {}
    for part in (each for statement in body for each in ast.walk(statement)):
        if isinstance(part, ast.Name):
            name = part.id
        elif isinstance(part, ast.Attribute) and isinstance(part.value, ast.Name):
            name = f"{part.value.id}.{part.attr}"
        else:
            continue
        at = part.lineno, part.col_offset
        if isinstance(part.ctx, ast.Load):
            read[name] = min(at, read.get(name, at))
        else:
            assigned[name] = max(at, assigned.get(name, at))
    both = [name for name, at in assigned.items() if name in read and read[name] < at]
    pairs = [name.split(".") for name in both if "." in name]
    return _Uses(
        tuple(name for name in both if "." not in name),
        tuple((owner, attribute) for owner, attribute in pairs),
        tuple(name for name in read if "." not in name),
    )
