"""The picture of the net beside a trace."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any

from dineros.metamodel import pn


def net_content(model: pn.Net | None) -> dict[str, Any] | None:
    """Return what the page draws the net from; None without a model.

    Raises
    ------
    DinerosError
        Nothing that lays nets out is installed.
    """
    if model is None:
        return None
    from dineros.views.nets import layout, view_of

    # On a thread of its own: the layout's engine cannot be waited for where an event loop runs.
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(lambda: layout(view_of(model))).result()
