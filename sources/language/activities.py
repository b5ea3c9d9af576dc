"""The code that is being read, with its branches: it gets the effects."""

from __future__ import annotations

from dataclasses import dataclass, field

from dineros.sources.branches import Anything, Branch, Loop
from dineros.sources.facts import CallbackFact, Item, NodeFact
from dineros.sources.language.attributes import Slots, Written
from dineros.sources.language.values import Value


@dataclass(eq=False)
class Activity:
    """The code that is being read and gets the effects: main function, constructor, callback or thread."""

    fact: CallbackFact
    """Gets the effects."""
    node: NodeFact | None = None
    """Whose it is."""
    conditional: int = 0
    loops: int = 0
    disabled: int = 0
    """`conditional`, `loops`, `disabled`: in how many branches, loops, and branches that are not taken by
    default.
    """
    holding: list[tuple[str, Value, bool]] = field(default_factory=list)
    """The locks that are held: name, lock, and whether a ``with`` certainly holds it."""
    acquired: list[tuple[str, Value, bool]] = field(default_factory=list)
    """All locks that were acquired, also if they are released again."""
    block: list[Item] = field(default_factory=list)
    """What is done in the innermost branch, in its order."""
    is_lost: bool = False
    """Whether the order of what is done could not be followed."""
    written: list[tuple[int, Written]] = field(default_factory=list)
    """For each branch around the current code: how many there are, and the attributes that it sets."""

    def locks(self) -> tuple[str, ...]:
        """Return the names of the locks that are held."""
        return tuple(name for name, _, _ in self.holding)

    def release(self, lock: Value) -> None:
        """Release a lock, if it is held."""
        last = next((each for each in reversed(self.holding) if each[1] is lock), None)
        if last is not None:
            self.holding.remove(last)


class Block:
    """Collects the effects of an activity in a block of its own; a class, as it is entered for each test."""

    __slots__ = ("_activity", "_outer")

    def __init__(self, activity: Activity) -> None:
        self._activity = activity

    def __enter__(self) -> list[Item]:
        self._outer = self._activity.block
        found: list[Item] = []
        self._activity.block = found
        return found

    def __exit__(self, *rest: object) -> None:
        self._activity.block = self._outer


class Perhaps:
    """Runs code that may be executed any number of times, see `Machine.perhaps`."""

    __slots__ = ("_activity", "_done", "_is_disabled", "_is_kept", "_is_loop", "_outer", "_slots", "_ways")

    def __init__(
        self,
        slots: Slots,
        activity: Activity,
        *,
        is_loop: bool,
        is_disabled: bool,
        is_kept: bool,
        ways: list[Written] | None,
    ) -> None:
        self._slots, self._activity, self._ways = slots, activity, ways
        self._is_loop, self._is_disabled, self._is_kept = is_loop, is_disabled, is_kept

    def __enter__(self) -> list[Item]:
        activity = self._activity
        activity.conditional += 1
        activity.loops += self._is_loop
        activity.disabled += self._is_disabled
        activity.written.append((activity.conditional, {}))
        self._outer = activity.block
        self._done: list[Item] = []
        activity.block = self._done
        return self._done

    def __exit__(self, kind: object, *rest: object) -> None:
        activity, ways = self._activity, self._ways
        activity.block = self._outer
        written = activity.written.pop()[1]
        if written:
            found = [] if ways is None else ways
            if not self._is_disabled:
                found.append({slot: (before, slot.current) for slot, (before, _) in written.items()})
            for slot, (before, _) in written.items():
                slot.current = slot.current if before is None else before
            if ways is None:
                self._slots.merge_slots(found, has_rest=True)
        elif ways is not None and not self._is_disabled:
            ways.append({})
        activity.conditional -= 1
        activity.loops -= self._is_loop
        activity.disabled -= self._is_disabled
        if self._done and not self._is_kept and kind is None:
            done = self._done
            activity.block.append(Loop(Anything(), done) if self._is_loop else Branch(Anything(), done, []))
