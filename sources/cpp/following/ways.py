"""Follows branches of code: what a branch sets is certain in it, and possible after it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from dineros.sources.branches import Anything, Branch
from dineros.sources.cpp.values import Frame, Value, joined
from dineros.sources.facts import Item

Changes = dict[tuple[int, str], tuple[dict[str, Value], str, Value | None]]
"""Variables that a branch sets: where, their names, and their values before it."""
Way = dict[tuple[int, str], tuple[dict[str, Value], str, Value | None, Value]]
"""The same, with their values at its end."""


class Ways:
    """The branches around the current code."""

    def __init__(self) -> None:
        self.cond = 0
        self.off = 0
        """`cond`, `off`: number of branches around it, and of those that the default values disable."""
        self.branching: list[tuple[int, int]] = []
        """The branches of ``if`` around it: of which run of the statement, and which branch."""
        self.frames: list[Frame] = []
        """Routines that run."""
        self.changes: list[Changes] = []
        """What each branch has set."""
        self.block: list[Item] = []
        self.taken: list[Item] = []
        """`block`, `taken`: what the current block, and the last branch, do."""
        self.is_lost = False
        """Whether the order of effects is not known."""

    @contextmanager
    def perhaps(self, *, is_off: bool = False) -> Iterator[None]:
        """Run code that may not be executed; `is_off`: code that the default values disable."""
        ways: list[Way] = []
        try:
            with self.way(ways, is_off=is_off):
                yield
        finally:
            self.merge(ways, has_rest=True)
            self.block.append(Branch(Anything(), self.taken, []))

    @contextmanager
    def way(self, ways: list[Way], *, is_off: bool = False) -> Iterator[None]:
        """Run one of several branches; `ways` has its values, and variables have those from before again."""
        self.cond += 1
        self.off += is_off
        self.changes.append({})
        outer, self.block = self.block, []
        try:
            yield
        finally:
            self.taken, self.block = self.block, outer
            self.cond -= 1
            self.off -= is_off
            done = self.changes.pop()
            if not is_off:
                ways.append({key: (*each, each[0][each[1]]) for key, each in done.items()})
            for held, name, old in done.values():
                _put(held, name, old)

    def merge(self, ways: list[Way], *, has_rest: bool) -> None:
        """Give variables their possible values after branches; `has_rest`: perhaps none was taken."""
        for key in dict.fromkeys(key for way in ways for key in way):
            held, name, old, _ = next(way[key] for way in ways if key in way)
            values: list[Value | None] = [old] if has_rest or any(key not in way for way in ways) else []
            values += [way[key][3] for way in ways if key in way]
            found = values[0]
            for each in values[1:]:
                found = joined(found, each) if each is not None else found
            self._log(held, name)
            _put(held, name, found)

    def _log(self, held: dict[str, Value], name: str) -> None:
        """Remember the value of a variable before the current branch."""
        if self.changes:
            self.changes[-1].setdefault((id(held), name), (held, name, held.get(name)))

    def set_in(self, held: dict[str, Value], name: str, value: Value, *, is_local: bool = False) -> None:
        """Set a variable; at the end of a branch or loop, it may also have its previous value."""
        if not is_local and any(each.has_left for each in self.frames):
            if self.off:  # the end of the branch gives it the value from before again
                self._log(held, name)
            held[name] = joined(held.get(name), value)
            return
        self._log(held, name)
        held[name] = value


def _put(held: dict[str, Value], name: str, value: Value | None) -> None:
    if value is None:
        held.pop(name, None)
    else:
        held[name] = value
