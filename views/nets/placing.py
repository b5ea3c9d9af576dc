"""Layout of views: ELK where its engine is there, otherwise Graphviz."""

from __future__ import annotations

from typing import Any

from dineros.views.nets import elk
from dineros.views.nets.model import ViewModel


def layout(view: ViewModel) -> dict[str, Any]:
    """Put the visible part of a view on a plane.

    Parameters
    ----------
    view : ViewModel
        The view; collapsed boxes hide their content.

    Returns
    -------
    dict
        JSON values: those of the visible part of the view; in addition `width` and `height` of the picture in
        pixels; `x`, `y` of boxes (left upper corner; `width` and `height` too) and nodes (centre); `points`
        of edges and, where they have a label, its middle, `labelAt`.

    Raises
    ------
    DinerosError
        Neither ELK's engine nor Graphviz is there, or the layout takes too long.
    """
    if elk.is_there():
        return elk.layout_by_elk(view.to_json())
    from dineros.views.nets.graphviz import layout_by_graphviz

    return layout_by_graphviz(view.to_json())
