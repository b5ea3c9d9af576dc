"""The browser code of the Trace Visualizer, which draws its figures as well."""

from __future__ import annotations

from functools import cache
from importlib.resources import files

DRAWING = ("data", "scale", "surface", "draw", "causes", "rows", "figure")
"""What draws, in the order it is loaded; needs no browser."""

PAGE = ("view", "labels", "detail", "net_pane", "conditions", "breakpoints", "tools", "keys", "page")
"""What makes it a page."""


@cache
def script(*names: str) -> str:
    """Return scripts of `static/trace`, one after the other."""
    return "\n".join(_read(f"trace/{name}.js") for name in names)


@cache
def net_script() -> str:
    """Return the script that draws nets."""
    return _read("net_renderer.js")


@cache
def style() -> str:
    """Return the style sheet of the page."""
    return _read("net.css") + _read("trace/trace.css")


@cache
def template() -> str:
    """Return the page, a template of Jinja."""
    return _read("trace/page.html.j2")


def _read(name: str) -> str:
    return (files("dineros.views") / "static" / name).read_text(encoding="utf-8")
