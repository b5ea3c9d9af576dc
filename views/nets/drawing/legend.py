"""The signs of net pictures, drawn by the same code."""

from __future__ import annotations

from dataclasses import asdict
from functools import cache
from typing import Any

from dineros.views.javascript.client import evaluate
from dineros.views.nets.contents.glyphs import finish_box, finish_node
from dineros.views.nets.contents.model import Box, Caption, EdgeKind, Node, NodeKind, Signal
from dineros.views.nets.placement.placing import SCRIPTS

_NODES: tuple[tuple[NodeKind, str, int | None, str], ...] = (
    ("place", "", 2, "place, with tokens"),
    ("transition", "Danger", None, "transition, with its input clause"),
    ("place-reference", "", None, "reference: the place of this name on another page"),
    ("topic", "topic", None, "topic: a channel between ROS nodes"),
    ("service", "service", None, "service or action"),
)
_EDGES: tuple[tuple[EdgeKind, str], ...] = (
    ("normal", "arc; a number is its weight"),
    ("read", "read arc: requires the token and keeps it"),
    ("inhibitor", "inhibitor arc: needs the place to be empty"),
    ("publish", "to and from a topic, with the queue's capacity"),
    ("request", "request or goal of a client, with its id; call of the server"),
    ("response", "response or result to the client; the server's answer"),
    ("reference", "joins a reference with its place"),
)
_ROW, _LEFT, _WIDTH = 44, 60, 420


@cache
def legend_svg() -> str:
    """Return an SVG element that explains the signs; its colours are those of the page.

    Raises
    ------
    DinerosError
        V8, which draws, is not installed or gives no answer.
    """
    nodes: list[dict[str, Any]] = []
    edges: list[dict[str, Any]] = []
    texts: list[tuple[float, str]] = []
    y = 28
    for kind, caption, tokens, text in _NODES:
        captions = [Caption(caption, "clause")] if kind == "transition" else []
        node = Node(
            f"legend {kind}", kind, caption if kind in ("topic", "service") else "", captions=captions
        )
        finish_node(node)
        nodes.append({**asdict(node), "x": _LEFT, "y": y, "tokens": tokens or 0})
        texts.append((y, text))
        y += _ROW
    for edge, text in _EDGES:
        points = [[20, y - 10], [100, y - 10]]
        edges.append({"id": f"legend {edge}", "kind": edge, "points": points})
        texts.append((y - 10, text))
        y += _ROW - 18
    box = Box("legend box", "node", "selector", signals=[Signal("legend signal", "Danger", True)])
    finish_box(box)
    boxes = [{**asdict(box), "x": 8, "y": y - 8, "width": 116, "height": 48}]
    texts.append((y + 16, "ROS node with its signals; ● is true at the start"))
    y += 50
    picture = {"width": _WIDTH, "height": y, "boxes": boxes, "nodes": nodes, "edges": edges}
    signs = evaluate(SCRIPTS, "netMarkup", picture)
    words = "".join(
        f'<text x="140" y="{at + 4:g}" style="text-anchor:start">{text}</text>' for at, text in texts
    )
    return f'<svg class="net" viewBox="0 0 {_WIDTH} {y}">{signs}{words}</svg>'
