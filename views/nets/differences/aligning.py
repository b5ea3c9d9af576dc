"""Positions of the elements of a comparison: those of the later model, otherwise of the earlier one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from statistics import median
from typing import Any, TypeAlias

from dineros.views.javascript.client import evaluate
from dineros.views.nets.contents.model import Box, Edge, Node, ViewModel
from dineros.views.nets.placement.placing import SCRIPTS

Point: TypeAlias = tuple[float, float]

MOST_SCALE = 1.5
"""Limit of the growth of a picture by elements of the earlier model; beyond it, they are laid out again."""


def align(before: ViewModel, view: ViewModel) -> ViewModel:
    """Return a comparison with the positions of both models, sheet by sheet.

    An editor may have moved everything on a page: elements of the earlier model move like most of the common
    elements. If their place is now occupied, they lose their position.

    Parameters
    ----------
    before : ViewModel
        The earlier model.
    view : ViewModel
        The comparison; removed elements have the positions they had.

    Raises
    ------
    DinerosError
        V8 cannot compute which shapes would overlap.
    """
    old: dict[str, Box | Node] = {item.id: item for item in before.shapes()}
    by_sheet: dict[str | None, list[Box | Node]] = {}
    for item in view.shapes():
        by_sheet.setdefault(_sheet(item), []).append(item)
    found: dict[str, Box | Node] = {}
    shifts: dict[str | None, Point] = {}
    for sheet, items in by_sheet.items():
        shifts[sheet] = _shift(items, old)
        found |= {item.id: item for item in _aligned(items, old, shifts[sheet])}
    nodes = [item for item in found.values() if isinstance(item, Node)]
    boxes = [item for item in found.values() if isinstance(item, Box)]
    order = {item.id: number for number, item in enumerate(view.elements())}
    return replace(
        view,
        nodes=sorted(nodes, key=lambda node: order[node.id]),
        boxes=sorted(boxes, key=lambda box: order[box.id]),
        edges=_bent(view, before, shifts),
    )


def _sheet(item: Box | Node) -> str | None:
    return item.parent if isinstance(item, Box) else item.box


def _shift(items: Iterable[Box | Node], old: dict[str, Box | Node]) -> Point:
    moves = [
        (item.position[0] - was.position[0], item.position[1] - was.position[1])
        for item in items
        if item.change != "removed" and item.position and (was := old.get(item.id)) and was.position
    ]
    return (median(x for x, _ in moves), median(y for _, y in moves)) if moves else (0.0, 0.0)


def _aligned(items: Sequence[Box | Node], old: dict[str, Box | Node], shift: Point) -> list[Box | Node]:
    """Return the items of a sheet with their positions."""
    moved = {item.id: there for item in items if (there := _moved(item, old.get(item.id), shift))}
    if moved:
        stand = [_size(item) for item in items if _stands(item)]
        clear = evaluate(SCRIPTS, "standClear", stand, [_size(item) for item in moved.values()], MOST_SCALE)
        for item, is_clear in zip(moved.values(), clear, strict=True):
            if not is_clear:
                item.position = None
                if isinstance(item, Box):
                    item.frame = None
    return [moved.get(item.id, item) for item in items]


def _stands(item: Box | Node) -> bool:
    """Return whether the later model has a position of an item."""
    return item.change != "removed" and item.position is not None


def _moved(item: Box | Node, was: Box | Node | None, shift: Point) -> Box | Node | None:
    """Return an item at its position in the earlier model, moved like its sheet, if it has one."""
    if _stands(item) or was is None or was.position is None or _sheet(was) != _sheet(item):
        return None
    moved = replace(item, position=(was.position[0] + shift[0], was.position[1] + shift[1]))
    if isinstance(moved, Box) and isinstance(was, Box):
        moved.frame = was.frame if shift == (0.0, 0.0) else None
    return moved


def _size(item: Box | Node) -> dict[str, Any]:
    room = item.room if isinstance(item, Node) else (0.0, 0.0)
    return {"position": item.position, "width": item.width, "height": item.height, "room": room}


def _bent(view: ViewModel, before: ViewModel, shifts: dict[str | None, Point]) -> list[Edge]:
    """Return the lines; bend points of the earlier model move with the elements around them."""
    old = {edge.id: edge.bends for edge in before.edges}
    stands = {node.id: node.position for node in view.nodes if node.change != "removed"}
    sheets = {node.id: node.box for node in view.nodes}
    edges = []
    for edge in view.edges:
        kept = edge.bends and edge.change != "removed"
        ends_stand = stands.get(edge.source) and stands.get(edge.target)
        if kept or (ends_stand and edge.change != "removed"):
            edges.append(edge)
            continue
        x, y = shifts.get(sheets.get(edge.source), (0.0, 0.0))
        edges.append(replace(edge, bends=[(bend[0] + x, bend[1] + y) for bend in old.get(edge.id, [])]))
    return edges
