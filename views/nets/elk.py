"""Layout by ELK (elkjs) inside Python: no browser and no Node.js, only the V8 engine of mini-racer."""

from __future__ import annotations

import atexit
import json
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from dineros.metamodel.errors import DinerosError

if TYPE_CHECKING:
    from py_mini_racer import MiniRacer

SECONDS = 300
"""Longest time for one picture."""

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

# What ELK expects of a browser: a global object, and timers, which need not wait here.
_BROWSER = """
var global = globalThis;
setTimeout = (work, delay, ...rest) => { Promise.resolve().then(() => work(...rest)); return 0; };
"""
_START = """
var netElk = new ELK(), netResult = {};
function startLayout(view) {
  netResult = {};
  NetLayout.layout(view, netElk).then(
    (done) => { netResult = {value: done}; },
    (error) => { netResult = {error: String(error && error.message || error)}; });
}
"""


def is_there() -> bool:
    """Tell whether ELK can run: mini-racer is part of the extra ``view``."""
    from importlib.util import find_spec

    return find_spec("py_mini_racer") is not None


def layout_by_elk(view: dict[str, Any]) -> dict[str, Any]:
    """Lay a view out.

    Parameters
    ----------
    view : dict
        What `ViewModel.to_json` returns.

    Raises
    ------
    DinerosError
        The engine gave up, or took longer than `SECONDS`.
    """
    found = _worker().submit(_layout, json.dumps(view)).result()
    if "value" not in found:
        raise DinerosError(f"the picture cannot be laid out: {found.get('error', 'no answer')}")
    result: dict[str, Any] = found["value"]
    return result


def visible_by_script(view: dict[str, Any]) -> dict[str, Any]:
    """Return the visible part of a view as pages in a browser compute it."""
    result: dict[str, Any] = _call("NetLayout.visible", view)
    return result


def around_by_script(view: dict[str, Any], ids: list[str], steps: int) -> dict[str, Any]:
    """Return the neighbourhood of some elements as pages in a browser compute it."""
    result: dict[str, Any] = _call("NetLayout.around", view, ids, steps)
    return result


def markup_by_script(positioned: dict[str, Any], marking: dict[str, int]) -> str:
    """Return the SVG of a positioned net as pages in a browser draw it."""
    return str(_call("NetRenderer.markup", positioned, marking))


def _call(function: str, *arguments: Any) -> Any:
    return _worker().submit(_evaluate, f"{function}({', '.join(map(json.dumps, arguments))})").result()


@cache
def _worker() -> ThreadPoolExecutor:
    """Return a thread of the engine's own: in one that runs an event loop it would refuse to wait."""
    return ThreadPoolExecutor(1, thread_name_prefix="net-layout")


def _layout(view: str) -> Any:
    from py_mini_racer import JSTimeoutException

    try:
        _engine().eval(f"startLayout({view})", timeout_sec=SECONDS)
    except JSTimeoutException as error:
        raise DinerosError(
            f"the picture is not laid out after {SECONDS} s", hint="collapse pages, or show a neighbourhood"
        ) from error
    return _evaluate("netResult")


def _evaluate(expression: str) -> Any:
    return json.loads(str(_engine().eval(f"JSON.stringify({expression})")))


@cache
def _engine() -> MiniRacer:
    """Return V8 with ELK loaded, once per process; only `_worker` may use it."""
    from py_mini_racer import MiniRacer

    engine = MiniRacer()
    atexit.register(engine.close)  # later, its event loop's thread is gone and closing would wait for ever
    engine.eval(_BROWSER)
    for script in ("vendor/elk/elk.bundled.js", *(f"static/{name}" for name in SCRIPTS)):
        engine.eval(files("dineros.views").joinpath(script).read_text(encoding="utf-8"))
    engine.eval(_START)
    return engine
