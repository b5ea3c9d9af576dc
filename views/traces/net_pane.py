"""The picture of the net next to a trace."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dineros.metamodel import pn

if TYPE_CHECKING:
    from dineros.views.nets.placement.picture import Picture


def net_content(model: pn.Net | None) -> Picture | None:
    """Return the data from which the page draws the net; None without a model."""
    if model is None:
        return None
    from dineros.views.nets import layout, view_of

    return layout(view_of(model))
