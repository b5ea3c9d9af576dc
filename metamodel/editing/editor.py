"""Executes commands: each group completely or not at all, with a record of each change and its inverse."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject, features_of
from dineros.metamodel.clauses import signals_of_clause
from dineros.metamodel.constraints.wording import describe
from dineros.metamodel.editing import commands as c
from dineros.metamodel.editing.changes import Change, Changing, Inserted, Valued, touched, undo
from dineros.metamodel.editing.handles import Handles, subtree
from dineros.metamodel.editing.naming import default_id, used_ids
from dineros.metamodel.editing.offered import class_to_make, follows_from_text, name_of
from dineros.metamodel.editing.removing import check_clauses, closure
from dineros.metamodel.editing.renaming import rewritings
from dineros.metamodel.editing.values import checked
from dineros.metamodel.elements import is_within
from dineros.metamodel.errors import near_matches
from dineros.metamodel.files.schema import Kind, class_of

DEEPEST = 100
"""Maximum depth of containment; files may exceed it."""

MOST_OBJECTS = 400_000
"""Maximum number of objects of a model, including deleted ones."""


@dataclass(frozen=True)
class Performed:
    """The result of a group of commands.

    Attributes
    ----------
    changes : list of Change
        The changes of the model.
    made : dict of str
        Handles of the objects made, by their names in the commands.
    """

    changes: list[Change]
    made: dict[str, str]


class Editor(Changing):
    """Changes one model.

    Parameters
    ----------
    root : pn.Net
        The model; no other code may change it meanwhile.
    """

    def __init__(self, root: pn.Net) -> None:
        super().__init__(root)
        self.handles = Handles(root)
        self._made: dict[str, str] = {}
        self._used: set[str] | None = None  # all ids, as long as objects are only made

    def perform(self, group: Sequence[c.Command]) -> Performed:
        """Execute commands in order.

        Raises
        ------
        CommandError, ClauseError
            One of them cannot be executed, or the result would lack a required object; the model is
            unchanged.
        """
        count = len(self.handles)
        self.changes, self._made, self._used = [], {}, None
        try:
            for command in group:
                if not isinstance(command, c.Create):
                    self._used = None
                self._DO[type(command)](self, command)
            self._check(group)
        except BaseException:
            undo(self.changes)
            self.handles.forget_from(count)
            raise
        return Performed(self.changes, self._made)

    # ------------------------------------------------------------------------------------ finding, checking

    def find(self, name: str) -> EObject:
        """Return the object with a handle, or with a name of this group.

        Raises
        ------
        CommandError
            There is none, or it was deleted.
        """
        handle = name
        if name.startswith("$"):
            if name not in self._made:
                raise c.CommandError(f"nothing in this group is called {name[:40]!r}")
            handle = self._made[name]
        element = self.handles.find(handle)
        if not is_within(element, self.root):
            raise c.CommandError(f"{describe(element)} was deleted")
        return element

    def _feature(self, element: EObject, name: str, *kinds: Kind) -> Any:
        feature = features_of(type(element)).get(name)
        if feature is None:
            hint = near_matches(name[:100], features_of(type(element)))
            raise c.CommandError(f"{name_of(type(element))} has no feature {name[:100]!r}", hint=hint)
        if class_of(element).features[name].kind not in kinds:
            raise c.CommandError(f"{name} of {describe(element)} cannot be changed by this command")
        if follows_from_text(element):
            raise c.CommandError(f"{describe(element)} follows from a text", hint="use the command clause")
        return feature

    def _check(self, group: Sequence[c.Command]) -> None:
        for element in touched(self.changes):
            if not is_within(element, self.root):
                continue
            for feature in class_of(element).required:
                value = getattr(element, feature.name)
                if value is None or (feature.many and not len(value)):
                    raise c.CommandError(f"{describe(element)} needs {feature.name}")
        if any(isinstance(each, c.Place | c.Delete) for each in group):
            check_clauses(self.changes, self.root)
        if any(
            isinstance(each, c.Create) or (isinstance(each, c.Set) and each.feature == "id") for each in group
        ):
            self._check_ids()

    def _check_ids(self) -> None:
        known: dict[str, EObject] = {}
        changed = set(touched(self.changes))
        for element in subtree(self.root):
            identifier = getattr(element, "id", None) if isinstance(element, pn.Element) else None
            other = known.setdefault(identifier, element) if identifier else element
            if other is not element and (other in changed or element in changed):
                raise c.CommandError(f"the id {identifier!r} is that of {describe(other)} already")

    # ---------------------------------------------------------------------------------- making and deleting

    def _create(self, command: c.Create) -> None:
        owner = self.find(command.owner)
        feature = self._feature(owner, command.feature, Kind.CONTAINMENT)
        cls = class_to_make(self.root, command.type)
        if command.called is not None and (command.called[:1] != "$" or command.called in self._made):
            raise c.CommandError(f"{command.called[:40]!r} is not a new name that begins with '$'")
        if len(self.handles) >= MOST_OBJECTS:
            raise c.CommandError("the model is too large", hint="save it and open it again")
        element = cls()
        identifier = class_of(element).identifier
        if identifier and command.values.get(identifier) is None:
            if self._used is None:
                self._used = used_ids(self.root)
            element.id = default_id(self._used, cls, owner, command.values, self.find)  # type: ignore[attr-defined]
        references = self._attributes(element, command.values)
        if self._used is not None and isinstance(element, pn.Element) and element.id:
            self._used.add(element.id)
        self._attach(element, owner, feature, command.index)
        if command.called is not None:
            self._made[command.called] = cast(str, self.handles.of(element))
        for name, value in references.items():
            self._refer(element, features_of(cls)[name], value)

    def _attributes(self, element: EObject, values: Mapping[str, c.Value]) -> dict[str, c.Value]:
        """Set the attributes of a new object; return the references."""
        references: dict[str, c.Value] = {}
        for name, value in values.items():
            feature = self._feature(element, name, Kind.ATTRIBUTE, Kind.REFERENCE)
            if feature.many:
                raise c.CommandError(f"{name} leads to several elements", hint="use the command add")
            if feature.is_reference:
                references[name] = value
            elif value is not None:
                setattr(element, name, checked(feature, value))
        return references

    def _attach(self, element: EObject, owner: EObject, feature: Any, index: int | None) -> None:
        """Put an object without a container into a container."""
        if not isinstance(element, class_of(owner).features[feature.name].type):
            raise c.CommandError(
                f"{feature.name} of {describe(owner)} cannot hold a {name_of(type(element))}"
            )
        depth = 0
        above: EObject | None = owner
        outer: sym.NodeNet | None = None
        while above is not None:
            outer = above if isinstance(above, sym.NodeNet) else outer
            depth, above = depth + 1, above.eContainer()
        if outer is not None and any(isinstance(each, sym.NodeNet) for each in subtree(element)):
            raise c.CommandError(
                f"{describe(outer)} cannot hold a node net",
                hint="put it next to the other node net; node nets do not nest",
            )
        if depth + _height(element) > DEEPEST:
            raise c.CommandError(f"more than {DEEPEST} elements inside each other")
        if feature.many:
            count = len(getattr(owner, feature.name))
            at = count if index is None else index
            if at > count:
                raise c.CommandError(
                    f"{feature.name} of {describe(owner)} has {count} elements, no place {at}"
                )
            self.do(Inserted(owner, feature.name, at, element))
        else:
            if getattr(owner, feature.name) is not None:
                raise c.CommandError(f"{describe(owner)} has its {feature.name} already")
            self.do(Valued(owner, feature.name, None, element))
        for part in subtree(element):
            if self.handles.of(part) is None:
                self.handles.number(part)

    def _delete(self, command: c.Delete) -> None:
        chosen = [self.find(name) for name in command.elements]
        if any(follows_from_text(element) for element in chosen):
            raise c.CommandError(
                "an element that follows from a text cannot be deleted", hint="use the command clause"
            )
        self.take_away(closure(self.root, chosen))

    def _place(self, command: c.Place) -> None:
        element, owner = self.find(command.element), self.find(command.owner)
        feature = self._feature(owner, command.feature, Kind.CONTAINMENT)
        if follows_from_text(element) or isinstance(element, sym.InputClause):
            raise c.CommandError(
                f"{describe(element)} belongs to its transition", hint="use the command clause"
            )
        if is_within(owner, element):
            raise c.CommandError(f"{describe(element)} cannot be put into itself")
        self.detach(element)
        self._attach(element, owner, feature, command.index)

    # -------------------------------------------------------------------------------- features

    def _set(self, command: c.Set) -> None:
        element = self.find(command.element)
        feature = self._feature(element, command.feature, Kind.ATTRIBUTE, Kind.REFERENCE)
        if feature.is_reference:
            if feature.many:
                raise c.CommandError(f"{feature.name} leads to several elements", hint="use add and remove")
            self._refer(element, feature, command.value)
            return
        value = checked(feature, command.value)
        if isinstance(element, sym.InputClause) and feature.name == "text":
            assert element.transition is not None
            self._set_clause(element.transition, value)
            return
        others = rewritings(self.root, element, feature.name, value)
        self.assign(element, feature.name, value)
        for each in others:
            self.assign(each.element, each.feature, each.text)

    def _refer(self, element: EObject, feature: Any, value: c.Value) -> None:
        if value is None:
            if class_of(element).features[feature.name].required:
                raise c.CommandError(f"{feature.name} of {describe(element)} must have a target")
            self.relink(element, feature, None)
            return
        if not isinstance(value, str):
            raise c.CommandError(f"{feature.name} is the handle of an element")
        self.relink(element, feature, self._target(element, feature, value))

    def _target(self, element: EObject, feature: Any, name: str) -> EObject:
        target = self.find(name)
        expected: type[EObject] = class_of(element).features[feature.name].type
        if not isinstance(target, expected):
            wanted = expected.eClass.name
            raise c.CommandError(f"{feature.name} leads to a {wanted}, not to {describe(target)}")
        return target

    def _add(self, command: c.Add) -> None:
        element = self.find(command.element)
        feature = self._feature(element, command.feature, Kind.REFERENCE)
        if not feature.many:
            raise c.CommandError(f"{feature.name} leads to one element", hint="use set")
        target, values = self._target(element, feature, command.target), getattr(element, feature.name)
        if target in values:
            raise c.CommandError(f"{feature.name} of {describe(element)} leads to {describe(target)} already")
        index = len(values) if command.index is None else command.index
        if index > len(values):
            raise c.CommandError(f"{feature.name} of {describe(element)} has {len(values)} elements only")
        self.do(Inserted(element, feature.name, index, target))

    def _remove(self, command: c.Remove) -> None:
        element, target = self.find(command.element), self.find(command.target)
        feature = self._feature(element, command.feature, Kind.REFERENCE)
        values = getattr(element, feature.name) if feature.many else ()
        if target not in values:
            raise c.CommandError(
                f"{command.feature} of {describe(element)} has no {describe(target)} in a list"
            )
        self.take_out(element, feature.name, target)

    # -------------------------------------------------------------------------------- positions

    def _graphics(self, element: EObject) -> pn.Graphics:
        assert isinstance(element, pn.Element)
        if element.graphics is None:
            self._attach(pn.Graphics(), element, features_of(type(element))["graphics"], None)
        return cast(pn.Graphics, element.graphics)

    def _move(self, command: c.Move) -> None:
        element = self.find(command.element)
        if not isinstance(element, (pn.PageObject, sym.Channel)):
            raise c.CommandError(f"{describe(element)} has no position", hint="arcs have bend points")
        graphics = self._graphics(element)
        if len(graphics.positions):
            self.assign(graphics.positions[0], "x", command.x)
            self.assign(graphics.positions[0], "y", command.y)
        else:
            self._attach_point(graphics, command.x, command.y)

    def _attach_point(self, graphics: pn.Graphics, x: float, y: float) -> None:
        self._attach(pn.Point(x=x, y=y), graphics, features_of(pn.Graphics)["positions"], None)

    def _bend(self, command: c.Bend) -> None:
        element = self.find(command.element)
        if not isinstance(element, pn.Arc):
            raise c.CommandError(f"{describe(element)} has no bend points")
        if element.graphics is None and not command.points:
            return
        graphics = self._graphics(element)
        for point in list(graphics.positions)[::-1]:
            self.detach(point)
        for x, y in command.points:
            self._attach_point(graphics, x, y)
        if not command.points and all(
            getattr(graphics, name) is None for name in ("offset", "dimension", "style")
        ):
            self.detach(graphics)

    # -------------------------------------------------------------------------------- clauses

    def _clause(self, command: c.Clause) -> None:
        element = self.find(command.element)
        if not isinstance(element, sym.Transition):
            raise c.CommandError(f"{describe(element)} has no clause")
        if command.text is None:
            if element.clause is not None:
                self.take_away([element.clause])
            return
        text = checked(features_of(sym.InputClause)["text"], command.text)
        if element.clause is None or element.clause.text != text:
            self._set_clause(element, text)

    def _set_clause(self, transition: sym.Transition, text: str) -> None:
        form = signals_of_clause(transition, text)
        former = transition.clause
        clause = sym.InputClause(text=text, name=former.name if former is not None else None)
        clause.disjunctions.extend(
            sym.Disjunction(literals=[sym.Literal(negated=one.negated, value=one.value) for one in each])
            for each in form
        )
        if former is not None:
            self.take_away([former])
        self._attach(clause, transition, features_of(sym.Transition)["clause"], None)
        for disjunction, each in zip(clause.disjunctions, form, strict=True):
            for literal, one in zip(disjunction.literals, each, strict=True):
                self.do(Inserted(one.signal, "literals", len(one.signal.literals), literal))

    _DO: Mapping[type[c.Command], Any] = {
        c.Create: _create,
        c.Delete: _delete,
        c.Set: _set,
        c.Add: _add,
        c.Remove: _remove,
        c.Place: _place,
        c.Move: _move,
        c.Bend: _bend,
        c.Clause: _clause,
    }


def _height(element: EObject) -> int:
    """Return the depth of containment inside an object."""
    level, height = [element], 0
    while level:
        height += 1
        level = [part for each in level for part in each.eContents]
    return height
