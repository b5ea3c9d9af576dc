"""Where the elements of a comparison stand: as in the later model, or else as in the earlier one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from statistics import median

from dineros.views.nets.contents.model import Box, Edge, Node, ViewModel
from dineros.views.nets.placement.stored import Item, Point, needed_scale, scale_of

MOST_SCALE = 1.5
"""A picture does not grow by more for what only the earlier model has; that is laid out anew instead."""


def align(before: ViewModel, view: ViewModel) -> ViewModel:
    """Return a comparison with the positions of both models, sheet by sheet.

    An editor may have moved everything on a page: elements of the earlier model move as most of those did
    that both models have. Where something else stands now, they lose their position.

    Parameters
    ----------
    before : ViewModel
        The earlier model.
    view : ViewModel
        The comparison; removed elements have the positions they had.
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


def _aligned(items: Sequence[Box | Node], old: dict[str, Box | Node], shift: Point) -> Iterable[Box | Node]:
    """Yield the items of a sheet with their positions."""
    placed = [_item(item) for item in items if item.change != "removed" and item.position]
    most = max(scale_of(placed), MOST_SCALE)
    for item in items:
        was = old.get(item.id)
        stands = item.change != "removed" and item.position
        if stands or was is None or was.position is None or _sheet(was) != _sheet(item):
            yield item
        else:
            there = was.position[0] + shift[0], was.position[1] + shift[1]
            moved: Box | Node = replace(item, position=there)
            if isinstance(moved, Box) and isinstance(was, Box):
                moved.frame = was.frame if shift == (0.0, 0.0) else None
            own = _item(moved)
            if any(needed_scale(own, other, 0) > most for other in placed):
                moved = replace(moved, position=None)
                if isinstance(moved, Box):
                    moved.frame = None
            else:
                placed.append(own)
            yield moved


def _item(item: Box | Node) -> Item:
    return Item.of({**vars(item), "frame": None}, None)


def _bent(view: ViewModel, before: ViewModel, shifts: dict[str | None, Point]) -> list[Edge]:
    """Return the lines; bend points of the earlier model move with what stands around them."""
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
