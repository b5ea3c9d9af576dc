"""Readable pictures: on paper at a width in millimetres, and initially in a window.

Text in print has 6 points or more: as IEEE and ACM require for figures. A net that is too large for that is
not
drawn smaller; its pages are drawn separately.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from dataclasses import dataclass

from dineros.views.nets.contents.glyphs import NAME_SIZE, SMALL_SIZE
from dineros.views.nets.contents.model import Box, ViewModel
from dineros.views.nets.contents.operations import collapse, collapse_if_large, restricted
from dineros.views.nets.placement.picture import Picture
from dineros.views.nets.placement.placing import layout

LEAST_POINTS = 6.0
"""Size of the smallest text on paper."""

LEAST_PIXELS = 8.0
"""Initial size of names on a screen."""

WINDOW = (1280.0, 640.0)
"""Pixels that a page has for its picture in a small window."""

_POINTS_PER_MILLIMETRE = 72 / 25.4
_ASPECTS = (None, 1.6, 1.0, 0.7)
_TINY = 7.0  # numbers of tokens with four digits and more


@dataclass(frozen=True)
class Paper:
    """Size of a picture.

    Attributes
    ----------
    width : float
        In millimetres.
    aspect : float or None
        Width by height; None: any.
    """

    width: float
    aspect: float | None = None

    def area(self, positioned: Picture) -> tuple[float, float, float, float]:
        """Return the visible part of the plane, with the net in its middle: x, y, width, height."""
        wide, high = positioned["width"], positioned["height"]
        if self.aspect is None:
            return 0.0, 0.0, wide, high
        width, height = max(wide, high * self.aspect), max(high, wide / self.aspect)
        return (wide - width) / 2, (high - height) / 2, width, height

    def needed(self, positioned: Picture) -> float:
        """Return the width in millimetres from which on all text can be read."""
        units = self.area(positioned)[2]
        return float(units * LEAST_POINTS / _smallest(positioned) / _POINTS_PER_MILLIMETRE)


@dataclass(frozen=True)
class Sheet:
    """One picture for paper.

    Attributes
    ----------
    page : str or None
        Id of the page that it shows; None for the whole.
    positioned : Picture
        What `layout` returns.
    needed : float
        The width in millimetres that it needs.
    """

    page: str | None
    positioned: Picture
    needed: float


def sheets_for(view: ViewModel, paper: Paper) -> list[Sheet]:
    """Return the picture of a view for paper; if it is too large, its overview and separate pages.

    Sheets that are still too large are included: their `needed` is more than the paper's width.

    Parameters
    ----------
    view : ViewModel
        The view, with boxes collapsed as it is to be shown.
    paper : Paper
        The room.

    Raises
    ------
    DinerosError
        The view cannot be laid out.
    """
    whole = _best(None, view, paper)
    if whole.needed <= paper.width or not view.boxes:
        return [whole]
    return [_best(None, collapse(view), paper), *(_best(box.id, part, paper) for box, part in _pages(view))]


def _pages(view: ViewModel) -> Iterator[tuple[Box, ViewModel]]:
    """Yield the pages that hold nodes, each with the pages in it collapsed."""
    for box in view.boxes:
        inside = {box.id}
        for other in view.boxes:  # boxes stand after those they are in
            if other.parent in inside:
                inside.add(other.id)
        if not any(node.box == box.id for node in view.nodes):
            continue
        part = restricted(view, {node.id for node in view.nodes if node.box in inside})
        inner = [each.id for each in part.boxes if each.id in inside and each.id != box.id]
        boxes = [
            dataclasses.replace(each, parent=None if each.id == box.id else each.parent)
            for each in collapse(part, inner).boxes
            if each.id in inside
        ]
        yield box, dataclasses.replace(part, boxes=boxes)


def _best(page: str | None, view: ViewModel, paper: Paper) -> Sheet:
    """Return the layout, of several shapes, that needs the least width."""
    aspects = _ASPECTS if paper.aspect is None else (None, paper.aspect)
    made = (layout(view, aspect=aspect) for aspect in aspects)
    found = [Sheet(page, positioned, paper.needed(positioned)) for positioned in made]
    fitting = [sheet for sheet in found if sheet.needed <= paper.width]
    return fitting[0] if fitting else min(found, key=lambda sheet: sheet.needed)


def _smallest(positioned: Picture) -> float:
    """Return the size of the smallest text of a picture."""
    many = any(node.get("tokens", 0) >= 1000 for node in positioned["nodes"])
    return _TINY if many else float(SMALL_SIZE)


def collapse_to_read(view: ViewModel) -> ViewModel:
    """Return the view with enough levels of boxes collapsed so that names are initially readable.

    Parameters
    ----------
    view : ViewModel
        The view; it stays as it is. One with too many nodes to be readable is collapsed completely.

    Raises
    ------
    DinerosError
        The view cannot be laid out.
    """
    view = collapse_if_large(view)
    depths: dict[str, int] = {}
    for box in view.boxes:
        depths[box.id] = 0 if box.parent is None else depths[box.parent] + 1
    for depth in range(max(depths.values(), default=-1), -1, -1):
        positioned = layout(view)
        if min(WINDOW[0] / positioned["width"], WINDOW[1] / positioned["height"]) * NAME_SIZE >= LEAST_PIXELS:
            break
        view = collapse(view, [id for id, level in depths.items() if level >= depth])
    return view


def file_name(id: str) -> str:
    """Return a page's id in a form that is valid in file names."""
    return re.sub(r"[^\w.-]+", "_", id)
