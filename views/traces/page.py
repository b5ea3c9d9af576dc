"""A trace as one self-contained HTML file, without network, server or installation."""

from __future__ import annotations

from typing import Any

from markupsafe import Markup

from dineros.views.javascript.modules import linked
from dineros.views.pages import data_markup, filled_in, own_markup
from dineros.views.policy import content_policy


def trace_page(content: dict[str, Any], *, title: str) -> str:
    """Return the page.

    Parameters
    ----------
    content : dict
        ``view`` is what `TraceCoder.snapshot` returns; ``other`` the same of a second trace, and
        ``divergence`` their first difference; ``net`` the picture of the net.
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
        Addresses to which the page may connect.
    """
    script = linked("trace/live.js")
    return _page({}, "live", script, None), content_policy([script], connect=connect)


def _page(content: dict[str, Any], title: str, script: str, policy: str | None) -> str:
    style = own_markup("static/net/net.css", "static/trace/trace.css")
    return filled_in(
        "trace/page.html.j2",
        policy=policy,
        title=title,
        style=style,
        script=Markup(script),
        content=data_markup(content),
    )
