"""The three ways in which a model changes, each with its exact inverse, the order of all lists included.

References with a many-valued opposite, such as the source of an arc, are changed at that opposite: only there
the order is known that the inverse must bring back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from dineros.metamodel.base import EnumLiteral, EObject


@dataclass(frozen=True, eq=False)
class Valued:
    """A single-valued feature without a many-valued opposite had one value and gets another."""

    element: EObject
    feature: str
    before: Any
    after: Any

    def do(self) -> None:
        """Give it the new value."""
        setattr(self.element, self.feature, self.after)

    def undo(self) -> None:
        """Give it the former value."""
        setattr(self.element, self.feature, self.before)

    def touched(self) -> list[EObject]:
        """Return the objects that look different afterwards."""
        others = [each for each in (self.before, self.after) if isinstance(each, EObject)]
        return [self.element, *(each for each in others if not isinstance(each, EnumLiteral))]


@dataclass(frozen=True, eq=False)
class Inserted:
    """A list gets an object at a position."""

    element: EObject
    feature: str
    index: int
    value: EObject

    def do(self) -> None:
        """Put it in."""
        getattr(self.element, self.feature).insert(self.index, self.value)

    def undo(self) -> None:
        """Take it out."""
        getattr(self.element, self.feature).remove(self.value)

    def touched(self) -> list[EObject]:
        """Return the objects that look different afterwards."""
        return [self.element, self.value]


@dataclass(frozen=True, eq=False)
class Removed:
    """A list loses the object at a position."""

    element: EObject
    feature: str
    index: int
    value: EObject

    def do(self) -> None:
        """Take it out."""
        getattr(self.element, self.feature).remove(self.value)

    def undo(self) -> None:
        """Put it in where it was."""
        getattr(self.element, self.feature).insert(self.index, self.value)

    def touched(self) -> list[EObject]:
        """Return the objects that look different afterwards."""
        return [self.element, self.value]


Change: TypeAlias = Valued | Inserted | Removed


def redo(changes: Sequence[Change]) -> None:
    """Do changes again, in their order."""
    for change in changes:
        change.do()


def undo(changes: Sequence[Change]) -> None:
    """Take changes back, the last first."""
    for change in reversed(changes):
        change.undo()


def touched(changes: Sequence[Change]) -> list[EObject]:
    """Return the objects that changes concern, each once."""
    return list(dict.fromkeys(element for change in changes for element in change.touched()))
