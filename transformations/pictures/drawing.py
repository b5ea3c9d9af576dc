"""Draws both sides of a rule next to each other, in the notation of the paper (Sect. 5.5).

Places are circles with their tokens inside, transitions are bars. Inhibitor arcs end in a circle, read arcs
have two heads. As in pictures of nets, topics are blue and round, services green and pointed; signals are
yellow. Arcs run behind names. An underlined element on the left is the same as the underlined element with
the same label on the right; elements made by the rule are orange and bold.
"""

from __future__ import annotations

import html
import re
import subprocess
import textwrap
from pathlib import Path

import networkx as nx

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.constraints.wording import words_for
from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.files.atomic import write_atomically
from dineros.transformations.language.rule import Rule
from dineros.transformations.pictures.diagram import Side
from dineros.transformations.pictures.shapes import Box, Line, Shape
from dineros.transformations.rules.catalogue import name_of, summary_of

FORMATS = (".svg", ".png", ".dot")
"""File suffixes of pictures; ``.dot`` is Graphviz's own language."""

KEPT, CREATED, DELETED, QUIET = "#222222", "#c2410c", "#b91c1c", "#64748b"
COLOURS = {"kept": KEPT, "matched": KEPT, "created": CREATED, "deleted": DELETED}
STYLES = {"kept": "solid", "matched": "solid", "created": "bold", "deleted": "dashed"}

_HEAD = """digraph {
  graph [rankdir=LR, bgcolor=white, outputorder=edgesfirst, color="#cbd5e1", nodesep=0.25, ranksep=0.35,
         fontname="Helvetica,Arial,sans-serif", fontsize=12, pad=0.15, newrank=true]
  node [fontname="Helvetica,Arial,sans-serif", fontsize=11, color="#222222"]
  edge [fontname="Helvetica,Arial,sans-serif", fontsize=10, color="#222222", arrowsize=0.7]
"""
_INVISIBLE = 'label="", peripheries=0'
_LEGEND = (
    "underlined: the same element on both sides &#160; <FONT COLOR='{0}'><B>bold</B></FONT>: made by the rule"
)
LETTER = 7  # approximate width of a letter
NAME_HEIGHT = 20  # includes the subscript
_ABOUT = 46  # approximate number of characters on a line of notes


def draw_rule(rule: type[Rule], path: Path | str) -> None:
    """Draw a rule into a file, in the format of its suffix.

    `path`: a file ending in ``.svg``, ``.png`` or ``.dot``.

    Raises
    ------
    DinerosError
        The format is unknown, Graphviz is missing, or the file cannot be written.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise DinerosError(
            f"{suffix!r} is not a format of pictures" if suffix else "has no suffix",
            location=Location(path),
            hint=f"known are {', '.join(FORMATS)}",
        )
    source = rule_dot(rule)
    write_atomically(path, source.encode() if suffix == ".dot" else layout(source, suffix[1:]))


def rule_svg(rule: type[Rule]) -> str:
    """Return the picture of a rule as SVG.

    Raises
    ------
    DinerosError
        Graphviz is missing.
    """
    return layout(rule_dot(rule), "svg").decode()


def layout(source: str, format: str) -> bytes:
    """Lay a graph out with Graphviz.

    Raises
    ------
    DinerosError
        Graphviz is missing or refuses the graph.
    """
    try:
        run = subprocess.run(["dot", f"-T{format}"], input=source.encode(), capture_output=True, check=True)
    except FileNotFoundError as error:
        raise DinerosError(
            "pictures need Graphviz, and there is no command 'dot'", hint="install the package graphviz"
        ) from error
    except subprocess.CalledProcessError as error:
        raise DinerosError(f"Graphviz failed: {error.stderr.decode(errors='replace')}") from error
    return run.stdout


def rule_dot(rule: type[Rule]) -> str:
    """Return the picture of a rule in Graphviz's language; equal rules have equal text."""
    what = summary_of(rule)
    title = f"<B>{html.escape(name_of(rule))}</B>" + (f" &#160; {html.escape(what)}" if what else "")
    lines = [
        _HEAD,
        f'  graph [labelloc=t, label=<<FONT POINT-SIZE="14">{title}</FONT><BR/>'
        f'<FONT POINT-SIZE="9" COLOR="{QUIET}">{_LEGEND.format(CREATED)}</FONT>>]',
    ]
    left, right = Side(rule, left=True), Side(rule, left=False)
    lines += [*_side("L", "LHS", left), *_side("R", "RHS", right)]
    lines.append('  between [shape=plain, label=<<FONT POINT-SIZE="24">⇒</FONT>>]')
    lines += [f'  "L {key}" -> between [style=invis]' for key in _last(left)]
    lines += [f'  between -> "R {key}" [style=invis, weight=0]' for key in _first(right)]
    return "\n".join([*lines, "}", ""])


def _forward(side: Side) -> list[tuple[Line, bool]]:
    """Return the lines of a side, each with a flag whether it is laid out backwards.

    In a cycle, the distance from its entry decides: then both paths run from left to right.
    """
    graph: nx.DiGraph[str] = nx.DiGraph()
    graph.add_nodes_from(side.shapes)
    graph.add_edges_from((line.source, line.target) for line in side.lines)
    backwards: set[tuple[str, str]] = set()
    for circle in nx.strongly_connected_components(graph):
        if len(circle) > 1:
            entries = [
                line.target for line in side.lines if line.target in circle and line.source not in circle
            ]
            start = next(iter(entries), None) or next(key for key in side.shapes if key in circle)
            inner = graph.subgraph(circle)
            distance = nx.single_source_shortest_path_length(inner.to_undirected(), start)
            backwards |= {(one, other) for one, other in inner.edges if distance[other] < distance[one]}
    return [(line, (line.source, line.target) in backwards) for line in side.lines]


def _first(side: Side) -> list[str]:
    later = {line.source if back else line.target for line, back in _forward(side)}
    later |= {second for _, second in _columns(side)}
    return [key for key in side.shapes if key not in later]


def _last(side: Side) -> list[str]:
    earlier = {line.target if back else line.source for line, back in _forward(side)}
    earlier |= {first for first, _ in _columns(side)}
    return [key for key in side.shapes if key not in earlier]


def _columns(side: Side) -> list[tuple[str, str]]:
    """Return pairs of unconnected shapes, to be put next to each other."""
    joined = {end for line in side.lines for end in (line.source, line.target)}
    rows: dict[str | None, list[str]] = {}
    for shape in side.shapes.values():
        if shape.key not in joined:
            rows.setdefault(shape.box, []).append(shape.key)
    return [(row[i], row[i + 1]) for row in rows.values() for i in range(len(row) - 1) if i % 3 < 2]


def _side(name: str, heading: str, side: Side) -> list[str]:
    notes = [part for note in side.notes for part in textwrap.wrap(note, _ABOUT, subsequent_indent="   ")]
    text = "".join(f'{html.escape(note)}<BR ALIGN="LEFT"/>' for note in notes)
    lines = [
        f"  subgraph cluster_{name} {{",
        f"    graph [label=<<B>{heading}</B>>, labeljust=l, labelloc=t, style=rounded, margin=10]",
        f"    subgraph cluster_{name}_notes {{",
        f'      graph [label=<<FONT POINT-SIZE="10">{text}</FONT>>, labelloc=b, labeljust=l, '
        "peripheries=0, margin=4]"
        if text
        else f"      graph [{_INVISIBLE}, margin=0]",
    ]
    lines += _contents(name, side, None)
    lines += ["    }", "  }"]
    lines += [_line(name, side, line, back) for line, back in _forward(side)]
    return lines + [f'  "{name} {one}" -> "{name} {other}" [style=invis]' for one, other in _columns(side)]


def _contents(name: str, side: Side, box: str | None) -> list[str]:
    lines = [_shape(name, shape) for shape in side.shapes.values() if shape.box == box]
    for inner in side.boxes.values():
        if inner.outer == box:
            # The invisible box around it separates it from its neighbours.
            lines += [f'      subgraph "cluster_{name}_around {inner.key}" {{ graph [{_INVISIBLE}, margin=4]']
            lines += [f'      subgraph "cluster_{name}_{inner.key}" {{', f"        {_box(inner)}"]
            lines += [*_contents(name, side, inner.key), "      }}"]
    return lines


def _box(box: Box) -> str:
    colour = COLOURS[box.status]
    style, colour = {
        "page": ("rounded,bold" if box.status == "created" else "rounded", colour),
        "group": ("dotted,bold" if box.status == "created" else "dotted", colour),
        "for-all": ("dashed", QUIET),
        "absent": ("dashed", DELETED),
    }[box.kind]
    title = html.escape(box.title)
    shown = _underlined(title, box.status) if box.kind in ("page", "group") else title
    return (
        f'graph [label=<<FONT POINT-SIZE="10" COLOR="{colour}">{shown}</FONT>>, labelloc=t, labeljust=l, '
        f'style="{style}", color="{colour}", margin=8, peripheries=1]'
    )


def _underlined(text: str, status: str) -> str:
    return f"<U>{text}</U>" if status == "kept" else text


def _line(name: str, side: Side, line: Line, back: bool) -> str:
    colour = COLOURS[line.status]
    attributes = [f'color="{colour}"', f'fontcolor="{colour}"', f"style={STYLES[line.status]}"]
    if line.label:
        attributes.append(f'label=" {line.label} "')
    source, target = (_end(name, side.shapes[end]) for end in (line.source, line.target))
    head = {"inhibitor": "odot", "flow": "vee", "link": "none"}.get(line.kind, "normal")
    tail = "normal" if line.kind == "read" else "none"
    if line.kind in ("flow", "link"):
        attributes = [f'color="{QUIET}"', f'fontcolor="{QUIET}"', *attributes[3:]]
    if back:
        source, target, head, tail = target, source, tail, head
    attributes += ["dir=both", f"arrowhead={head}", f"arrowtail={tail}"]
    return f"  {source} -> {target} [{', '.join(attributes)}]"


def _end(name: str, shape: Shape) -> str:
    port = ":bar" if _form(shape.eclass) == "transition" else ""
    return f'"{name} {shape.key}"{port}'


def _shape(side: str, shape: Shape) -> str:
    colour, bold = COLOURS[shape.status], shape.status == "created"
    width = 2.4 if bold else 1
    common = [f'color="{colour}"', f'fontcolor="{colour}"', f"penwidth={width}"]
    style = "dashed" if shape.status == "deleted" else "filled"
    form = _form(shape.eclass)
    if form == "place":
        common += ["shape=circle", "width=0.5", "height=0.5", "fixedsize=shape", f"style={style}"]
        common += ["fillcolor=white", f"label=<{_around(shape, 'P', 40)}>"]
    elif form == "transition":
        common += ["shape=plain", f"label=<{_bar(shape, colour, 7 if bold else 5)}>"]
    elif form == "port":
        fill = "#bfdbfe" if issubclass(shape.eclass, sym.TopicPort) else "#bbf7d0"
        common += ["shape=square", "width=0.18", "height=0.18", "fixedsize=shape", f"style={style}"]
        common += [f'fillcolor="{fill}"', f"label=<{_around(shape, '', 16)}>"]
    else:
        fill = {"topic": "#bfdbfe", "service": "#bbf7d0", "signal": "#fef9c3"}.get(form, "white")
        border = {"topic": "#1d4ed8", "service": "#15803d"}.get(form)
        if border and shape.status == "kept":
            common[0] = f'color="{border}"'
        rounded = ",rounded" if form in ("topic", "element") else ""
        form = {"service": "hexagon"}.get(form, "box")
        common += [f"shape={form}", f'style="{style}{rounded}"', f'fillcolor="{fill}"', "margin=0.08"]
        common.append(f"label=<{_inside(shape)}>")
    return f'      "{side} {shape.key}" [{", ".join(common)}]'


def _form(eclass: type[EObject]) -> str:
    for kind, form in (
        (pn.PlaceNode, "place"),
        (pn.TransitionNode, "transition"),
        (sym.TopicChannel, "topic"),
        (sym.ServiceChannel, "service"),
        (sym.ActionChannel, "service"),
        (sym.TopicPort, "port"),
        (sym.ClientPort, "port"),
        (sym.ServerPort, "port"),
        (sym.ActionClientPort, "port"),
        (sym.ActionServerPort, "port"),
        (sym.InputSignal, "signal"),
    ):
        if issubclass(eclass, kind):
            return form
    return "element"


def _around(shape: Shape, letter: str, height: int) -> str:
    """Return the label of a small shape: tokens in the middle, name and notes below, space above."""
    notes = [*([] if letter else [words_for(shape.eclass)]), *shape.notes]
    inside = html.escape(shape.inside) or "&#160;"
    middle = f'<TR><TD HEIGHT="{height}" FIXEDSIZE="TRUE" WIDTH="{height}">{inside}</TD></TR>'
    return _table(
        _blank(1 + len(notes)) + middle + _row(_before(_name(shape, letter)), 1, NAME_HEIGHT) + _notes(notes)
    )


def _bar(shape: Shape, colour: str, width: int) -> str:
    """Return the label of a transition: its bar is a separate cell, at which arcs end."""
    bar = f'<TD PORT="bar" BGCOLOR="{colour}" FIXEDSIZE="TRUE" WIDTH="{width}" HEIGHT="36"></TD>'
    below = _row(_before(_name(shape, "T")), 3, NAME_HEIGHT) + _notes(shape.notes, 3)
    return _table(f"{_blank(1 + len(shape.notes), 3)}<TR><TD></TD>{bar}<TD></TD></TR>{below}")


def _inside(shape: Shape) -> str:
    stereotype = [f"«{words_for(shape.eclass)}»"] if shape.eclass is not EObject else []
    return _table(_notes(stereotype) + _row(_name(shape, "")) + _notes(shape.notes))


def _table(rows: str) -> str:
    return f'<TABLE BORDER="0" CELLBORDER="0" CELLSPACING="0" CELLPADDING="0">{rows}</TABLE>'


def _row(text: str, columns: int = 1, height: int = 0) -> str:
    return f'<TR><TD COLSPAN="{columns}" HEIGHT="{height}">{text}</TD></TR>'


def _notes(notes: list[str], columns: int = 1) -> str:
    return "".join(
        _row(f'<FONT POINT-SIZE="9" COLOR="{QUIET}">{html.escape(note)}</FONT>', columns) for note in notes
    )


def _before(name: str) -> str:
    """Return a name in front of arcs: on white, no wider than the name."""
    letters = len(html.unescape(re.sub("<[^>]*>", "", name)))
    size = f'FIXEDSIZE="TRUE" WIDTH="{LETTER * letters + 4}" HEIGHT="{NAME_HEIGHT - 4}"'
    return (
        '<TABLE BORDER="0" CELLBORDER="0" CELLPADDING="0" CELLSPACING="0">'
        f'<TR><TD></TD><TD BGCOLOR="white" {size}>{name}</TD><TD></TD></TR></TABLE>'
    )


def _blank(rows: int, columns: int = 1) -> str:
    """Return empty rows, as high as a name and its notes, that keep the middle of a shape in the middle."""
    return _row("&#160;", columns, NAME_HEIGHT) + _notes(["\N{NO-BREAK SPACE}"] * (rows - 1), columns)


def _name(shape: Shape, letter: str) -> str:
    """Return a name in the notation of the paper: ``P`` with a subscript."""
    if letter:
        stem = re.sub(r"^[tp]_", "", shape.name)
        stem = re.sub(r"_(\w)", lambda found: found[1].upper(), stem)
        name = f"<I>{letter}</I><SUB>{html.escape(stem)}</SUB>"
    else:
        name = html.escape(shape.name)
    return _underlined(name, shape.status)
