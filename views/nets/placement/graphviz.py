"""Layout by Graphviz, where ELK cannot answer: shapes sheet by sheet, and straight lines between them."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterable, Sequence
from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.views.nets.placement.stored import Point
from dineros.views.nets.placement.straight import Sized, layout_straight

SECONDS = 300
"""Longest time for one picture."""

_POINTS = 72.0  # Graphviz's inches are points in the picture


def layout_by_graphviz(view: dict[str, Any]) -> dict[str, Any]:
    """Lay a view out; arguments and result are those of `layout_by_elk`.

    Raises
    ------
    DinerosError
        Graphviz is missing, fails, or takes longer than `SECONDS`.
    """
    return layout_straight(view, _free)


def _free(shapes: Sequence[Sized], links: Sequence[tuple[str, str]]) -> dict[str, Point]:
    """Return the centres of shapes; `straight.Free` tells of the arguments."""
    names = {id: f"n{number}" for number, (id, _, _) in enumerate(shapes)}
    lines = [
        f"{names[id]} [width={width / _POINTS:.4f}, height={height / _POINTS:.4f}]"
        for id, width, height in shapes
    ]
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
