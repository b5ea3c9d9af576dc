"""Pages as self-contained HTML texts, rendered from templates."""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from typing import Any

from jinja2 import Environment
from markupsafe import Markup


@cache
def own_text(name: str) -> str:
    """Return a file of `dineros.views`, such as ``static/net/net.css``."""
    return (files("dineros.views") / name).read_text(encoding="utf-8")


def own_markup(*names: str) -> Markup:
    """Return files of `dineros.views`, concatenated for a page."""
    return Markup("".join(map(own_text, names)))


def data_markup(value: Any) -> Markup:
    """Return JSON for a script element, escaped so that it cannot end the element."""
    return Markup(json.dumps(value, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c"))


def filled_in(template: str, **content: object) -> str:
    """Return the page of a template in `static`; text that is not markup is escaped."""
    environment = Environment(autoescape=True, keep_trailing_newline=True)
    return environment.from_string(own_text(f"static/{template}")).render(**content)
