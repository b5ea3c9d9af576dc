"""The attributes of objects that a program sets, and unknown code that could set them."""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING, Protocol

from dineros.sources.language.values import (
    Bound,
    Const,
    Either,
    Function,
    Holder,
    Made,
    Object,
    Outside,
    OutsideMethod,
    Partial,
    Port,
    Slot,
    Value,
    join,
)
from dineros.sources.places import Place
from dineros.sources.variables import Known, Variable

if TYPE_CHECKING:
    from dineros.sources.facts import CallbackFact

MOST_VALUES = 12
"""Limit of the values of an attribute."""
Written = dict[Slot, tuple[Value | None, Value]]
"""Attributes that a branch sets: their values before it, and at its end."""


class Attributes:
    """Known facts about the attributes of objects."""

    def __init__(self) -> None:
        self._all: dict[tuple[int, str], tuple[Object, Variable]] = {}
        self._first: dict[Variable, set[Known] | None] = {}
        self.stores: set[tuple[str, int, int]] = set()
        """Path, line and column of each assignment to an attribute that was followed."""
        self.names: set[str] = set()
        """Attributes that unknown code may set."""
        self.calls: set[str] = set()
        """Names of functions and methods that unknown code may call."""
        self.single: set[int] = set()
        """Ids of objects that are made once."""
        self.is_wild = False
        """Whether something unknown may call anything."""
        self.has_begun = False
        """Whether callbacks run already."""
        self.changed: list[tuple[str, CallbackFact]] = []
        """Names of attributes that were set or whose containers were changed, and the code that did it."""

    def of(self, holder: Object, name: str, at: Place) -> Variable:
        """Return the variable of an attribute."""
        if (id(holder), name) not in self._all:
            self._all[id(holder), name] = holder, Variable(name, at)
        return self._all[id(holder), name][1]

    def all(self) -> list[tuple[Object, Variable]]:
        """Return all variables with their objects, in the order in which they were found."""
        return list(self._all.values())

    def begin(
        self, variable: Variable, values: tuple[Known, ...] | None, at: Place, *, is_certain: bool
    ) -> None:
        """Record a value from before callbacks run; a value assigned in a branch is one of several."""
        variable.at = at
        if is_certain or variable not in self._first:
            self._first[variable] = set(values) if values is not None else None
            if not is_certain:
                self._first[variable] = None
            return
        before = self._first[variable]
        self._first[variable] = None if before is None or values is None else before | set(values)

    def has_first(self, variable: Variable) -> bool:
        """Return whether a variable was assigned before callbacks run."""
        return variable in self._first

    def first(self, variable: Variable) -> Known | None:
        """Return the only value of a variable when callbacks begin to run; None: unknown."""
        found = self._first.get(variable)
        return next(iter(found)) if found is not None and len(found) == 1 else None

    def may_call(self, function: Value | None) -> None:
        """Record that unknown code may call a function at any time."""
        if isinstance(function, Either):
            for each in function.options:
                self.may_call(each)
        elif isinstance(function, (Bound, Partial)):
            self.may_call(function.function)
        elif isinstance(function, Function):
            self.calls.add(function.name)
        elif isinstance(function, OutsideMethod):
            if not isinstance(function.instance, Object):
                self.calls.add(function.name)
        elif isinstance(function, Object):
            self.calls.add("__call__")
        elif not isinstance(function, Outside):
            self.is_wild = True


def changed_name(target: ast.expr) -> str | None:
    """Return the attribute that an assignment to an expression changes, or a method of it.

    Examples
    --------
    >>> changed_name(ast.parse("self.data['pose'][0]").body[0].value)
    'data'
    """
    while isinstance(target, (ast.Subscript, ast.Starred)):
        target = target.value
    return target.attr if isinstance(target, ast.Attribute) else None


class Branches(Protocol):
    """The branches around the code that is being read, see `dineros.sources.language.machine.Activity`."""

    conditional: int
    disabled: int
    written: list[tuple[int, Written]]


class Slots:
    """Reads and writes attributes."""

    run: int
    """Number of the current run of callbacks: in another one, attributes have any of their values."""
    changes: int = 0
    """How often an attribute got another value than those that it has had."""
    activity: Branches

    def read_slot(self, holder: Holder, name: str) -> Value | None:
        """Return the value of an attribute: the one assigned in this run, or all values that it has had."""
        slot = holder.slots.get(name)
        if slot is None:
            return None
        found = slot.current if slot.run == self.run else slot.any()
        if isinstance(found, Const) and not found.origin:
            return Const(found.value, "variable", found.enum)
        return found

    def write_slot(self, holder: Holder, name: str, value: Value) -> None:
        """Assign a value to an attribute; in a branch, it may also have its previous value."""
        slot = holder.slots.get(name)
        is_perhaps = self.activity.conditional > (holder.level if isinstance(holder, Made) else 0)
        is_off = bool(self.activity.disabled)
        if slot is None or (slot.is_off and not is_off):
            holder.slots[name] = slot = Slot(value, self.run, is_perhaps, is_off)
            slot.add(value, MOST_VALUES, name)
            slot.is_late = isinstance(holder, Object) and holder.run != self.run
            slot.is_mixed = is_perhaps
            self.changes += 1
            if not is_off:
                self._log(slot, None)
            return
        slot.is_perhaps &= is_perhaps or is_off
        before = slot.current if slot.run == self.run else slot.any()
        self.changes += slot.add(value, MOST_VALUES, name)
        if self.activity.disabled:
            return
        level = self.activity.written[-1][0] if self.activity.written else 0
        is_certain = not is_perhaps or level == self.activity.conditional
        self._log(slot, before)
        slot.current = value if is_certain else join([before, value])
        slot.is_mixed = not is_certain and (slot.is_mixed or slot.run != self.run)
        slot.run = self.run

    def _log(self, slot: Slot, before: Value | None) -> None:
        """Remember the value of an attribute before the current branch."""
        if self.activity.written:
            self.activity.written[-1][1].setdefault(slot, (before, slot.current))

    def merge_slots(self, ways: list[Written], *, has_rest: bool) -> None:
        """Give attributes their possible values after branches; `has_rest`: perhaps none was taken."""
        for slot in dict.fromkeys(slot for way in ways for slot in way):
            before = next(way[slot][0] for way in ways if slot in way)
            is_kept = has_rest or any(slot not in way for way in ways)
            values = [before] if is_kept and before is not None else []
            self._log(slot, before)
            slot.current = join([*values, *(way[slot][1] for way in ways if slot in way)])
            slot.is_mixed |= is_kept
            slot.run = self.run


def lend(instance: Object, depth: int) -> None:
    """Record that unknown code gets an object, with the ports of all objects at most `depth` steps away."""
    seen = {instance}
    level = [instance]
    while level:
        reached: list[Object] = []
        for each in level:
            if each.node is not None:
                each.node.is_lent = True
            for slot in each.slots.values() if depth else ():
                for held in slot.holders():
                    if isinstance(held, Port):
                        held.entity.is_lent = True
                    elif held not in seen:
                        seen.add(held)
                        reached.append(held)
        level = reached
        depth -= 1
