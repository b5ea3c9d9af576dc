"""The three ways in which a model changes, each with its exact inverse, the order of all lists included.

References with a many-valued opposite, such as the source of an arc, are changed at that opposite: only there
the order is known that the inverse must bring back.
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
class _InList:
    """What happens to an object at a position in a list."""

    element: EObject
    feature: str
    index: int
    value: EObject

    def _put_in(self) -> None:
        getattr(self.element, self.feature).insert(self.index, self.value)

    def _take_out(self) -> None:
        getattr(self.element, self.feature).remove(self.value)

    def touched(self) -> list[EObject]:
        """Return the objects that look different afterwards."""
        return [self.element, self.value]


class Inserted(_InList):
    """A list gets an object at a position."""

    def do(self) -> None:
        """Put it in."""
        self._put_in()

    def undo(self) -> None:
        """Take it out."""
        self._take_out()


class Removed(_InList):
    """A list loses the object at a position."""

    def do(self) -> None:
        """Take it out."""
        self._take_out()

    def undo(self) -> None:
        """Put it in where it was."""
        self._put_in()


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


class Changing:
    """Changes a model, and remembers how.

    Parameters
    ----------
    root : pn.Net
        The model.

    Attributes
    ----------
    changes : list of Change
        What was done.
    """

    def __init__(self, root: pn.Net) -> None:
        self.root = root
        self.changes: list[Change] = []

    def do(self, change: Change) -> None:
        """Do a change."""
        change.do()
        self.changes.append(change)

    def assign(self, element: EObject, name: str, value: Any) -> None:
        """Give an attribute a value, if it has another one."""
        before = getattr(element, name)
        if value != before or type(value) is not type(before):
            self.do(Valued(element, name, before, value))

    def relink(self, element: EObject, feature: Any, target: EObject | None) -> None:
        """Let a single-valued reference lead elsewhere, or nowhere."""
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
        """Take an object out of a list."""
        self.do(Removed(owner, name, getattr(owner, name).index(element), element))

    def detach(self, element: EObject) -> None:
        """Take an object out of its container.

        Raises
        ------
        CommandError
            It is the model itself.
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
        """Take objects and their parts out of the model; nothing that stays leads to them."""
        gone = {part for element in outermost for part in subtree(element)}
        for element in subtree(self.root):
            if element in gone:
                self._unlink(element, gone)
            else:
                self._forget(element, gone)
        for element in outermost:
            self.detach(element)

    def _unlink(self, element: EObject, gone: set[EObject]) -> None:
        """Take an object that goes out of the lists, by which objects that stay know it."""
        for name, feature in class_of(element).features.items():
            if feature.kind is Kind.REFERENCE and not feature.many:
                opposite, target = features_of(type(element))[name].eOpposite, getattr(element, name)
                if opposite is not None and opposite.many and target is not None and target not in gone:
                    self.take_out(target, opposite.name, element)

    def _forget(self, element: EObject, gone: set[EObject]) -> None:
        """Let the references of an object that stays lead no more to what goes."""
        for name, feature in class_of(element).features.items():
            if feature.kind is not Kind.REFERENCE or not element.eIsSet(name):
                continue
            for target in [each for each in values_of(element, feature) if each in gone]:
                if feature.many:
                    self.take_out(element, name, target)
                else:
                    self.relink(element, features_of(type(element))[name], None)
