"""The three kinds of changes of a model, each with its exact inverse, including the order of all lists.

A reference with a many-valued opposite, such as the source of an arc, is changed at that opposite: only
there, the order is known that the inverse must restore.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from dineros.metamodel import pn
from dineros.metamodel.base import EnumLiteral, EObject, features_of
from dineros.metamodel.editing.commands import CommandError
from dineros.metamodel.editing.handles import subtree
from dineros.metamodel.files.schema import Kind, class_of, values_of


@dataclass(frozen=True, eq=False)
class Valued:
    """The change of a single-valued feature without a many-valued opposite from one value to another."""

    element: EObject
    feature: str
    before: Any
    after: Any

    def do(self) -> None:
        """Set the new value."""
        setattr(self.element, self.feature, self.after)

    def undo(self) -> None:
        """Restore the former value."""
        setattr(self.element, self.feature, self.before)

    def touched(self) -> list[EObject]:
        """Return the objects whose appearance changes."""
        others = [each for each in (self.before, self.after) if isinstance(each, EObject)]
        return [self.element, *(each for each in others if not isinstance(each, EnumLiteral))]


@dataclass(frozen=True, eq=False)
class _InList:
    """An insertion or removal of an object at a position of a list."""

    element: EObject
    feature: str
    index: int
    value: EObject

    def _put_in(self) -> None:
        getattr(self.element, self.feature).insert(self.index, self.value)

    def _take_out(self) -> None:
        getattr(self.element, self.feature).remove(self.value)

    def touched(self) -> list[EObject]:
        """Return the objects whose appearance changes."""
        return [self.element, self.value]


class Inserted(_InList):
    """The insertion of an object into a list, at a position."""

    def do(self) -> None:
        """Insert the object."""
        self._put_in()

    def undo(self) -> None:
        """Remove the object."""
        self._take_out()


class Removed(_InList):
    """The removal of an object at a position of a list."""

    def do(self) -> None:
        """Remove the object."""
        self._take_out()

    def undo(self) -> None:
        """Insert the object at its former position."""
        self._put_in()


Change: TypeAlias = Valued | Inserted | Removed


def redo(changes: Sequence[Change]) -> None:
    """Repeat changes, in order."""
    for change in changes:
        change.do()


def undo(changes: Sequence[Change]) -> None:
    """Undo changes, in reverse order."""
    for change in reversed(changes):
        change.undo()


def touched(changes: Sequence[Change]) -> list[EObject]:
    """Return the objects affected by changes, each once."""
    return list(dict.fromkeys(element for change in changes for element in change.touched()))


class Changing:
    """Changes a model, and records the changes."""

    def __init__(self, root: pn.Net) -> None:
        self.root = root
        self.changes: list[Change] = []

    def do(self, change: Change) -> None:
        """Make a change."""
        change.do()
        self.changes.append(change)

    def assign(self, element: EObject, name: str, value: Any) -> None:
        """Set an attribute, if its value differs."""
        before = getattr(element, name)
        if value != before or type(value) is not type(before):
            self.do(Valued(element, name, before, value))

    def relink(self, element: EObject, feature: Any, target: EObject | None) -> None:
        """Set a single-valued reference, or remove its target."""
        before = getattr(element, feature.name)
        if before is target:
            return
        opposite = feature.eOpposite
        if opposite is None or not opposite.many:
            self.do(Valued(element, feature.name, before, target))
            return
        if before is not None:
            self.take_out(before, opposite.name, element)
        if target is not None:
            self.do(Inserted(target, opposite.name, len(getattr(target, opposite.name)), element))

    def take_out(self, owner: EObject, name: str, element: EObject) -> None:
        """Remove an object from a list."""
        self.do(Removed(owner, name, getattr(owner, name).index(element), element))

    def detach(self, element: EObject) -> None:
        """Remove an object from its container.

        Raises
        ------
        CommandError
            The object is the model itself.
        """
        owner = element.eContainer()
        if owner is None:
            raise CommandError("the model itself stays where it is")
        feature = element.eContainmentFeature()
        if feature.many:
            self.take_out(owner, feature.name, element)
        else:
            self.do(Valued(owner, feature.name, element, None))

    def take_away(self, outermost: Sequence[EObject]) -> None:
        """Remove objects with their parts from the model, and all references to them."""
        gone = {part for element in outermost for part in subtree(element)}
        for element in subtree(self.root):
            if element in gone:
                self._unlink(element, gone)
            else:
                self._forget(element, gone)
        for element in outermost:
            self.detach(element)

    def _unlink(self, element: EObject, gone: set[EObject]) -> None:
        """Remove a deleted object from the lists of remaining objects."""
        for name, feature in class_of(element).features.items():
            if feature.kind is Kind.REFERENCE and not feature.many:
                opposite, target = features_of(type(element))[name].eOpposite, getattr(element, name)
                if opposite is not None and opposite.many and target is not None and target not in gone:
                    self.take_out(target, opposite.name, element)

    def _forget(self, element: EObject, gone: set[EObject]) -> None:
        """Remove the references of a remaining object to deleted objects."""
        for name, feature in class_of(element).features.items():
            if feature.kind is not Kind.REFERENCE or not element.eIsSet(name):
                continue
            for target in [each for each in values_of(element, feature) if each in gone]:
                if feature.many:
                    self.take_out(element, name, target)
                else:
                    self.relink(element, features_of(type(element))[name], None)
