"""Pictures of nets: a view model made from any model, its layout, and SVG, PNG and pages in a browser.

``view_of(model)`` makes the view, ``layout(view)`` puts its visible part on a plane, ``to_svg(positioned)``
draws that: by the code of the pages, `static/net`, which in a browser changes marking and highlights by id.
"""

from __future__ import annotations

from dineros.views.nets.contents.building import view_of
from dineros.views.nets.contents.model import Box, Edge, Node, ViewModel
from dineros.views.nets.contents.operations import around, collapse, collapse_if_large, expand, with_badges
from dineros.views.nets.differences.comparing import compare, differences
from dineros.views.nets.drawing.page import to_html
from dineros.views.nets.drawing.paper import Paper, collapse_to_read
from dineros.views.nets.drawing.png import to_png
from dineros.views.nets.drawing.saving import FORMATS, save_for_paper, save_picture
from dineros.views.nets.drawing.svg import to_svg
from dineros.views.nets.placement.placing import layout

__all__ = [
    "FORMATS",
    "Box",
    "Edge",
    "Node",
    "Paper",
    "ViewModel",
    "around",
    "collapse",
    "collapse_if_large",
    "collapse_to_read",
    "compare",
    "differences",
    "expand",
    "layout",
    "save_for_paper",
    "save_picture",
    "to_html",
    "to_png",
    "to_svg",
    "view_of",
    "with_badges",
]
