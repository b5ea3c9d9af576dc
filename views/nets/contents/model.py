"""The content of a picture of a net: boxes, nodes and edges, before layout.

A view is data, independent of drawing: browser pages work on `ViewModel.to_json`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import MISSING, Field, asdict, dataclass, field, fields
from typing import Any, Literal, TypeAlias

NodeKind: TypeAlias = Literal[
    "place", "transition", "place-reference", "transition-reference", "topic", "service"
]
"""Places, transitions and references to them, and the two kinds of channels."""

BoxKind: TypeAlias = Literal["node", "page", "timer", "subscriber", "server", "group"]
"""A ROS node, a page, a callback page by what calls it, or a group of elements that belong together."""

EdgeKind: TypeAlias = Literal[
    "normal",
    "read",
    "inhibitor",
    "reference",
    "publish",
    "subscribe",
    "request",
    "response",
    "call",
    "return",
]
"""Arcs, links of references to their targets, and flows of tokens through channels.

A client's request enters a service and calls its server; the server's return leaves it as a response.
"""

Change: TypeAlias = Literal["added", "removed", "changed"]
"""The kind of difference of an element in a comparison."""


@dataclass
class Caption:
    """A line of text below a node: its name, its clause."""

    text: str
    style: Literal["name", "clause", "note"] = "name"


@dataclass
class Node:
    """A place, transition, reference or channel.

    Attributes
    ----------
    id : str
        Id of the element.
    kind : NodeKind
        What it is.
    label : str
        Its name.
    box : str or None
        Id of the box that contains it.
    captions : list of Caption
        Text below it; channels show theirs inside.
    tokens : int or None
        Tokens of a place at the start.
    detail : dict of str
        More about it, for people who point at it: heading to text.
    target : str or None
        Id of what a reference stands for.
    position : tuple of float or None
        Centre, where an editor put it.
    width, height : float
        Size of its shape, without captions.
    room : tuple of float
        Width and height of the captions.
    glyph : str
        SVG of the shape and captions around the point (0, 0), without tokens.
    change, notes
        Filled in by `compare`.
    badge : str or None
        A short text in a circle next to it, such as a number a text refers to.
    """

    id: str
    kind: NodeKind
    label: str
    box: str | None = None
    captions: list[Caption] = field(default_factory=list)
    tokens: int | None = None
    detail: dict[str, str] = field(default_factory=dict)
    target: str | None = None
    position: tuple[float, float] | None = None
    width: float = 0.0
    height: float = 0.0
    room: tuple[float, float] = (0.0, 0.0)
    glyph: str = ""
    change: Change | None = None
    notes: list[str] = field(default_factory=list)
    badge: str | None = None


@dataclass
class Signal:
    """An input signal of a ROS node; `value`: its value at the start, if it has several."""

    id: str
    label: str
    initial: bool
    value: str | None = None


@dataclass
class Box:
    """A ROS node, a page or a group: holds nodes and other boxes.

    Attributes
    ----------
    id : str
        Id of the page.
    kind : BoxKind
        What it is.
    title, subtitle : str
        Its name, and its description.
    parent : str or None
        Id of the box that contains it.
    collapsed : bool
        Whether it is shown as one shape, without its content.
    signals : list of Signal
        Input signals, of a ROS node.
    states : list of str
        States of a managed ROS node; it begins in the first.
    summary : str
        What it holds, in words; shown while it is collapsed.
    header : tuple of float
        Width and height of its title.
    head : str
        SVG of the title, right and below of the point (0, 0).
    width, height : float
        Size of the shape while it is collapsed.
    glyph : str
        SVG of the text in it while it is collapsed, around the point (0, 0).
    position : tuple of float or None
        Centre, where an editor put it.
    frame : tuple of float or None
        Width and height of the frame that an editor drew around its content, in the same plane as that.
    change, notes, badge
        As those of nodes.
    """

    id: str
    kind: BoxKind
    title: str
    subtitle: str = ""
    parent: str | None = None
    collapsed: bool = False
    signals: list[Signal] = field(default_factory=list)
    states: list[str] = field(default_factory=list)
    summary: str = ""
    detail: dict[str, str] = field(default_factory=dict)
    header: tuple[float, float] = (0.0, 0.0)
    head: str = ""
    width: float = 0.0
    height: float = 0.0
    glyph: str = ""
    position: tuple[float, float] | None = None
    frame: tuple[float, float] | None = None
    change: Change | None = None
    notes: list[str] = field(default_factory=list)
    badge: str | None = None


@dataclass
class Edge:
    """A line from one node to another.

    Attributes
    ----------
    id : str
        Id of the arc; without an arc, an id made of its ends.
    source, target : str
        Ids of nodes.
    kind : EdgeKind
        What it is.
    label : str
        Weight, client or queue limit; empty if there is nothing to say.
    weight : int
        Weight of an arc.
    also : str or None
        Id of the second arc of a pair that is drawn as one read arc.
    bends : list of tuple of float
        Bend points, where an editor put them.
    """

    id: str
    source: str
    target: str
    kind: EdgeKind = "normal"
    label: str = ""
    weight: int = 1
    also: str | None = None
    bends: list[tuple[float, float]] = field(default_factory=list)
    room: tuple[float, float] = (0.0, 0.0)
    change: Change | None = None
    notes: list[str] = field(default_factory=list)


@dataclass
class ViewModel:
    """A picture's content.

    Attributes
    ----------
    id, title : str
        Of the model.
    kind : str
        ``system model``, ``runtime model``, ``Petri-net model`` or ``Petri net``.
    boxes, nodes, edges : list
        The content; boxes come after the boxes that contain them.
    compared : bool
        Whether it shows what differs between two models.
    """

    id: str
    title: str
    kind: str
    boxes: list[Box] = field(default_factory=list)
    nodes: list[Node] = field(default_factory=list)
    edges: list[Edge] = field(default_factory=list)
    compared: bool = False

    def box(self, id: str) -> Box:
        """Return the box with an id; KeyError where there is none."""
        return next((box for box in self.boxes if box.id == id), None) or _missing(id)

    def node(self, id: str) -> Node:
        """Return the node with an id; KeyError where there is none."""
        return next((node for node in self.nodes if node.id == id), None) or _missing(id)

    def elements(self) -> Iterator[Box | Node | Edge]:
        """Yield boxes, nodes and edges."""
        yield from self.boxes
        yield from self.nodes
        yield from self.edges

    def shapes(self) -> Iterator[Box | Node]:
        """Yield nodes and boxes."""
        yield from self.nodes
        yield from self.boxes

    def marking(self) -> dict[str, int]:
        """Return the tokens of every place at the start."""
        return {node.id: node.tokens for node in self.nodes if node.tokens is not None}

    def to_json(self) -> dict[str, Any]:
        """Return the view as JSON values; empty values are omitted."""
        lists = {
            "boxes": [_without_defaults(box) for box in self.boxes],
            "nodes": [_without_defaults(node) for node in self.nodes],
            "edges": [_without_defaults(edge) for edge in self.edges],
        }
        about = {"id": self.id, "title": self.title, "kind": self.kind}
        return {**about, **({"compared": True} if self.compared else {}), **lists}


def _missing(id: str) -> Any:
    raise KeyError(id)


def _without_defaults(item: Box | Node | Edge) -> dict[str, Any]:
    """Return an item's fields that differ from their defaults."""
    plain = asdict(item)
    return {
        each.name: plain[each.name]
        for each in fields(item)
        if each.name == "kind"
        or (each.default is MISSING and each.default_factory is MISSING)
        or getattr(item, each.name) != (each.default if each.default is not MISSING else _empty(each))
    }


def _empty(each: Field[Any]) -> Any:
    assert each.default_factory is not MISSING
    return each.default_factory()
