"""Free shapes in columns, in the direction of their lines: where Graphviz is missing too."""

from __future__ import annotations

from collections.abc import Sequence

from dineros.views.nets.placement.stored import Point
from dineros.views.nets.placement.straight import Sized

_BETWEEN, _BELOW = 60.0, 30.0


def in_columns(shapes: Sequence[Sized], links: Sequence[tuple[str, str]]) -> dict[str, Point]:
    """Return the centres of shapes, none above another; `straight.Free` tells of the arguments."""
    after: dict[str, list[str]] = {id: [] for id, _, _ in shapes}
    entered = set()
    for source, target in links:
        after[source].append(target)
        entered.add(target)
    column: dict[str, int] = {}
    for first in [*(id for id in after if id not in entered), *after]:
        border = [first] if first not in column else []
        column.setdefault(first, 0)
        while border:
            near = [other for id in border for other in after[id] if other not in column]
            for other in near:
                column[other] = column[border[0]] + 1
            border = list(dict.fromkeys(near))
    at: dict[str, Point] = {}
    left = 0.0
    for number in range(max(column.values(), default=-1) + 1):
        members = [shape for shape in shapes if column[shape[0]] == number]
        wide = max(width for _, width, _ in members)
        y = -sum(height + _BELOW for _, _, height in members) / 2
        for id, _, height in members:
            at[id] = (left + wide / 2, y + height / 2)
            y += height + _BELOW
        left += wide + _BETWEEN
    return at
