"""Layout of views by ELK (elkjs) in V8, by the pages' own code."""

from __future__ import annotations

from dineros.views.javascript.client import evaluate
from dineros.views.nets.contents.model import ViewModel
from dineros.views.nets.placement.picture import Picture

SCRIPTS = (
    "vendor/elk/elk.bundled.js",
    *(f"static/net/{name}.js" for name in ("layout/elk", "layout/stored", "renderer", "figure")),
)
"""All scripts for nets in V8: they are loaded once for layout and drawing."""


def layout(view: ViewModel, *, aspect: float | None = None) -> Picture:
    """Lay out the visible part of a view.

    Parameters
    ----------
    view : ViewModel
        The view; collapsed boxes hide their content.
    aspect : float, optional
        Width by height that the layout is to come near to, by breaking it into several lines, as text is: for
        paper. Positions from an editor are kept.

    Returns
    -------
    Picture
        The visible part of the view, each with its place.

    Raises
    ------
    ScriptError
        This view cannot be laid out.
    LayouterError
        V8 is not installed, its process has ended, or it took too long.
    """
    shown = view.to_json() | ({} if aspect is None else {"aspect": aspect})
    placed: Picture = evaluate(SCRIPTS, "layoutByElk", shown)
    return placed
