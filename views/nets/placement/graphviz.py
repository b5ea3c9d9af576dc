"""Layout by Graphviz, where ELK cannot answer: less tidy, but a complete picture."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.views.nets.placement.shown import visible
from dineros.views.nets.placement.stored import Point
from dineros.views.nets.placement.straight import Sized, layout_straight

SECONDS = 300
"""Longest time for one picture."""

_POINTS = 72.0  # Graphviz's inches are points in the picture
_PADDING = 12.0
_BACKWARDS = ("response", "return")


def layout_by_graphviz(view: dict[str, Any]) -> dict[str, Any]:
    """Lay a view out; arguments and result are those of `layout_by_elk`.

    Raises
    ------
    DinerosError
        Graphviz is missing, fails, or takes longer than `SECONDS`.
    """
    seen = visible(view)
    if any(item.get("position") for item in (*view["boxes"], *view["nodes"])):
        return layout_straight(seen, _free)
    return _positioned(seen, _run(_dot(seen)))


def _free(shapes: Sequence[Sized], links: Sequence[tuple[str, str]]) -> dict[str, Point]:
    """Lay out what has no position on a sheet that has none, or that others have on it."""
    names = {id: f"n{number}" for number, (id, _, _) in enumerate(shapes)}
    lines = [_shape(names[id], width, height) for id, width, height in shapes]
    lines += [f"{names[one]} -> {names[other]}" for one, other in links]
    graph = "graph [rankdir=LR, nodesep=0.3, ranksep=0.6]", 'node [shape=box, fixedsize=true, label=""]'
    drawn = _run(["digraph {", *graph, *lines, "}"])
    at = {item["name"]: item["pos"].split(",") for item in drawn.get("objects", ())}
    return {id: (float(at[name][0]), -float(at[name][1])) for id, name in names.items()}


def _run(source: Iterable[str]) -> Any:
    """Return what Graphviz makes of a graph."""
    try:
        run = subprocess.run(
            ["dot", "-Tjson"],
            input="\n".join(source).encode(errors="replace"),
            capture_output=True,
            check=True,
            timeout=SECONDS,
        )
    except FileNotFoundError as error:
        raise DinerosError(
            "pictures of nets need mini-racer or Graphviz, and neither is there",
            hint="pip install 'dineros[view]'",
        ) from error
    except OSError as error:
        raise DinerosError(f"Graphviz cannot be started: {error.strerror}") from error
    except subprocess.TimeoutExpired as error:
        raise DinerosError(
            f"the picture is not laid out after {SECONDS} s", hint="collapse pages, or show a neighbourhood"
        ) from error
    except subprocess.CalledProcessError as error:
        raise DinerosError(f"Graphviz failed: {error.stderr.decode(errors='replace')}") from error
    return json.loads(run.stdout)


def _dot(view: dict[str, Any]) -> Iterator[str]:
    yield "digraph {"
    yield "  graph [rankdir=LR, splines=polyline, nodesep=0.3, ranksep=0.45, compound=true]"
    yield '  node [shape=box, fixedsize=true, label=""] edge [fontname=Helvetica, fontsize=9, arrowsize=0.5]'
    # Names are numbers: ids may hold anything.
    names = {item["id"]: f"n{number}" for number, item in enumerate([*view["boxes"], *view["nodes"]])}
    yield from _inside(view, names, None, "  ")
    for number, edge in enumerate(view["edges"]):
        source, target = names[edge["source"]], names[edge["target"]]
        back = edge["kind"] in _BACKWARDS
        if back:
            source, target = target, source
        label = f', label="{"m" * max(1, round(edge["room"][0] / 7.5))}"' if edge.get("label") else ""
        yield f"  {source} -> {target} [id=e{number}, dir=none{label}]"
    yield "}"


def _inside(view: dict[str, Any], names: dict[str, str], box: str | None, indent: str) -> Iterator[str]:
    for node in view["nodes"]:
        if node.get("box") == box:
            # Captions stand below the shape: as much room above keeps the shape in the middle.
            wide = max(node["width"], node.get("room", (0, 0))[0])
            high = node["height"] + 2 * node.get("room", (0, 0))[1]
            yield f"{indent}{_shape(names[node['id']], wide, high)}"
    for inner in view["boxes"]:
        if inner.get("parent") == box and inner.get("collapsed"):
            yield f"{indent}{_shape(names[inner['id']], inner['width'], inner['height'])}"
        elif inner.get("parent") == box:
            name = names[inner["id"]]
            wide, high = inner["header"]
            yield f"{indent}subgraph cluster_{name} {{"
            yield (
                f'{indent}  graph [margin=12, label=<<TABLE BORDER="0" FIXEDSIZE="TRUE" '
                f'WIDTH="{wide:.0f}" HEIGHT="{high:.0f}"><TR><TD></TD></TR></TABLE>>]'
            )
            yield from _inside(view, names, inner["id"], indent + "  ")
            yield f"{indent}  {name}_anchor [style=invis, width=0.01, height=0.01]"
            yield f"{indent}}}"


def _shape(name: str, width: float, height: float) -> str:
    return f"{name} [width={width / _POINTS:.4f}, height={height / _POINTS:.4f}]"


def _positioned(view: dict[str, Any], drawn: dict[str, Any]) -> dict[str, Any]:
    _, _, wide, high = (float(part) for part in drawn["bb"].split(","))

    def at(text: str) -> tuple[float, float]:
        x, y = text.split(",")
        return round(float(x) + _PADDING, 1), round(high - float(y) + _PADDING, 1)

    items = {item["name"]: item for item in drawn.get("objects", ())}
    lines = {line["id"]: line for line in drawn.get("edges", ())}
    all_items = [*view["boxes"], *view["nodes"]]
    boxes, nodes = [], []
    for number, item in enumerate(all_items):
        made = dict(item)
        if number >= len(view["boxes"]):
            made["x"], made["y"] = at(items[f"n{number}"]["pos"])
            nodes.append(made)
        elif item.get("collapsed"):
            x, y = at(items[f"n{number}"]["pos"])
            made["x"], made["y"] = x - item["width"] / 2, y - item["height"] / 2
            boxes.append(made)
        else:
            left, low, right, top = (float(part) for part in items[f"cluster_n{number}"]["bb"].split(","))
            made |= {"x": left + _PADDING, "y": high - top + _PADDING}
            made |= {"width": round(right - left, 1), "height": round(top - low, 1)}
            boxes.append(made)
    shapes = {item["id"]: item for item in nodes}
    edges = []
    for number, edge in enumerate(view["edges"]):
        line = lines[f"e{number}"]
        points = [at(point) for point in line["pos"].replace("e,", "").split()]
        points = points[::3]  # of a polyline's Bézier pieces, every third point is on the line
        if edge["kind"] in _BACKWARDS:
            points.reverse()
        _meet(points, shapes.get(edge["source"]), 0)
        _meet(points, shapes.get(edge["target"]), -1)
        made = {**edge, "points": points}
        if "lp" in line:
            made["labelAt"] = at(line["lp"])
        edges.append(made)
    size = {"width": round(wide + 2 * _PADDING, 1), "height": round(high + 2 * _PADDING, 1)}
    return {**view, **size, "boxes": boxes, "nodes": nodes, "edges": edges}


def _meet(points: list[tuple[float, float]], node: dict[str, Any] | None, end: int) -> None:
    """Lead a line, which ends at the room around a node, on to its shape."""
    if node is None or len(points) < 2:
        return
    (x, y), (centre_x, centre_y) = points[end], (node["x"], node["y"])
    dx, dy = x - centre_x, y - centre_y
    if not dx and not dy:
        return
    if node["kind"].startswith("place"):
        part = node["width"] / 2 / (dx * dx + dy * dy) ** 0.5
    else:
        part = min(
            node["width"] / 2 / abs(dx) if dx else float("inf"),
            node["height"] / 2 / abs(dy) if dy else float("inf"),
        )
    if part < 1:
        points[end] = (round(centre_x + dx * part, 1), round(centre_y + dy * part, 1))
