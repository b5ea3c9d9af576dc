"""The entries of the index of C++: routines and classes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from dineros.sources.cpp.declarators import Parameter

if TYPE_CHECKING:
    from tree_sitter import Node


@dataclass(eq=False)
class Routine:
    """A function with a body: a method if `cls` is given."""

    name: str
    node: Node
    path: str
    space: str
    cls: ClassInfo | None = None
    parameters: list[Parameter] = field(default_factory=list)
    templates: list[str] = field(default_factory=list)

    @property
    def body(self) -> Node | None:
        """Its body; None: it is defaulted or deleted."""
        return self.node.child_by_field_name("body")

    @property
    def line(self) -> int:
        """Where it begins."""
        return int(self.node.start_point[0]) + 1


@dataclass(eq=False)
class ClassInfo:
    """A class or struct."""

    name: str
    space: str
    """`name`, `space`: its name, and the namespaces and classes around it."""
    path: str
    node: Node
    bases: list[Node] = field(default_factory=list)
    """Names of its base classes, as nodes."""
    methods: dict[str, list[Routine]] = field(default_factory=dict)
    """Routines by name."""
    fields: dict[str, tuple[Node | None, Node | None]] = field(default_factory=dict)
    """Type and default by name."""
    pointers: set[str] = field(default_factory=set)
    """Members that only point at an object, or refer to one."""
    arrays: set[str] = field(default_factory=set)
    """Members that are arrays."""
    defaults: dict[str, list[list[Parameter]]] = field(default_factory=dict)
    """Parameters of declarations, by name of the method."""
    templates: list[str] = field(default_factory=list)

    @property
    def full(self) -> str:
        """Its name with namespaces."""
        return f"{self.space}::{self.name}" if self.space else self.name
