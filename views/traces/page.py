"""A trace as one HTML file that needs nothing else: no network, no server, nothing installed."""

from __future__ import annotations

import json
from typing import Any

from jinja2 import Environment
from markupsafe import Markup

from dineros.views.traces.assets import DRAWING, PAGE, net_script, script, style, template

POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"


def trace_page(content: dict[str, Any], *, title: str, policy: str = POLICY, more: str = "") -> str:
    """Return the page.

    Parameters
    ----------
    content : dict
        ``view`` is what `TraceCoder.snapshot` returns; ``other`` the same of a second trace, and
        ``divergence`` where they part; ``net`` the picture of the net; ``live`` for a page that follows a
        running application.
    title : str
        Title of the page.
    policy : str
        What the page may load (Content Security Policy): by default nothing at all.
    more : str
        More scripts.
    """
    data = json.dumps(content, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    return (
        Environment(autoescape=True)
        .from_string(template())
        .render(
            policy=policy,
            title=title,
            style=Markup(style()),
            script=Markup("\n".join([net_script(), script(*DRAWING, *PAGE), more])),
            content=Markup(data),
        )
    )
