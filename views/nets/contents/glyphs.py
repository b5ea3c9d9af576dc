"""Shapes of nodes and collapsed boxes: their size and their SVG, around the point (0, 0).

Tokens are not part of a glyph, since they change: `static/net/renderer.js` draws them.
"""

from __future__ import annotations

from html import escape

from dineros.views.nets.contents.measures import text_width, wrap
from dineros.views.nets.contents.model import Box, Caption, Node

PLACE_RADIUS = 13
TRANSITION = (10, 32)
NAME_SIZE, SMALL_SIZE, TITLE_SIZE = 11, 9, 12
LINE = {"name": 13, "clause": 11, "note": 11}
CAPTION_GAP = 3
_SIZES = {"name": NAME_SIZE, "clause": SMALL_SIZE, "note": SMALL_SIZE}
_WRAP = {"name": 20, "clause": 26, "note": 26}
_CHANNEL_HEIGHT, _CHANNEL_PADDING = 38, 16


def finish_node(node: Node) -> None:
    """Set a node's size and glyph."""
    if node.kind in ("topic", "service"):
        _channel(node)
        return
    if node.kind in ("place", "place-reference"):
        node.width = node.height = 2 * PLACE_RADIUS
        shape = f'<circle class="shape" r="{PLACE_RADIUS}"/>'
    else:
        node.width, node.height = TRANSITION
        shape = (
            f'<rect class="shape" x="{-node.width / 2:g}" y="{-node.height / 2:g}" '
            f'width="{node.width:g}" height="{node.height:g}" rx="1"/>'
        )
    text, node.room = _captions(node.captions, node.height / 2)
    node.glyph = shape + text


def finish_box(box: Box) -> None:
    """Set a box's title, and its size and text in the collapsed state."""
    title, subtitle = text_width(box.title, TITLE_SIZE, bold=True), text_width(box.subtitle, SMALL_SIZE)
    box.head = f'<text class="title" x="9" y="17">{escape(box.title)}</text>'
    height = 24
    if box.subtitle:
        box.head += f'<text class="subtitle" x="9" y="29">{escape(box.subtitle)}</text>'
        height = 34
    signals, x = "", 9.0
    for signal in box.signals:
        name, shown = escape(signal.label), signal.label
        if signal.value is not None:
            name = f'{name} = <tspan class="value">{escape(signal.value)}</tspan>'
            shown = f"{shown} = {signal.value}"
        signals += (
            f'<g class="signal{" true" if signal.initial else ""}" data-id="{escape(signal.id)}">'
            f'<circle class="lamp" cx="{x + 4:g}" cy="{height + 6}" r="4"/>'
            f'<text x="{x + 12:g}" y="{height + 9}">{name}</text></g>'
        )
        x = round(x + text_width(shown, SMALL_SIZE, bold=True) + 26, 1)
    box.head += signals
    height += 18 if signals else 0
    if box.states:
        states, wide = _states(box, height)
        box.head += states
        x, height = max(x, wide), height + 20
    box.header = (round(max(title + 40, subtitle + 18, x), 1), height)
    lines = [("title", box.title), ("subtitle", box.subtitle), ("subtitle", box.summary)]
    lines = [(style, text) for style, text in lines if text]
    box.width = round(max(title + 24, subtitle, text_width(box.summary, SMALL_SIZE)) + 24, 1)
    box.height = 16 + 13 * len(lines)
    box.glyph = "".join(
        f'<text class="{style}" y="{13 * index - 6.5 * len(lines) + 10:g}">{escape(text)}</text>'
        for index, (style, text) in enumerate(lines)
    )


def _states(box: Box, top: float) -> tuple[str, float]:
    """Draw the states of a managed node with the current one highlighted; also return the width."""
    drawn, x = "", 9.0
    for number, state in enumerate(box.states):
        wide = round(text_width(state, SMALL_SIZE, bold=True) + 8, 1)
        drawn += (
            f'<g class="state{"" if number else " now"}"><rect x="{x:g}" y="{top:g}" width="{wide:g}" '
            f'height="14" rx="3"/><text x="{x + wide / 2:g}" y="{top + 10:g}">{escape(state)}</text></g>'
        )
        x = round(x + wide + 3, 1)
    return f'<g class="life">{drawn}</g>', x + 9


def finish_edge_label(label: str) -> tuple[float, float]:
    """Return the room a label of an edge needs."""
    return (text_width(label, SMALL_SIZE) + 6, 12.0) if label else (0.0, 0.0)


def _captions(captions: list[Caption], top: float) -> tuple[str, tuple[float, float]]:
    parts: list[str] = []
    width, y = 0.0, top + CAPTION_GAP
    for caption in captions:
        for line in wrap(caption.text, _WRAP[caption.style]):
            y += LINE[caption.style]
            width = max(width, text_width(line, _SIZES[caption.style]))
            parts.append(f'<text class="{caption.style}" y="{y - 3:g}">{escape(line)}</text>')
    return "".join(parts), (round(width + 6, 1), round(y - top, 1))


def _channel(node: Node) -> None:
    """Draw a channel: topics have round ends, services pointed ones."""
    lines = [(node.label, "name", NAME_SIZE, True)]
    lines += [(caption.text, "note", SMALL_SIZE, False) for caption in node.captions]
    inner = max(text_width(text, size, bold=bold) for text, _, size, bold in lines)
    node.height = _CHANNEL_HEIGHT
    node.width = round(inner + 2 * _CHANNEL_PADDING + 4)
    half, up = node.width / 2, node.height / 2
    if node.kind == "topic":
        shape = (
            f'<rect class="shape" x="{-half:g}" y="{-up:g}" width="{node.width:g}" '
            f'height="{node.height:g}" rx="{up:g}"/>'
        )
    else:
        end = half - 12
        corners = ((-half, 0), (-end, -up), (end, -up), (half, 0), (end, up), (-end, up))
        points = " ".join(f"{x:g},{y:g}" for x, y in corners)
        shape = f'<polygon class="shape" points="{points}"/>'
    y = -2 if len(lines) > 1 else 4
    text = ""
    for line, style, _, _ in lines:
        text += f'<text class="{style}" y="{y:g}">{escape(line)}</text>'
        y += 13
    node.glyph = shape + text
