"""Attributes of objects and variables of modules: what they are now, and what they may be after branches."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dineros.sources.language.values import Const, Holder, Made, Open, Slot, Value, join, same

if TYPE_CHECKING:
    from dineros.sources.language.machine import Activity

MOST_VALUES = 12
"""Limit of the values of an attribute."""
Written = dict[Slot, tuple[Value | None, Value]]
"""Attributes that a branch sets: their values before it, and at its end."""


class Slots:
    """Reads and writes attributes.

    Attributes
    ----------
    run : int
        Number of the current run of callbacks: in another one, attributes have any of their values.
    """

    run: int

    @property
    def activity(self) -> Activity:
        """The code that is being read."""
        raise NotImplementedError

    def read_slot(self, holder: Holder, name: str) -> Value | None:
        """Return the value of an attribute: the one assigned in this run, or all values that it has had."""
        slot = holder.slots.get(name)
        if slot is None:
            return None
        found = slot.current if slot.run == self.run else join(slot.values)
        if isinstance(found, Const) and not found.origin:
            return Const(found.value, "variable")
        return found

    def write_slot(self, holder: Holder, name: str, value: Value) -> None:
        """Assign a value to an attribute; in a branch, it may also have its previous value."""
        slot = holder.slots.get(name)
        is_perhaps = self.activity.conditional > (holder.level if isinstance(holder, Made) else 0)
        is_off = bool(self.activity.disabled)
        if slot is None or (slot.is_off and not is_off):
            holder.slots[name] = slot = Slot(value, [value], self.run, is_perhaps, is_off)
            if not is_off:
                self._log(slot, None)
            return
        slot.is_perhaps &= is_perhaps or is_off
        count = len(slot.values)
        if not any(same(value, each) for each in slot.values):
            if len(slot.values) >= MOST_VALUES:
                slot.values = [Open(name)]
            else:
                slot.values.append(value)
        if self.activity.disabled:
            return
        before = slot.current if slot.run == self.run else join(slot.values[:count])
        level = self.activity.written[-1][0] if self.activity.written else 0
        is_certain = not is_perhaps or level == self.activity.conditional
        self._log(slot, before)
        slot.current = value if is_certain else join([before, value])
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
            slot.run = self.run
