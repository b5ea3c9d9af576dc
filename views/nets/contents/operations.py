"""Operations on views: collapsing pages, neighbourhoods of elements, badges; each returns a new view."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Iterable, Mapping

from dineros.metamodel.errors import DinerosError, UnknownElementError, near_matches
from dineros.views.nets.contents.model import Box, Edge, Node, ViewModel

MANY = 150
"""A picture with more places and transitions starts with its pages collapsed."""


def collapse(view: ViewModel, ids: Iterable[str] | None = None) -> ViewModel:
    """Return the view with boxes collapsed.

    Parameters
    ----------
    view : ViewModel
        The view; it is not changed.
    ids : iterable of str, optional
        The boxes; all of them by default.

    Raises
    ------
    UnknownElementError
        A box does not exist.
    """
    return _with_boxes(view, _boxes(view, ids), True)


def expand(view: ViewModel, ids: Iterable[str] | None = None) -> ViewModel:
    """Return the view with boxes expanded, including the boxes that contain them.

    Parameters
    ----------
    view : ViewModel
        The view; it is not changed.
    ids : iterable of str, optional
        The boxes; all of them by default.

    Raises
    ------
    UnknownElementError
        A box does not exist.
    """
    wanted = _boxes(view, ids)
    for box in reversed(view.boxes):  # boxes stand after those they are in
        if box.id in wanted and box.parent is not None:
            wanted.add(box.parent)
    return _with_boxes(view, wanted, False)


def collapse_if_large(view: ViewModel, many: int = MANY) -> ViewModel:
    """Return the view with all boxes collapsed if it has too many nodes to be readable."""
    if len(view.nodes) <= many:
        return view
    return collapse(view)


def around(view: ViewModel, ids: Collection[str], steps: int) -> ViewModel:
    """Return the part of a view within some steps of some elements, in any direction.

    Parameters
    ----------
    view : ViewModel
        The view; it is not changed.
    ids : collection of str
        Nodes, boxes (for their content) or edges (for their ends).
    steps : int
        Number of lines to follow, 0 or more.

    Raises
    ------
    UnknownElementError
        There is no such element.
    """
    if steps < 0:
        raise DinerosError(f"the distance {steps} is negative", hint="give 0 or more")
    kept = {node for id in ids for node in _nodes_of(view, id)}
    neighbours: dict[str, set[str]] = {node.id: set() for node in view.nodes}
    for edge in view.edges:
        if edge.source in neighbours and edge.target in neighbours:
            neighbours[edge.source].add(edge.target)
            neighbours[edge.target].add(edge.source)
    border = kept
    for _ in range(steps):
        border = {other for node in border for other in neighbours[node]} - kept
        kept = kept | border
    return restricted(view, kept)


def restricted(view: ViewModel, kept: Collection[str]) -> ViewModel:
    """Return a view of some nodes: the lines between them and the boxes around them, all expanded."""
    nodes = [node for node in view.nodes if node.id in kept]
    parents = {box.id: box.parent for box in view.boxes}
    needed: set[str] = set()
    for node in nodes:
        outer = node.box
        while outer is not None and outer not in needed:
            needed.add(outer)
            outer = parents[outer]
    boxes = [dataclasses.replace(box, collapsed=False) for box in view.boxes if box.id in needed]
    edges = [edge for edge in view.edges if edge.source in kept and edge.target in kept]
    return dataclasses.replace(view, boxes=boxes, nodes=nodes, edges=edges)


def with_badges(view: ViewModel, badges: Mapping[str, str]) -> ViewModel:
    """Return the view with short texts next to some nodes and boxes, to which a text can refer.

    Parameters
    ----------
    view : ViewModel
        The view; it is not changed.
    badges : mapping of str to str
        Text by id of node or box.

    Raises
    ------
    UnknownElementError
        There is no such node or box.
    """
    known = {item.id for item in view.shapes()}
    for id in badges:
        if id not in known:
            raise UnknownElementError(f"the picture shows no {id!r}", hint=near_matches(id, known))
    nodes: list[Node] = [
        dataclasses.replace(node, badge=badges[node.id]) if node.id in badges else node for node in view.nodes
    ]
    boxes: list[Box] = [
        dataclasses.replace(box, badge=badges[box.id]) if box.id in badges else box for box in view.boxes
    ]
    return dataclasses.replace(view, nodes=nodes, boxes=boxes)


def _with_boxes(view: ViewModel, ids: Collection[str], collapsed: bool) -> ViewModel:
    boxes = [
        dataclasses.replace(box, collapsed=collapsed if box.id in ids else box.collapsed)
        for box in view.boxes
    ]
    return dataclasses.replace(view, boxes=boxes)


def _boxes(view: ViewModel, ids: Iterable[str] | None) -> set[str]:
    """Return the ids of the wanted boxes: all of them if none are given."""
    known = {box.id: box for box in view.boxes}
    wanted = list(known if ids is None else ids)
    for id in wanted:
        if id not in known:
            raise UnknownElementError(f"the picture has no page {id!r}", hint=near_matches(id, known))
    return set(wanted)


def _nodes_of(view: ViewModel, id: str) -> set[str]:
    """Return a node itself, the nodes of a box, or the ends of an edge."""
    if any(node.id == id for node in view.nodes):
        return {id}
    if any(box.id == id for box in view.boxes):
        inside = {id}
        for box in view.boxes:  # boxes stand after those they are in
            if box.parent in inside:
                inside.add(box.id)
        return {node.id for node in view.nodes if node.box in inside}
    edges: list[Edge] = [edge for edge in view.edges if id in (edge.id, edge.also)]
    if edges:
        return {edges[0].source, edges[0].target}
    known = [item.id for item in view.shapes()]
    raise UnknownElementError(f"the picture shows no {id!r}", hint=near_matches(id, known))
