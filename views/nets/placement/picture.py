"""Nets that were laid out, as JSON values: those of `Picture` in `static/net/types.d.ts`."""

from __future__ import annotations

from typing import NotRequired, TypedDict


class PlacedShape(TypedDict):
    """A box by its left upper corner, or a node by its centre, with its size in pixels."""

    id: str
    kind: str
    x: float
    y: float
    width: float
    height: float
    label: NotRequired[str]
    title: NotRequired[str]
    box: NotRequired[str | None]
    parent: NotRequired[str | None]
    collapsed: NotRequired[bool]
    tokens: NotRequired[int]
    position: NotRequired[list[float]]
    room: NotRequired[list[float]]
    header: NotRequired[list[float]]
    glyph: NotRequired[str]
    captionAt: NotRequired[list[float]]


class PlacedEdge(TypedDict):
    """A line through points, and the middle of its label."""

    id: str
    kind: str
    source: str
    target: str
    points: list[list[float]]
    label: NotRequired[str]
    room: NotRequired[list[float]]
    labelAt: NotRequired[list[float]]
    also: NotRequired[str]
    stands: NotRequired[list[str]]


class Picture(TypedDict):
    """The visible part of a view on a plane, with its size in pixels."""

    id: str
    title: str
    kind: str
    width: float
    height: float
    boxes: list[PlacedShape]
    nodes: list[PlacedShape]
    edges: list[PlacedEdge]
