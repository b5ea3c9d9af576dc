"""The house: the rooms of the package and their floors, drawn from the imports while the guide is built.

A room is a box, its floors are its folders, each above those that it imports; an arrow leads to a room that
is imported. An arrow that follows from two others is left out.
"""

from __future__ import annotations

import ast
import html
import logging
from collections.abc import Iterable, Sequence
from graphlib import TopologicalSorter
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from dineros.metamodel.errors import DinerosError
from dineros.transformations.pictures.drawing import layout

ROOT = Path(__file__).resolve().parents[2]
ROOMS = (
    "metamodel",
    "transformations",
    "analysis",
    "generators",
    "runtime",
    "sources",
    "observation",
    "views",
    "cli",
)
LOG = logging.getLogger("mkdocs.hooks.house")
HEAD = """digraph {
  graph [bgcolor=white, rankdir=TB, nodesep=0.3, ranksep=0.5, pad=0.1]
  node [shape=plain, fontname="Helvetica", fontsize=12]
  edge [color="#37474f", arrowsize=0.8, arrowhead=vee]
"""

Needs = dict[str, set[str]]


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add the picture to the guide; the hook that MkDocs calls."""
    files.append(File.generated(config, "pictures/house.svg", content=picture()))
    return files


def picture() -> str:
    """Return the picture; a note instead where Graphviz is missing."""
    try:
        return layout(to_dot(), "svg").decode()
    except DinerosError as error:
        LOG.info("the picture of the house is left out: %s", error)
        return (
            '<svg xmlns="http://www.w3.org/2000/svg" width="400" height="40">'
            '<text x="10" y="25">Build the guide with Graphviz installed to see the house.</text></svg>'
        )


def to_dot() -> str:
    """Describe the house in Graphviz's language."""
    rooms: Needs = {room: set() for room in ROOMS}
    floors: dict[str, Needs] = {room: {} for room in ROOMS}
    for room in ROOMS:
        for file in sorted((ROOT / room).rglob("*.py")):
            here = file.relative_to(ROOT).with_suffix("").parts
            if here[1] == "__init__":
                continue
            floors[room].setdefault(here[1], set())
            for other, floor in imported(file):
                if other == room and floor != here[1] and floor:
                    floors[room][here[1]].add(floor)
                elif other != room:
                    rooms[room].add(other)
    lines = [HEAD]
    for room in ROOMS:
        order = [
            floor
            for floor in TopologicalSorter(floors[room]).static_order()
            if (ROOT / room / floor).is_dir()
        ]
        lines.append(f'  "{room}" [label=<{box(room, order)}>]')
        needed = rooms[room]
        implied = {other for between in needed for other in rooms[between]}
        lines += [f'  "{room}" -> "{other}"' for other in sorted(needed - implied)]
    return "\n".join([*lines, "}"])


def imported(file: Path) -> Iterable[tuple[str, str]]:
    """Yield room and floor of each import of ours in a file; the floor is empty for the room itself."""
    for node in ast.walk(ast.parse(file.read_bytes())):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        else:
            continue
        for name in names:
            house, *rest = name.split(".")
            if house == "dineros" and rest and rest[0] in ROOMS:
                floor = rest[1] if len(rest) > 1 else ""
                beside = ROOT / rest[0] / floor
                yield rest[0], floor if beside.is_dir() or beside.with_suffix(".py").is_file() else ""


def box(room: str, order: Sequence[str]) -> str:
    """Draw a room with its floors, the lowest at the bottom."""
    rows = "".join(
        f'<tr><td align="left" balign="left">{html.escape(floor)}</td></tr>' for floor in reversed(order)
    )
    return (
        '<table border="1" cellborder="0" cellspacing="0" cellpadding="2" bgcolor="#eceff1">'
        f'<tr><td bgcolor="#cfd8dc"><b>{room}</b></td></tr>{rows}</table>'
    )
