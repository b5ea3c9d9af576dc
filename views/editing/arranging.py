"""Arranges elements without positions: a sheet is laid out like pictures of models."""

from __future__ import annotations

import dataclasses

from dineros.metamodel import pn
from dineros.metamodel.editing import Document
from dineros.metamodel.editing.commands import CommandError
from dineros.metamodel.elements import elements
from dineros.views.nets import ViewModel, collapse, layout, view_of
from dineros.views.nets.placement.picture import PlacedShape


def sheet_view(document: Document, handle: str) -> ViewModel:
    """Return the content of the sheet of a page, or of the model, with the pages on it closed.

    Raises
    ------
    CommandError
        The handle does not belong to a page.
    """
    sheet = document.handles.find(handle)
    if not isinstance(sheet, (pn.Page, pn.Net)):
        raise CommandError("only pages have sheets")
    view = view_of(document.root)
    for item in view.shapes():
        item.position = None  # what is asked is another arrangement
    for edge in view.edges:
        edge.bends = []
    boxes = {box.id: box for box in view.boxes}
    if isinstance(sheet, pn.Net) or sheet.id not in boxes:
        return collapse(view)

    def is_inside(id: str | None) -> bool:
        while id is not None and id != sheet.id:
            id = boxes[id].parent
        return id is not None

    nodes = [
        dataclasses.replace(node, box=None if node.box == sheet.id else node.box)
        for node in view.nodes
        if is_inside(node.box)
    ]
    inner = [
        dataclasses.replace(box, parent=None if box.parent == sheet.id else box.parent)
        for box in view.boxes
        if box.parent is not None and is_inside(box.parent)
    ]
    known = {node.id for node in nodes}
    edges = [edge for edge in view.edges if edge.source in known and edge.target in known]
    return collapse(ViewModel(view.id, view.title, view.kind, inner, nodes, edges))


def positions(document: Document, view: ViewModel) -> dict[str, tuple[float, float]]:
    """Return the centres of the elements on a sheet, by handle.

    Raises
    ------
    DinerosError
        It cannot be laid out.
    """
    placed = layout(view)
    handles = {each.id: document.handles.of(each) for each in elements(document.root)}
    found: dict[str, tuple[float, float]] = {}
    for box in placed["boxes"]:
        found |= _at(handles, box, box["width"] / 2, box["height"] / 2)
    for node in placed["nodes"]:
        found |= _at(handles, node, 0, 0)
    return found


def _at(
    handles: dict[str, str | None], shape: PlacedShape, dx: float, dy: float
) -> dict[str, tuple[float, float]]:
    handle = handles.get(shape["id"])
    return {} if handle is None else {handle: (round(shape["x"] + dx), round(shape["y"] + dy))}
