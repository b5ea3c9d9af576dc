"""Layout of views: by ELK, otherwise by Graphviz, otherwise in columns."""

from __future__ import annotations

from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.views.javascript.client import say_once
from dineros.views.nets.contents.model import ViewModel
from dineros.views.nets.placement import elk
from dineros.views.nets.placement.columns import in_columns
from dineros.views.nets.placement.graphviz import layout_by_graphviz
from dineros.views.nets.placement.straight import layout_straight


def layout(view: ViewModel, *, aspect: float | None = None) -> dict[str, Any]:
    """Put the visible part of a view on a plane.

    There always is a picture: where ELK or its process fails, one line of the log says why, and Graphviz
    takes its place, and where that is missing, shapes stand in columns with straight lines between them.

    Parameters
    ----------
    view : ViewModel
        The view; collapsed boxes hide their content.
    aspect : float, optional
        Width by height that the layout is to come near to, by breaking it into several lines, as text is: for
        paper. Only ELK does that, with what no editor arranged.

    Returns
    -------
    dict
        JSON values: those of the visible part of the view; in addition `width` and `height` of the picture in
        pixels; `x`, `y` of boxes (left upper corner; `width` and `height` too) and nodes (centre); `points`
        of edges and, where they have a label, its middle, `labelAt`.
    """
    shown, failed = view.to_json() | ({} if aspect is None else {"aspect": aspect}), None
    if elk.is_there():
        try:
            return elk.layout_by_elk(shown)
        except DinerosError as error:
            failed = error
    try:
        made = layout_by_graphviz(shown)
    except DinerosError as error:
        say_once("nets are laid out in columns", failed or error)
        return layout_straight(shown, in_columns)
    if failed:
        say_once("nets are laid out by Graphviz", failed)
    return made
