"""Sheets whose elements an editor arranged keep that arrangement, also with Graphviz.

A sheet is a page, or the whole picture. A test holds this and `static/net/stored.js` to the same rules.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

Point: TypeAlias = tuple[float, float]
Reach: TypeAlias = tuple[float, float, float]
"""How far something reaches from its centre: to the sides, up and down."""

GAP, ROOM, PADDING, MOST_SCALE = 14.0, 32.0, 18.0, 3.0


@dataclass(eq=False)
class Item:
    """A node or a box on a sheet; an open box has the size it is open with."""

    id: str
    position: Point | None
    reach: Reach
    closed: Reach
    frame: Point | None

    @classmethod
    def of(cls, element: dict[str, Any], opened: Point | None) -> Item:
        """Make the item of a node or box of a view."""
        wide, down = element.get("room", (0, 0))
        width, height = element["width"], element["height"]
        closed = (max(width, wide) / 2, height / 2, height / 2 + down)
        reach = closed if opened is None else (opened[0] / 2, opened[1] / 2, opened[1] / 2)
        return cls(element["id"], element.get("position"), reach, closed, element.get("frame"))


@dataclass
class Block:
    """Items without a position, as they stand together, and what they are joined to."""

    at: dict[str, Point]
    reach: Reach
    near: set[str] = field(default_factory=set)
    anchor: Point | None = None


@dataclass
class Sheet:
    """Where the items of a sheet go, its size, and where bend points go."""

    at: dict[str, Point]
    size: Point
    bent: Callable[[Iterable[Point]], list[Point]] = list


def kept(items: Iterable[Item]) -> list[Item]:
    """Return the items that stand where they were stored: of several at one point, the first."""
    found: list[Item] = []
    for item in items:
        at = item.position
        if at is not None and all(math.dist(at, other.position or at) >= 1 for other in found):
            found.append(item)
    return found


def arranged(items: Iterable[Item], box: dict[str, Any] | None) -> bool:
    """Tell whether stored positions say where the items of a sheet go."""
    return len(kept(items)) > (0 if box is not None and box.get("frame") else 1)


def place(
    items: Sequence[Item], box: dict[str, Any] | None, blocks: Sequence[Block], bends: Sequence[Point]
) -> Sheet:
    """Arrange a sheet.

    Parameters
    ----------
    items : sequence of Item
        What is on it.
    box : dict or None
        The box whose sheet it is.
    blocks : sequence of Block
        The items without a position of their own.
    bends : sequence of tuple of float
        Stored bend points.
    """
    fixed = kept(items)
    plane = _plane(fixed)
    at = {item.id: plane(item.position) for item in fixed if item.position is not None}
    areas = [(at[item.id], item.reach) for item in fixed]
    for block in _in_order(blocks, set(at)):
        near = [plane(block.anchor)] if block.anchor else [at[id] for id in sorted(block.near & set(at))]
        x, y = _free_place(block.reach, areas, near or list(at.values()))
        areas.append(((x, y), block.reach))
        at |= {id: (x + dx, y + dy) for id, (dx, dy) in block.at.items()}
    header = box["header"] if box is not None else (0.0, 0.0)
    corners = []
    if box is not None and box.get("frame"):
        (x, y), (wide, high) = box["position"], box["frame"]
        corners = [plane((x - wide / 2, y - high / 2)), plane((x + wide / 2, y + high / 2))]
    areas += [(plane(bend), (0.0, 0.0, 0.0)) for bend in bends]
    left = min([x - side - PADDING for (x, _), (side, _, _) in areas] + [x for x, _ in corners])
    right = max([x + side + PADDING for (x, _), (side, _, _) in areas] + [x for x, _ in corners])
    top = min([y - up - PADDING - header[1] for (_, y), (_, up, _) in areas] + [y for _, y in corners])
    bottom = max([y + down + PADDING for (_, y), (_, _, down) in areas] + [y for _, y in corners])

    def bent(points: Iterable[Point]) -> list[Point]:
        return [(x - left, y - top) for x, y in map(plane, points)]

    size = max(right - left, header[0] + 8), bottom - top
    return Sheet({id: (x - left, y - top) for id, (x, y) in at.items()}, size, bent)


def _overlap(one: Point, first: Reach, other: Point, second: Reach, gap: float) -> bool:
    if abs(one[0] - other[0]) >= first[0] + second[0] + gap:
        return False
    if one[1] < other[1]:
        return one[1] + first[2] + gap > other[1] - second[1]
    return other[1] + second[2] + gap > one[1] - first[1]


def needed_scale(one: Item, other: Item, gap: float) -> float:
    """Return by how much the plane must grow for two items to be so far apart while they are closed."""
    assert one.position is not None and other.position is not None
    dx, dy = abs(one.position[0] - other.position[0]), other.position[1] - one.position[1]
    across = one.closed[0] + other.closed[0] + gap
    along = (one.closed[2] + other.closed[1] if dy > 0 else one.closed[1] + other.closed[2]) + gap
    return min(across / dx if dx else math.inf, along / abs(dy) if dy else math.inf)


def scale_of(items: Sequence[Item]) -> float:
    """Return by how much the plane grows so that what can be told apart does not overlap.

    Items that just get clear of each other at the limit do with a smaller gap.
    """
    if not items:
        return 1.0
    needs = {pair: needed_scale(*pair, GAP) for pair in itertools.combinations(items, 2)}
    most = sorted(max([1.0, *(need for pair, need in needs.items() if item in pair)]) for item in items)
    limit = max(MOST_SCALE, 2 * most[(len(most) - 1) // 2])
    clear = [min(need, limit) for pair, need in needs.items() if needed_scale(*pair, 0) <= limit]
    return max([1.0, *clear])


def _seat(item: Item, base: dict[Item, Point], scale: float) -> Reach:
    """Return half of the room of a box: its frame, unless that holds other items of the sheet."""
    wide, high = item.frame or (0.0, 0.0)
    side, up, down = item.closed
    framed = max(side, wide * scale / 2), max(up, high * scale / 2), max(down, high * scale / 2)
    taken = any(
        _overlap(base[item], framed, at, other.closed, 0) for other, at in base.items() if other is not item
    )
    return item.closed if taken else framed


def _plane(items: Sequence[Item]) -> Callable[[Point], Point]:
    """Return the map from stored positions to the picture: a scale, and wider strips where boxes are open."""
    scale = scale_of(items)
    base = {
        item: (item.position[0] * scale, item.position[1] * scale)
        for item in items
        if item.position is not None
    }
    across, along = [], []
    for item, (x, y) in base.items():
        if item.reach is not item.closed:
            side, up, _ = _seat(item, base, scale)
            across.append((x - side, x + side, max(0.0, item.reach[0] / side - 1)))
            along.append((y - up, y + up, max(0.0, item.reach[1] / up - 1)))
    on_x, on_y = _stretched(across), _stretched(along)
    return lambda point: (on_x(point[0] * scale), on_y(point[1] * scale))


def _stretched(strips: Sequence[tuple[float, float, float]]) -> Callable[[float], float]:
    ends = sorted({end for strip in strips for end in strip[:2]})
    rates = [
        (low, high, max((rate for start, end, rate in strips if start <= low and end >= high), default=0.0))
        for low, high in itertools.pairwise(ends)
    ]
    return lambda value: value + sum(rate * max(0.0, min(value, high) - low) for low, high, rate in rates)


def _in_order(blocks: Sequence[Block], placed: set[str]) -> Iterable[Block]:
    """Yield what is joined to things that have their place first."""
    rest, placed = list(blocks), set(placed)
    while rest:
        block = next((one for one in rest if one.anchor or one.near & placed), rest[0])
        rest.remove(block)
        placed |= block.at.keys()
        yield block


def _free_place(reach: Reach, areas: Sequence[tuple[Point, Reach]], near: Sequence[Point]) -> Point:
    """Return the nearest point to some others where a block covers nothing."""
    if not near:
        return 0.0, 0.0
    middle_x, middle_y = (sum(point[axis] for point in near) / len(near) for axis in (0, 1))
    step = max(12.0, min(reach[:2]) / 3)
    for ring in range(150):
        turns = max(1, 8 * ring)
        for turn in range(turns):
            angle = math.tau * turn / turns
            point = middle_x + step * ring * math.cos(angle), middle_y + step * ring * math.sin(angle)
            if not any(_overlap(point, reach, at, room, ROOM) for at, room in areas):
                return point
    return middle_x, max(at[1] + room[2] for at, room in areas) + ROOM + reach[1]
