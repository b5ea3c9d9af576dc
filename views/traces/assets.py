"""Style and frame of the Trace Visualizer's pages."""

from __future__ import annotations

from functools import cache
from importlib.resources import files


@cache
def style() -> str:
    """Return the style sheet of the page."""
    return _read("net/net.css") + _read("trace/trace.css")


@cache
def template() -> str:
    """Return the page, a template of Jinja."""
    return _read("trace/page.html.j2")


def _read(name: str) -> str:
    return (files("dineros.views") / "static" / name).read_text(encoding="utf-8")
