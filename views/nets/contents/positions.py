"""Reads the stored positions of nodes, channels and pages, and bend points of arcs."""

from __future__ import annotations

import math
from typing import TypeAlias

from dineros.metamodel import pn

Position: TypeAlias = tuple[float, float]


def points_of(element: pn.Element) -> list[Position]:
    """Return the points that are stored with an element; none if one of them is not a valid point."""
    graphics = element.graphics
    if graphics is None:
        return []
    points = [(float(point.x), float(point.y)) for point in graphics.positions]
    return points if all(map(math.isfinite, (value for point in points for value in point))) else []


def position_of(element: pn.Element) -> Position | None:
    """Return the stored centre of an element."""
    points = points_of(element)
    return points[0] if points else None


def of_page(page: pn.Page) -> tuple[Position | None, Position | None]:
    """Return the centre of a page, and width and height of its frame.

    A page is a sheet of its own, and a sign on its parent sheet: its position is the centre of that sign.
    Some editors draw the page's content there instead, inside of a frame: then all positions are
    those of one plane, and the page's position is the left upper corner of the frame, or its centre. Which of
    them it is shows in where the content stands; a frame that the content is not in is not a frame.
    """
    position = position_of(page)
    size = page.graphics.dimension if page.graphics is not None else None
    if position is None or size is None or not (0 < size.x < math.inf and 0 < size.y < math.inf):
        return position, None
    half = size.x / 2, size.y / 2
    inside = [point for item in page.objects for point in points_of(item)[:1]]
    for centre in ((position[0] + half[0], position[1] + half[1]), position):
        if inside and all(abs(x - centre[0]) <= half[0] and abs(y - centre[1]) <= half[1] for x, y in inside):
            return centre, (float(size.x), float(size.y))
    return position, None
