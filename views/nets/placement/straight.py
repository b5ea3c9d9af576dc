"""Layout without an engine for scripts: sheet by sheet, with straight lines."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from dineros.views.nets.placement.labels import place_labels
from dineros.views.nets.placement.shown import visible
from dineros.views.nets.placement.stored import Block, Item, Point, Sheet, arranged, kept, place

Sized: TypeAlias = tuple[str, float, float]
"""Id, width and height of a shape, its middle in the middle."""
Free: TypeAlias = Callable[[Sequence[Sized], Sequence[tuple[str, str]]], dict[str, Point]]
"""Lays shapes and the lines between them out; returns their centres."""

_APART = 10.0
_SERVICE_POINT = 12.0
_BACKWARDS = ("response", "return")
"""Lines that are laid out against their direction: a response comes back the way the request went."""


def layout_straight(view: dict[str, Any], free: Free) -> dict[str, Any]:
    """Lay a view out; the result is that of `layout_by_elk`."""
    view = visible(view)
    sheets: dict[str | None, Sheet] = {}
    for box in [*reversed([box for box in view["boxes"] if not box.get("collapsed")]), None]:
        sheets[box and box["id"]] = _sheet(view, box, sheets, free)
    corners: dict[str | None, Point] = {None: (0.0, 0.0)}
    boxes, nodes = [], []
    for box in view["boxes"]:
        parent = box.get("parent")
        (x, y), (left, top) = sheets[parent].at[box["id"]], corners[parent]
        width, height = sheets[box["id"]].size if box["id"] in sheets else (box["width"], box["height"])
        corners[box["id"]] = left + x - width / 2, top + y - height / 2
        at = dict(zip("xy", map(_rounded, corners[box["id"]]), strict=True))
        boxes.append({**box, **at, "width": _rounded(width), "height": _rounded(height)})
    for node in view["nodes"]:
        (x, y), (left, top) = sheets[node.get("box")].at[node["id"]], corners[node.get("box")]
        nodes.append({**node, "x": _rounded(left + x), "y": _rounded(top + y)})
    width, height = map(_rounded, sheets[None].size)
    edges = _lines(view, boxes, nodes, sheets, corners)
    picture = {**view, "width": width, "height": height, "boxes": boxes, "nodes": nodes, "edges": edges}
    place_labels(picture)
    return picture


def _rounded(value: float) -> float:
    return round(value, 1)


def _sheet(
    view: dict[str, Any], box: dict[str, Any] | None, sheets: dict[str | None, Sheet], free: Free
) -> Sheet:
    id = box and box["id"]
    elements = [inner for inner in view["boxes"] if inner.get("parent") == id]
    elements += [node for node in view["nodes"] if node.get("box") == id]
    if not elements:
        header = box["header"] if box is not None else (0.0, 0.0)
        return Sheet({}, (header[0] + 8, header[1] + 20))
    items = [Item.of(one, sheets[one["id"]].size if one["id"] in sheets else None) for one in elements]
    is_arranged = arranged(items, box)
    fixed = {item.id for item in kept(items)} if is_arranged else set()
    links = _links(view, {item.id for item in items})
    blocks = _blocks([item for item in items if item.id not in fixed], links, free, is_arranged)
    if not is_arranged:
        items = []
    bends = [
        bend
        for edge in view["edges"]
        if {edge["source"], edge["target"]} <= fixed
        for bend in edge.get("bends", ())
    ]
    return place(items, box, blocks, bends)


def _links(view: dict[str, Any], ids: set[str]) -> list[tuple[str, str]]:
    """Return what lines join on a sheet: the items themselves, or what the lines come from inside of them."""
    parents = {box["id"]: box.get("parent") for box in view["boxes"]}
    parents |= {node["id"]: node.get("box") for node in view["nodes"]}

    def on_sheet(id: str | None) -> str | None:
        while id is not None and id not in ids:
            id = parents[id]
        return id

    found = []
    for edge in view["edges"]:
        one, other = on_sheet(edge["source"]), on_sheet(edge["target"])
        if one is not None and other is not None and one != other:
            found.append((other, one) if edge["kind"] in _BACKWARDS else (one, other))
    return found


def _blocks(items: Sequence[Item], links: Sequence[tuple[str, str]], free: Free, apart: bool) -> list[Block]:
    """Lay items out that have no position; return them as groups that hang together, or as one."""
    if not items:
        return []
    ids = {item.id: item for item in items}
    inside = [(one, other) for one, other in links if one in ids and other in ids]
    # As much room above as the captions need below keeps the shapes in the middle.
    at = free([(item.id, 2 * item.reach[0], 2 * item.reach[2]) for item in items], inside)
    group = {id: id if apart else items[0].id for id in ids}
    for one, other in inside:
        old, new = group[one], group[other]
        group = {id: new if of == old else of for id, of in group.items()}
    return [
        _block([ids[id] for id in ids if group[id] == name], at, links)
        for name in dict.fromkeys(group.values())
    ]


def _block(items: Sequence[Item], at: dict[str, Point], links: Sequence[tuple[str, str]]) -> Block:
    left = min(at[item.id][0] - item.reach[0] for item in items)
    right = max(at[item.id][0] + item.reach[0] for item in items)
    top = min(at[item.id][1] - item.reach[1] for item in items)
    bottom = max(at[item.id][1] + item.reach[2] for item in items)
    x, y = (left + right) / 2, (top + bottom) / 2
    within = {item.id: (at[item.id][0] - x, at[item.id][1] - y) for item in items}
    near = {end for link in links if len(within.keys() & set(link)) == 1 for end in link} - within.keys()
    half = (bottom - top) / 2
    return Block(
        within, ((right - left) / 2, half, half), near, items[0].position if len(items) == 1 else None
    )


def _lines(
    view: dict[str, Any],
    boxes: Sequence[dict[str, Any]],
    nodes: Sequence[dict[str, Any]],
    sheets: dict[str | None, Sheet],
    corners: dict[str | None, Point],
) -> list[dict[str, Any]]:
    shapes = {node["id"]: node for node in nodes}
    shapes |= {
        box["id"]: {**box, "x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2}
        for box in boxes
    }
    between: dict[frozenset[str], list[str]] = {}
    for edge in view["edges"]:
        between.setdefault(frozenset((edge["source"], edge["target"])), []).append(edge["id"])
    made = []
    for edge in view["edges"]:
        source, target = shapes[edge["source"]], shapes[edge["target"]]
        peers = between[frozenset((edge["source"], edge["target"]))]
        aside = (peers.index(edge["id"]) - (len(peers) - 1) / 2) * _APART
        aside *= 1 if edge["source"] < edge["target"] else -1
        dx, dy = target["x"] - source["x"], target["y"] - source["y"]
        far = math.hypot(dx, dy) or 1
        shift = (-dy / far * aside, dx / far * aside)
        sheet = sheets.get(source.get("box"))
        bends: list[Point] = []
        if edge.get("bends") and source.get("box") == target.get("box") and sheet is not None:
            left, top = corners[source.get("box")]
            bends = [(left + x, top + y) for x, y in sheet.bent(edge["bends"])]
            shift = (0.0, 0.0)
        start, end = ((one["x"] + shift[0], one["y"] + shift[1]) for one in (source, target))
        points = [start, *bends, end]
        points[0], points[-1] = _border(source, start, points[1]), _border(target, end, points[-2])
        made.append({**edge, "points": [[_rounded(x), _rounded(y)] for x, y in points]})
    return made


def _border(item: dict[str, Any], start: Point, to: Point) -> Point:
    """Return where a line from inside of a shape leaves it."""
    low, high = 0.0, 1.0
    for _ in range(24):
        part = (low + high) / 2
        x, y = start[0] + (to[0] - start[0]) * part, start[1] + (to[1] - start[1]) * part
        if _holds(item, x - item["x"], y - item["y"]):
            low = part
        else:
            high = part
    return start[0] + (to[0] - start[0]) * low, start[1] + (to[1] - start[1]) * low


def _holds(item: dict[str, Any], dx: float, dy: float) -> bool:
    wide, high = item["width"] / 2, item["height"] / 2
    if item["kind"].startswith("place"):
        return bool(dx * dx + dy * dy <= wide * wide)
    if abs(dx) > wide or abs(dy) > high:
        return False
    if item["kind"] == "topic":
        beyond = abs(dx) - (wide - high)
        return bool(beyond <= 0 or beyond * beyond + dy * dy <= high * high)
    return bool(item["kind"] != "service" or wide - abs(dx) >= _SERVICE_POINT * abs(dy) / high)
