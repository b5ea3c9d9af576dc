"""Positioned nets as SVG. `static/net/renderer.js` makes the same markup in browsers: a test compares."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from html import escape
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args

from dineros.views.pages import own_text

Point: TypeAlias = Sequence[float]
if TYPE_CHECKING:
    from dineros.views.nets.drawing.paper import Paper

Theme: TypeAlias = Literal["light", "dark"]
THEMES: tuple[Theme, ...] = get_args(Theme)

_STILL = ".net .fold{display:none}.net .collapsed .fold{display:inline}"  # nothing collapses on a click here
_SIGNS = {"added": "+", "removed": "−", "changed": "≠"}
_DOTS: tuple[tuple[tuple[float, float], ...], ...] = (
    (),
    ((0, 0),),
    ((-4.5, 0), (4.5, 0)),
    ((0, -4.5), (-4.5, 4), (4.5, 4)),
    ((-4.5, -4.5), (4.5, -4.5), (-4.5, 4.5), (4.5, 4.5)),
)


def to_svg(
    positioned: Mapping[str, Any],
    *,
    marking: Mapping[str, int] | None = None,
    signals: Mapping[str, bool] | None = None,
    highlights: Iterable[str] = (),
    theme: Theme = "light",
    paper: Paper | None = None,
) -> str:
    """Return the picture of a positioned net as a complete SVG file.

    Parameters
    ----------
    positioned : mapping
        What `dineros.views.nets.layout` returns.
    marking : mapping of str to int, optional
        Tokens by id of place; places that are not named show their initial ones.
    signals : mapping of str to bool, optional
        Values by id of signal; the others show their initial ones.
    highlights : iterable of str
        Ids of elements to point out.
    theme : {"light", "dark"}
        Dark lines on white, or light ones on black.
    paper : Paper, optional
        The size it has in print; pixels otherwise.
    """
    width, height = _number(positioned["width"]), _number(positioned["height"])
    box, around = f"0 0 {width} {height}", ""
    if paper is not None:
        area = paper.area(positioned)
        x, y, wide, high = map(_number, area)
        box, around = (
            f"{x} {y} {wide} {high}",
            f'<rect class="paper" x="{x}" y="{y}" width="{wide}" height="{high}"/>',
        )
        width, height = f"{paper.width:g}mm", f"{paper.width * area[3] / area[2]:.6g}mm"
    body = markup(positioned, marking or {})
    for id, value in (signals or {}).items():
        body = _with_class(body, "signal", id, "true", value)
    for id in highlights:
        body = _with_class(body, r"[^\"]*?", _shown(positioned, id), "marked", True)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="net net-{theme}" width="{width}" height="{height}" '
        f'viewBox="{box}" role="img">'
        f"<title>{escape(positioned['title'])}</title><style>{stylesheet(theme)}</style>{around}{body}</svg>\n"
    )


def _with_class(body: str, pattern: str, id: str, name: str, wanted: bool) -> str:
    """Give the group of an element, whose classes match a pattern, one more class, or take it away."""
    return re.sub(
        rf'<g class="({pattern})(?: {name})?" data-id="{re.escape(escape(id))}"',
        lambda found: f'<g class="{found[1]}{f" {name}" if wanted else ""}" data-id="{escape(id)}"',
        body,
    )


def _shown(positioned: Mapping[str, Any], id: str) -> str:
    """Return the id of the edge that an arc is drawn by, or the id itself."""
    for item in positioned["edges"]:
        if id == item.get("also") or id in item.get("stands", ()):
            return str(item["id"])
    return id


@cache
def stylesheet(theme: Theme) -> str:
    """Return the style of a theme, without variables: not every program that shows SVG knows them."""
    text = re.sub(r"/\*.*?\*/", "", own_text("static/net/net.css"), flags=re.DOTALL)
    themes = re.findall(r"[^{}]*\{\s*--net-[^}]*\}", text)  # light, then what differs in dark
    values: dict[str, str] = {}
    for block in themes[: 2 if theme == "dark" else 1]:
        values |= dict(re.findall(r"(--net-[\w-]+):\s*([^;]+);", block))
    for block in themes:
        text = text.replace(block, "")
    text = re.sub(r"var\((--net-[\w-]+)\)", lambda found: values[found[1]], text)
    # In a page with both, each style is for its own picture.
    return re.sub(r"\s*\n\s*", "", f"{text}{_STILL}".replace(".net ", f".net-{theme} "))


def markup(positioned: Mapping[str, Any], marking: Mapping[str, int]) -> str:
    """Return what stands inside the SVG element."""
    boxes, nodes, edges = positioned["boxes"], positioned["nodes"], positioned["edges"]
    width, height = _number(positioned["width"]), _number(positioned["height"])
    parts = [
        f'<rect class="paper" width="{width}" height="{height}"/>',
        *map(_box, boxes),
        *map(_edge, edges),
        *(_node(item, marking) for item in nodes),
        *(_signs(item, item["x"] + item["width"] - 30, item["y"] + 1) for item in boxes),
        *(
            _signs(item, item["x"] - item["width"] / 2 - 4, item["y"] - item["height"] / 2 - 2)
            for item in nodes
        ),
        *(_signs(item, *_beside(item)) for item in edges if item.get("change") and len(item["points"]) > 1),
    ]
    return "".join(parts)


def _number(value: float) -> str:
    """Write a number with at most one decimal, as JavaScript does."""
    rounded = math.floor(value * 10 + 0.5) / 10
    return str(int(rounded)) if rounded == int(rounded) else str(rounded)


def _tokens(count: int) -> str:
    if count < len(_DOTS):
        return "".join(f'<circle cx="{x:g}" cy="{y:g}" r="3.2"/>' for x, y in _DOTS[count])
    text = str(count)
    size = 12 if len(text) < 3 else 10 if len(text) < 4 else 7
    return f'<text y="{_number(size * 0.36)}" style="font-size:{size}px">{text}</text>'


def _named(classes: str, item: Mapping[str, Any]) -> str:
    change = f" {item['change']}" if item.get("change") else ""
    return f'<g class="{classes}{change}" data-id="{escape(item["id"])}">'


def _signs(item: Mapping[str, Any], x: float, y: float) -> str:
    drawn = ""
    change = item.get("change")
    if change:
        drawn += (
            f'<g class="change {change}" transform="translate({_number(x)},{_number(y)})">'
            f'<circle r="7"/><text y="4">{_SIGNS[change]}</text></g>'
        )
        x -= 18
    if item.get("badge"):
        drawn += (
            f'<g class="badge" transform="translate({_number(x)},{_number(y)})">'
            f'<circle r="9"/><text y="3.5">{escape(item["badge"])}</text></g>'
        )
    return drawn


def _box(item: Mapping[str, Any]) -> str:
    x, y, width, height = (item[name] for name in ("x", "y", "width", "height"))
    right = x + width
    corner = 8 if item["kind"] == "node" else 4
    collapsed = item.get("collapsed")

    def rectangle(name: str, by: int) -> str:
        return (
            f'<rect class="{name}" x="{_number(x - by)}" y="{_number(y - by)}" '
            f'width="{_number(width + 2 * by)}" height="{_number(height + 2 * by)}" rx="{corner + by}"/>'
        )

    knob = (
        f'<g class="fold"><rect class="knob" x="{_number(right - 18)}" y="{_number(y + 6)}" '
        f'width="12" height="12" rx="2"/><line x1="{_number(right - 15)}" y1="{_number(y + 12)}" '
        f'x2="{_number(right - 9)}" y2="{_number(y + 12)}"/>'
    )
    if collapsed:
        knob += (
            f'<line x1="{_number(right - 12)}" y1="{_number(y + 9)}" x2="{_number(right - 12)}" '
            f'y2="{_number(y + 15)}"/>'
        )
        middle = f"{_number(x + width / 2)},{_number(y + height / 2)}"
        text = f'<g transform="translate({middle})">{item["glyph"]}</g>'
    else:
        text = f'<g transform="translate({_number(x)},{_number(y)})">{item["head"]}</g>'
    classes = f"box {item['kind']}{' collapsed' if collapsed else ''}"
    return f"{_named(classes, item)}{rectangle('frame', 0)}{rectangle('halo', 4)}{knob}</g>{text}</g>"


def _node(item: Mapping[str, Any], marking: Mapping[str, int]) -> str:
    content = ""
    if item["kind"].startswith("place"):
        count = marking.get(item.get("target", item["id"]), item.get("tokens", 0))
        content = f'<g class="tokens">{_tokens(count)}</g>'
    wide, high = item["width"] / 2 + 4, item["height"] / 2 + 4
    halo = (
        f'<rect class="halo" x="{_number(-wide)}" y="{_number(-high)}" '
        f'width="{_number(2 * wide)}" height="{_number(2 * high)}" rx="6"/>'
    )
    return (
        f'<g transform="translate({_number(item["x"])},{_number(item["y"])})">'
        f"{_named(item['kind'], item)}{item['glyph']}{halo}{content}</g></g>"
    )


def _head(points: Sequence[Point], shape: str) -> str:
    """Draw the arrow head, or the ring of an inhibitor arc, at the end of a line."""
    (from_x, from_y), (x, y) = points[-2], points[-1]
    length = math.hypot(x - from_x, y - from_y) or 1
    dx, dy = (x - from_x) / length, (y - from_y) / length
    if shape == "ring":
        return f'<circle class="ring" cx="{_number(x - 4 * dx)}" cy="{_number(y - 4 * dy)}" r="4"/>'
    corners = " ".join(
        f"{_number(x - 8 * dx - side * dy)},{_number(y - 8 * dy + side * dx)}" for side in (3.4, -3.4)
    )
    return f'<polygon class="head" points="{_number(x)},{_number(y)} {corners}"/>'


def _edge(item: Mapping[str, Any]) -> str:
    points = item["points"]
    if len(points) < 2:
        return ""
    line = "".join(f"{'L' if index else 'M'}{_number(x)} {_number(y)}" for index, (x, y) in enumerate(points))
    drawn = f'{_named("edge " + item["kind"], item)}<path d="{line}"/>'
    if item["kind"] != "reference":
        drawn += _head(points, "ring" if item["kind"] == "inhibitor" else "arrow")
    if item["kind"] == "read":
        drawn += _head([points[1], points[0]], "arrow")
    if item.get("label") and item.get("labelAt"):
        x, y = item["labelAt"]
        drawn += f'<text x="{_number(x)}" y="{_number(y + 3)}">{escape(item["label"])}</text>'
    return drawn + "</g>"


def _beside(edge: Mapping[str, Any]) -> tuple[float, float]:
    """Return where the sign of a line stands: left of its label, or on it."""
    if edge.get("label") and edge.get("labelAt"):
        return edge["labelAt"][0] - edge["room"][0] / 2 - 8, edge["labelAt"][1]
    return _middle(edge["points"])


def _middle(points: Sequence[Point]) -> tuple[float, float]:
    """Return the middle of the longest piece of a line."""
    best, at = 0.0, (points[0][0], points[0][1])
    for (x, y), (next_x, next_y) in itertools.pairwise(points):
        length = abs(next_x - x) + abs(next_y - y)
        if length > best:
            best, at = length, ((x + next_x) / 2, (y + next_y) / 2)
    return at
