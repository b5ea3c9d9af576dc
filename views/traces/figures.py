"""A trace as SVG and PNG, for papers: drawn by the page's own code, without a browser."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from dineros.views.javascript.client import evaluate

if TYPE_CHECKING:
    from dineros.views.nets.drawing.svg import Theme


def trace_svg(views: Sequence[dict[str, Any]], theme: Theme = "light", **options: Any) -> str:
    """Draw a trace, or two to compare.

    Parameters
    ----------
    views : sequence of dict
        What `TraceCoder.snapshot` returns.
    theme : {"light", "dark"}
        Colours.
    **options
        ``width`` of the lanes in pixels, ``time`` for wall-clock time, ``fold``, ``filter`` of the lanes, and
        the ``divergence`` of two traces.

    Raises
    ------
    DinerosError
        V8, which draws, is not installed or gives no answer.
    """
    figure: str = evaluate(
        ["static/trace/figures/figure.js"], "figure", list(views), {"theme": theme, **options}
    )
    return figure


def trace_png(
    views: Sequence[dict[str, Any]], theme: Theme = "light", scale: float = 2, **options: Any
) -> bytes:
    """Draw a trace as `trace_svg` does, as PNG with `scale` pixels for each unit of length.

    Raises
    ------
    DinerosError
        The renderer is not installed.
    """
    from dineros.views.nets import to_png

    return to_png(trace_svg(views, theme, **options), scale=scale)
