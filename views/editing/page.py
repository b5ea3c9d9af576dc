"""The page of the editor: one HTML text, with the canvas and everything else it needs in it."""

from __future__ import annotations

from functools import cache
from importlib.resources import files

from jinja2 import Environment
from markupsafe import Markup

from dineros.views.javascript.modules import linked
from dineros.views.policy import content_policy

_STYLES = ("vendor/diagram/diagram.css", "static/net/net.css", "static/edit/edit.css")


def editor_page(title: str, connect: str) -> tuple[str, str]:
    """Return the page and its policy.

    Parameters
    ----------
    title : str
        What stands above it.
    connect : str
        Where it may connect to.
    """
    script = linked("edit/page.js")
    canvas = _read("vendor/diagram/diagram.bundled.js")
    page = (
        Environment(autoescape=True)
        .from_string(_read("static/edit/page.html.j2"))
        .render(
            title=title,
            style=Markup("".join(map(_read, _STYLES))),
            canvas=Markup(canvas),
            script=Markup(script),
        )
    )
    return page, content_policy([canvas, script], connect=connect)


@cache
def _read(name: str) -> str:
    return (files("dineros.views") / name).read_text(encoding="utf-8")
