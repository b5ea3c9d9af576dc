"""What a picture of a side of a rule consists of: shapes, lines and boxes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from dineros.metamodel.base import EObject

Status: TypeAlias = Literal["kept", "created", "deleted", "matched"]
"""Status of an element: kept elements are on both sides; matched ones are in a for-all or `Absent`."""

LineKind: TypeAlias = Literal["normal", "read", "inhibitor", "flow", "link"]
"""Kinds of lines: three kinds of arcs, tokens passing ports, and links by a feature."""


@dataclass
class Shape:
    """An element, or a value, at which a line ends."""

    key: str
    eclass: type[EObject]
    name: str
    status: Status
    box: str | None = None
    inside: str = ""
    notes: list[str] = field(default_factory=list)


@dataclass
class Line:
    """An arc, or a link from one element to another by a feature."""

    source: str
    target: str
    kind: LineKind
    status: Status
    label: str = ""


@dataclass
class Box:
    """A page, a group of elements, a for-all or a forbidden pattern."""

    key: str
    title: str
    kind: Literal["page", "group", "for-all", "absent"]
    status: Status
    outer: str | None = None
