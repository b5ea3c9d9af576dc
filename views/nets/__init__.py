"""Pictures of nets: a view model made from any model, its layout, and SVG, PNG and pages in a browser.

``view_of(model)`` makes the view, ``layout(view)`` puts its visible part on a plane, ``to_svg(positioned)``
draws that; `static/net/renderer.js` draws the same in a browser and changes marking and highlights by id.
"""

from __future__ import annotations

from dineros.views.nets.building import view_of
from dineros.views.nets.comparing import compare, differences
from dineros.views.nets.model import Box, Edge, Node, ViewModel
from dineros.views.nets.operations import around, collapse, collapse_if_large, expand, with_badges
from dineros.views.nets.page import to_html
from dineros.views.nets.placing import layout
from dineros.views.nets.png import to_png
from dineros.views.nets.saving import FORMATS, save_picture
from dineros.views.nets.svg import to_svg

__all__ = [
    "FORMATS",
    "Box",
    "Edge",
    "Node",
    "ViewModel",
    "around",
    "collapse",
    "collapse_if_large",
    "compare",
    "differences",
    "expand",
    "layout",
    "save_picture",
    "to_html",
    "to_png",
    "to_svg",
    "view_of",
    "with_badges",
]
