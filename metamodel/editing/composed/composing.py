"""Translates an editing operation to commands."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.constraints.wording import describe
from dineros.metamodel.editing import commands as c
from dineros.metamodel.editing.composed import operations as o
from dineros.metamodel.editing.composed.copying import Copier
from dineros.metamodel.editing.composed.filling import filled
from dineros.metamodel.editing.composed.regrouping import grouped, joined, moved, split
from dineros.metamodel.editing.composed.templates import TEMPLATES
from dineros.metamodel.editing.handles import Handles
from dineros.metamodel.elements import is_within
from dineros.metamodel.errors import near_matches


def compose(root: pn.Net, handles: Handles, operation: o.Operation) -> list[c.Command]:
    """Return the commands of an operation, for the current state of the model.

    Raises
    ------
    CommandError
        It cannot be done.
    """
    found = _COMPOSED[type(operation)](_Model(root, handles), operation)
    if len(found) > c.MOST_COMMANDS:
        raise c.CommandError(f"that takes more than {c.MOST_COMMANDS} commands at once")
    return found


class _Model:
    def __init__(self, root: pn.Net, handles: Handles) -> None:
        self.root, self.handles = root, handles

    def find(self, handle: str) -> EObject:
        element = self.handles.find(handle)
        if not is_within(element, self.root):
            raise c.CommandError(f"{describe(element)} was deleted")
        return element


def _copy(model: _Model, wanted: o.Copy) -> list[c.Command]:
    elements = [model.handles.find(each) for each in wanted.elements]
    if model.root in elements:
        raise c.CommandError("the model itself cannot be copied")
    copier = Copier(model.root, model.handles, model.find(wanted.owner), (wanted.dx, wanted.dy))
    return copier.copied(elements)


def _into(model: _Model, wanted: o.Into) -> list[c.Command]:
    page = model.find(wanted.page)
    if not isinstance(page, pn.Page):
        raise c.CommandError(f"{describe(page)} is not a page")
    return moved(model.root, model.handles, [model.find(each) for each in wanted.elements], page)


def _group(model: _Model, wanted: o.Group) -> list[c.Command]:
    elements = [model.find(each) for each in wanted.elements]
    return grouped(model.root, model.handles, elements, wanted.type)


def _split(model: _Model, wanted: o.Split) -> list[c.Command]:
    return split(model.root, model.handles, model.find(wanted.page))


def _join(model: _Model, wanted: o.Join) -> list[c.Command]:
    ends = model.find(wanted.source), model.find(wanted.target)
    return joined(model.handles, ends, (wanted.x, wanted.y))


def _fill(model: _Model, wanted: o.Fill) -> list[c.Command]:
    return filled(model.root, model.find(wanted.token), wanted.token, wanted.field, wanted.text)


def _insert(model: _Model, wanted: o.Insert) -> list[c.Command]:
    make = TEMPLATES.get(wanted.template)
    if make is None:
        hint = near_matches(wanted.template[:100], TEMPLATES) or f"templates: {', '.join(TEMPLATES)}"
        raise c.CommandError(f"there is no template {wanted.template[:100]!r}", hint=hint)
    if not isinstance(model.root, sym.SystemModel):
        raise c.CommandError("templates are parts of system models")
    template = make()
    elements: list[EObject] = [*template.pages, *template.channels]
    points = [
        each.graphics.positions[0] for each in elements if isinstance(each, pn.Element) and each.graphics
    ]
    shift = (wanted.x - min(each.x for each in points), wanted.y - min(each.y for each in points))
    return Copier(model.root, model.handles, model.root, shift).copied(elements)


_COMPOSED: Mapping[type[o.Operation], Callable[[_Model, Any], list[c.Command]]] = {
    o.Copy: _copy,
    o.Into: _into,
    o.Group: _group,
    o.Split: _split,
    o.Join: _join,
    o.Fill: _fill,
    o.Insert: _insert,
}
