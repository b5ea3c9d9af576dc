"""Labels of straight lines: on or beside the middle of their line, where nothing else stands."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, TypeAlias

from dineros.views.nets.placement.stored import Point

Area: TypeAlias = tuple[float, float, float, float]
"""Left, top, right and bottom."""

_PARTS = sorted((part / 20 for part in range(1, 20)), key=lambda part: abs(part - 0.5))
_ASIDE = (0, -1, 1, -2, 2, -3, 3, -5, 5)  # heights of a label, up and down


def place_labels(picture: dict[str, Any]) -> None:
    """Give the lines of a picture that have a label its middle, `labelAt`."""
    taken = [_of_node(node) for node in picture["nodes"]]
    taken += [_of_box(box) for box in picture["boxes"]]
    for edge in picture["edges"]:
        if edge.get("label"):
            x, y = next(
                (at for at in _beside(edge) if _is_free(_around(at, edge["room"]), picture, taken)),
                next(_beside(edge)),
            )
            edge["labelAt"] = [round(x, 1), round(y, 1)]
            taken.append(_around((x, y), edge["room"]))


def _beside(edge: dict[str, Any]) -> Iterator[Point]:
    """Yield where a label may stand, the best place first."""
    half = len(edge["points"]) // 2
    (from_x, from_y), (to_x, to_y) = edge["points"][half - 1 : half + 1]
    for aside in _ASIDE:
        for part in _PARTS:
            yield from_x + (to_x - from_x) * part, from_y + (to_y - from_y) * part + aside * edge["room"][1]


def _is_free(area: Area, picture: dict[str, Any], taken: list[Area]) -> bool:
    left, top, right, bottom = area
    is_inside = left >= 0 and top >= 0 and right <= picture["width"] and bottom <= picture["height"]
    return is_inside and not any(
        left < other[2] and other[0] < right and top < other[3] and other[1] < bottom for other in taken
    )


def _around(at: Point, size: Point) -> Area:
    return at[0] - size[0] / 2, at[1] - size[1] / 2, at[0] + size[0] / 2, at[1] + size[1] / 2


def _of_node(node: dict[str, Any]) -> Area:
    """Return what a node and its captions cover."""
    wide, down = node.get("room", (0.0, 0.0))
    left, top, right, bottom = _around((node["x"], node["y"]), (max(node["width"], wide), node["height"]))
    return left, top, right, bottom + down


def _of_box(box: dict[str, Any]) -> Area:
    """Return what a closed box covers, of an open one its title."""
    width, height = (box["width"], box["height"]) if box.get("collapsed") else box["header"]
    return box["x"], box["y"], box["x"] + width, box["y"] + height
