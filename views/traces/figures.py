"""A trace as SVG and PNG, for papers: drawn by the page's own code, in the engine V8, without a browser."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, Literal

from dineros.metamodel.errors import DinerosError
from dineros.views.traces.assets import DRAWING, script

Theme = Literal["light", "dark"]


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
        The JavaScript engine is not installed.
    """
    try:
        from py_mini_racer import MiniRacer
    except ImportError:
        raise DinerosError(
            "pictures of traces need mini-racer", hint="pip install 'dineros[view]', or write .html"
        ) from None
    with MiniRacer() as engine:
        engine.eval(script(*DRAWING))
        call = f"DinerosTrace.figure({json.dumps(list(views))}, {json.dumps({'theme': theme, **options})})"
        return str(engine.eval(call))


def trace_png(
    views: Sequence[dict[str, Any]], theme: Theme = "light", scale: float = 2, **options: Any
) -> bytes:
    """Draw a trace as `trace_svg` does, as PNG with `scale` pixels for each unit of length.

    Raises
    ------
    DinerosError
        The JavaScript engine or the renderer is not installed.
    """
    from dineros.views.nets import to_png

    return to_png(trace_svg(views, theme, **options), scale=scale)
