"""Nets as pages: one HTML file that needs no network and no server."""

from __future__ import annotations

import base64
import gzip
from functools import cache

from markupsafe import Markup

from dineros.views.javascript.modules import linked
from dineros.views.nets.contents.model import ViewModel
from dineros.views.nets.drawing.legend import legend_svg
from dineros.views.nets.drawing.svg import THEMES, stylesheet
from dineros.views.nets.placement.placing import layout
from dineros.views.pages import data_markup, filled_in, own_markup, own_text
from dineros.views.policy import content_policy

_KEYS = (
    ("/ or f", "search"),
    ("arrows, + and -", "move, zoom; also by dragging and the wheel"),
    ("0", "show the whole picture"),
    ("Tab, Enter", "move between elements, select one"),
    ("Space", "collapse or expand the selected page; also by its + sign or a double click"),
    ("a", "show the elements near the selected one"),
    ("e", "show everything again"),
    ("c and x", "collapse, expand all pages"),
    ("n and p", "next and previous difference of two models"),
    ("Esc", "choose nothing"),
)


def to_html(view: ViewModel) -> str:
    """Return a page that shows a view, and in which readers can collapse, expand, search and move.

    Parameters
    ----------
    view : ViewModel
        The view; boxes that are collapsed start so.

    Raises
    ------
    DinerosError
        The view cannot be laid out.
    """
    places, transitions = (sum(node.kind == kind for node in view.nodes) for kind in ("place", "transition"))
    script = linked("net/page.js")
    return filled_in(
        "net/page.html.j2",
        title=view.title,
        kind=f"{view.kind}, {places} places, {transitions} transitions",
        keys=_KEYS,
        signs=own_markup("static/net/net.css"),
        style=own_markup("static/net/page.css"),
        figures={theme: Markup(stylesheet(theme)) for theme in THEMES},
        legend=Markup(legend_svg()),
        view=data_markup(view.to_json()),
        positioned=data_markup(layout(view)),
        elk=_packed_elk(),
        layout=Markup(linked("net/layout/worker.js")),
        script=Markup(script),
        policy=content_policy([script], workers=True),
    )


@cache
def _packed_elk() -> str:
    return base64.b64encode(
        gzip.compress(own_text("vendor/elk/elk.bundled.js").encode(), 9, mtime=0)
    ).decode()
