"""Handles: references of commands to the objects of a model, including objects without ids.

Objects are numbered when a model is opened, in the order of the metamodel, and later as they are made. So the
same file and commands always give the same handles, and a journal can be replayed.
"""

from __future__ import annotations

from collections.abc import Iterator

from dineros.metamodel.base import EObject
from dineros.metamodel.editing.commands import CommandError
from dineros.metamodel.files.schema import parts_of


class Handles:
    """The handles of one model; deleted objects keep theirs, in case they are restored."""

    def __init__(self, root: EObject) -> None:
        self._objects: list[EObject] = []
        self._numbers: dict[EObject, int] = {}
        for element in subtree(root):
            self.number(element)

    def __len__(self) -> int:
        return len(self._objects)

    def number(self, element: EObject) -> str:
        """Assign a handle to a new object."""
        self._numbers[element] = len(self._objects)
        self._objects.append(element)
        return f"e{self._numbers[element]}"

    def forget_from(self, count: int) -> None:
        """Remove the handles of objects beyond the first `count`; there must be no references to them."""
        for element in self._objects[count:]:
            del self._numbers[element]
        del self._objects[count:]

    def of(self, element: EObject) -> str | None:
        """Return the handle of an object; None: it belongs to another model."""
        number = self._numbers.get(element)
        return None if number is None else f"e{number}"

    def find(self, handle: str) -> EObject:
        """Return the object with a handle.

        Raises
        ------
        CommandError
            There has never been one.
        """
        digits = handle[1:]
        known = handle[:1] == "e" and 0 < len(digits) < 10 and digits.isascii() and digits.isdigit()
        if not known or int(digits) >= len(self._objects) or (len(digits) > 1 and digits[0] == "0"):
            raise CommandError(f"no element has the handle {handle[:40]!r}")
        return self._objects[int(digits)]


def subtree(element: EObject) -> Iterator[EObject]:
    """Yield an object and all its parts, outer ones first, in the order of the metamodel."""
    stack = [element]
    while stack:
        each = stack.pop()
        yield each
        stack.extend(reversed(parts_of(each)))
