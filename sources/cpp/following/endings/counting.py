"""Counts the iterations of loops over numbers: ``for (int i = 0; i < 10; ++i)``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from dineros.sources.cpp.parsing import nodes_in, text_of
from dineros.sources.cpp.values import Const, Value

if TYPE_CHECKING:
    from tree_sitter import Node

_PLAIN = ("number_literal", "identifier", "qualified_identifier", "field_expression")
"""Bounds whose evaluation does nothing else."""


def of_bound(loop: Node) -> Node | None:
    """Return the expression with which a loop compares its number; None: code computes it."""
    asked = loop.child_by_field_name("condition")
    bound = None if asked is None else asked.child_by_field_name("right")
    return bound if bound is not None and bound.type in _PLAIN else None


def counted(loop: Node, values: Mapping[str, Value], bound: Value | None) -> int:
    """Return how many times a loop runs its body; 1: it is not known, or code leaves it.

    Parameters
    ----------
    loop : Node
        A ``for`` statement.
    values : mapping of str to Value
        Values of the variables at its start.
    bound : Value or None
        With what it compares its number.
    """
    asked, update = loop.child_by_field_name("condition"), loop.child_by_field_name("update")
    body = loop.child_by_field_name("body")
    if asked is None or update is None or body is None or not isinstance(bound, Const):
        return 1
    name, operator = (
        text_of(asked.child_by_field_name("left")),
        text_of(asked.child_by_field_name("operator")),
    )
    first = values.get(name)
    if not isinstance(first, Const) or name in assigned_in(body) or leaves(body):
        return 1
    if type(first.value) is not int or type(bound.value) is not int:
        return 1
    if operator in ("<", "<=", "!=") and text_of(update) in (f"++{name}", f"{name}++", f"{name} += 1"):
        count = bound.value - first.value
    elif operator in (">", ">=", "!=") and text_of(update) in (f"--{name}", f"{name}--", f"{name} -= 1"):
        count = first.value - bound.value
    else:
        return 1
    return max(1, count + (operator in ("<=", ">=")))


def leaves(body: Node | None) -> bool:
    """Return whether the body of a loop may skip a part of it, or end the loop early."""
    return any(
        each.type in ("break_statement", "continue_statement", "goto_statement") for each in nodes_in(body)
    )


def assigned_in(node: Node) -> frozenset[str]:
    """Return what a loop assigns."""
    return frozenset(
        text_of(each.child_by_field_name("argument") or each.child_by_field_name("left"))
        for each in nodes_in(node)
        if each.type in ("update_expression", "assignment_expression")
    )
