"""Layout by ELK (elkjs): neither browser nor Node.js, only V8 (mini-racer) in a process of its own."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

from dineros.views.javascript.client import evaluate

_FILES = ("vendor/elk/elk.bundled.js", "static/net/elk.js")


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
    result: dict[str, Any] = evaluate(_FILES, "layoutByElk", view)
    return result
