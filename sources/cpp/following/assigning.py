"""Interprets assignments in C++: what a variable, a member or an item of a list gets."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import replace
from typing import TYPE_CHECKING

from dineros.sources.cpp.declarators import is_pointer
from dineros.sources.cpp.following.expressions import Expressions, named
from dineros.sources.cpp.operations import binary
from dineros.sources.cpp.parsing import path_of, text_of
from dineros.sources.cpp.quality import CHAINED, with_member
from dineros.sources.cpp.values import (
    Const,
    Frame,
    Items,
    Lambda,
    Made,
    Method,
    Obj,
    Open,
    Value,
    is_quality,
    members_of,
    options,
)

if TYPE_CHECKING:
    from tree_sitter import Node


GIVES_PROFILE = ("get_rmw_qos_profile",)
"""The method that gives the members of a profile."""
EVENTS = {
    *("matched_callback", "deadline_callback", "liveliness_callback", "incompatible_qos_callback"),
    *("incompatible_type_callback", "message_lost_callback"),
}
"""Members of options of ports that are callbacks of events."""


class Assigning(Expressions):
    """Assigns values."""

    def _update_expression(self, node: Node, frame: Frame) -> Value:
        inner = node.child_by_field_name("argument")
        sign = text_of(node.child_by_field_name("operator"))
        made = self.operated(self.value(inner, frame), sign, [], node) if inner is not None else None
        if made is not None:
            return made
        before = frame.values.get(text_of(inner))
        is_whole = isinstance(before, Const) and type(before.value) is int
        if is_whole and not self.loops and isinstance(before, Const):
            after = Const(before.value + (1 if "++" in text_of(node) else -1))
            self.assign(inner, after, frame)
            return after if text_of(node).startswith(("++", "--")) else before
        self.assign(inner, Open(text_of(node)), frame)
        return Open(text_of(node)[:60])

    def _assignment_expression(self, node: Node, frame: Frame) -> Value:
        left = node.child_by_field_name("left")
        value = self.value(node.child_by_field_name("right"), frame)
        sign = text_of(node.child_by_field_name("operator"))
        if left is not None and self.is_object(left, frame):
            of_class = self.operated(self.value(left, frame), sign, [value], node)
            if of_class is not None:
                return of_class
        if sign != "=":
            # A loop has forgotten the local variables that it changes; of members, it may change more.
            is_known = not self.loops or text_of(left) in frame.values
            known = self.value(left, frame)
            value = binary(sign[:-1], known, value) if is_known else Open(text_of(node)[:60])
        elif left is not None and value == Const(None) and (kind := self.kind_of(left, frame)) is not None:
            self.let_go(options(self.value(left, frame)), node, kind)
        self.assign(left, value, frame)
        self.gives(node, frame)
        return value

    def is_object(self, node: Node, frame: Frame) -> bool:
        """Return whether a variable or a member is an object of a class of the folder, and no pointer."""
        kind = self.kind_of(node, frame)
        return (
            kind is not None
            and not is_pointer(kind.parent)
            and self.class_of(self.type_text(kind, frame), frame) is not None
        )

    def kind_of(self, node: Node | None, frame: Frame) -> Node | None:
        """Return the type with which a variable or a member is declared; None: not known."""
        raise NotImplementedError

    def gives(self, node: Node, frame: Frame) -> None:
        """Record that the callback of a service assigns a field of its response."""
        raise NotImplementedError

    def assign(self, left: Node | None, value: Value, frame: Frame) -> None:
        """Assign a value to the left side of ``=``."""
        if left is None:
            return
        if isinstance(value, Items) and not value.of and left.type in ("identifier", "field_expression"):
            value = _as_before(self.value(left, frame), value)
        if left.type == "identifier":
            self.store(text_of(left), value, frame)
        elif left.type == "field_expression":
            name = path_of(left.child_by_field_name("field"))
            holder = left.child_by_field_name("argument")
            if name in EVENTS and isinstance(value, (Lambda, Method)):
                self.event(left, value, frame)
                return
            on = self.value(holder, frame)
            if isinstance(on, Made) and is_quality(on):  # a copy of it does not change
                self.assign(changed_by(holder, GIVES_PROFILE), with_member(on, name, value), frame)
                return
            for each in options(on):
                if isinstance(each, Obj):
                    self.store_field(each, name, value)
                elif isinstance(each, Made):
                    self.set_member(each, name, value)
        elif left.type == "subscript_expression":
            on = self.value(left.child_by_field_name("argument"), frame)
            if isinstance(on, Items):
                on.values.append(value)
                on.is_open = on.is_open or isinstance(value, Open)
        elif left.type == "call_expression" and path_of(left.child_by_field_name("function")) == "std::tie":
            parts = members_of(value)
            for number, given in enumerate(named(left.child_by_field_name("arguments"))):
                self.assign(given, parts[number] if number < len(parts) else Open(text_of(given)), frame)
        elif left.type in ("pointer_expression", "parenthesized_expression"):
            self.assign(left.child_by_field_name("argument") or next(iter(named(left)), None), value, frame)

    def event(self, node: Node, target: Value, frame: Frame) -> None:
        """Read the callback of an event of a port."""
        raise NotImplementedError

    def change(self, node: Node, value: Value, frame: Frame) -> None:
        """Set the object that a chained call changes, as in ``qos.keep_last(5).reliable()``."""
        self.assign(changed_by(node, CHAINED), value, frame)


def _as_before(old: Value, new: Items) -> Items:
    """Return a list in braces that a variable gets, with the type of the variable's items."""
    before = next((each for each in options(old) if isinstance(each, Items)), None)
    if before is None:
        return new
    return replace(new, kind=before.kind, of=before.of, is_map=before.is_map)


def changed_by(node: Node | None, methods: Container[str]) -> Node | None:
    """Return what calls of methods that return their object begin with."""
    while node is not None and node.type == "call_expression":
        method = node.child_by_field_name("function")
        is_chained = method is not None and method.type == "field_expression"
        if not is_chained or path_of(method.child_by_field_name("field")) not in methods:  # type: ignore[union-attr]
            return None
        node = method.child_by_field_name("argument")  # type: ignore[union-attr]
    return node
