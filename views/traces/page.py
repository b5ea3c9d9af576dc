"""A trace as one HTML file that needs nothing else: no network, no server, nothing installed."""

from __future__ import annotations

import json
from typing import Any

from jinja2 import Environment
from markupsafe import Markup

from dineros.views.javascript.modules import linked
from dineros.views.policy import content_policy
from dineros.views.traces.assets import style, template


def trace_page(content: dict[str, Any], *, title: str) -> str:
    """Return the page.

    Parameters
    ----------
    content : dict
        ``view`` is what `TraceCoder.snapshot` returns; ``other`` the same of a second trace, and
        ``divergence`` where they part; ``net`` the picture of the net.
    title : str
        Title of the page.
    """
    script = linked("trace/main.js")
    return _page(content, title, script, content_policy([script]))


def live_page(connect: str) -> tuple[str, str]:
    """Return the page that follows a running application, and its policy, for the header of the answer.

    Parameters
    ----------
    connect : str
        Where the page may connect to.
    """
    script = linked("trace/live.js")
    return _page({}, "live", script, None), content_policy([script], connect=connect)


def _page(content: dict[str, Any], title: str, script: str, policy: str | None) -> str:
    data = json.dumps(content, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    return (
        Environment(autoescape=True)
        .from_string(template())
        .render(
            policy=policy, title=title, style=Markup(style()), script=Markup(script), content=Markup(data)
        )
    )
