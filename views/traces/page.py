"""A trace as one HTML file that needs nothing else: no network, no server, nothing installed."""

from __future__ import annotations

import json
from typing import Any

from jinja2 import Environment
from markupsafe import Markup

from dineros.views.policy import content_policy
from dineros.views.traces.assets import DRAWING, PAGE, net_script, script, style, template


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
    scripts = _scripts()
    return _page(content, title, scripts, content_policy([scripts]))


def live_page(connect: str) -> tuple[str, str]:
    """Return the page that follows a running application, and its policy, for the header of the answer.

    Parameters
    ----------
    connect : str
        Where the page may connect to.
    """
    scripts = _scripts("live")
    return _page({"live": True}, "live", scripts, None), content_policy([scripts], connect=connect)


def _scripts(*more: str) -> str:
    parts = [net_script(), script(*DRAWING, *PAGE), script(*more), "DinerosTrace.start();"]
    return "\n".join(["", *parts, ""])


def _page(content: dict[str, Any], title: str, scripts: str, policy: str | None) -> str:
    data = json.dumps(content, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    return (
        Environment(autoescape=True)
        .from_string(template())
        .render(
            policy=policy, title=title, style=Markup(style()), script=Markup(scripts), content=Markup(data)
        )
    )
