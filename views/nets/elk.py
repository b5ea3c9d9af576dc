"""Layout by ELK (elkjs): neither browser nor Node.js, only V8 (mini-racer) in a process of its own."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

from dineros.views.javascript.client import evaluate

SCRIPTS = (
    "net_stored.js",
    "net_order.js",
    "net_pieces.js",
    "net_blocks.js",
    "net_lines.js",
    "net_captions.js",
    "net_drawn.js",
    "net_layout.js",
    "net_renderer.js",
)
"""What lays nets out and draws them, here and in browsers, besides ELK."""

_FILES = ("vendor/elk/elk.bundled.js", *(f"static/{name}" for name in SCRIPTS))


def is_there() -> bool:
    """Tell whether ELK can run: mini-racer is part of the extra ``view``."""
    return find_spec("py_mini_racer") is not None


def layout_by_elk(view: dict[str, Any]) -> dict[str, Any]:
    """Lay a view out.

    Parameters
    ----------
    view : dict
        What `ViewModel.to_json` returns.

    Raises
    ------
    ScriptError
        ELK cannot lay this view out.
    LayouterError
        Its process is not there, has ended, or took too long.
    """
    result: dict[str, Any] = evaluate(
        _FILES, "(view) => NetLayout.layout(view, globalThis.netElk ??= new ELK())", view
    )
    return result


def visible_by_script(view: dict[str, Any]) -> dict[str, Any]:
    """Return the visible part of a view as pages in a browser compute it."""
    result: dict[str, Any] = evaluate(_FILES, "NetLayout.visible", view)
    return result


def around_by_script(view: dict[str, Any], ids: list[str], steps: int) -> dict[str, Any]:
    """Return the neighbourhood of some elements as pages in a browser compute it."""
    result: dict[str, Any] = evaluate(_FILES, "NetLayout.around", view, ids, steps)
    return result


def markup_by_script(positioned: dict[str, Any], marking: dict[str, int]) -> str:
    """Return the SVG of a positioned net as pages in a browser draw it."""
    return str(evaluate(_FILES, "NetRenderer.markup", positioned, marking))
