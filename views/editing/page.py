"""The page of the editor: one HTML text, with the canvas and everything else it needs in it."""

from __future__ import annotations

from markupsafe import Markup

from dineros.views.javascript.modules import linked
from dineros.views.pages import filled_in, own_markup, own_text
from dineros.views.policy import content_policy

_STYLES = ("vendor/diagram/diagram.css", "static/net/net.css", "static/edit/edit.css")


def editor_page(title: str, connect: str) -> tuple[str, str]:
    """Return the page and its policy.

    Parameters
    ----------
    title : str
        Its title.
    connect : str
        Addresses to which it may connect.
    """
    script = linked("edit/page.js")
    canvas = own_text("vendor/diagram/diagram.bundled.js")
    style = own_markup(*_STYLES)
    page = filled_in(
        "edit/page.html.j2", title=title, style=style, canvas=Markup(canvas), script=Markup(script)
    )
    return page, content_policy([canvas, script], connect=connect)
