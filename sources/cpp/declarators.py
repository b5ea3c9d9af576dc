"""Reads declarators of C++: names, functions, parameters."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from dineros.sources.cpp.parsing import path_of, text_of

if TYPE_CHECKING:
    from tree_sitter import Node


@dataclass(frozen=True)
class Parameter:
    """A parameter of a function: its name, type and default."""

    name: str
    type: Node | None
    default: Node | None
    is_out: bool = False
    """Whether it is a reference by which a function gives a value to its caller."""
    is_pack: bool = False
    """Whether it stands for any number of arguments."""


_PACK = "variadic_parameter_declaration"


def used(node: Node) -> Node | None:
    """Return the name that ``using std_msgs::msg::String`` imports; None: a namespace, or of ``std``."""
    name = node.named_children[0] if node.named_children else None
    is_space = any(each.type == "namespace" for each in node.children)
    if name is None or is_space or "::" not in path_of(name) or path_of(name).startswith("std::"):
        return None
    return name


def name_of(node: Node | None) -> str:
    """Return the name that a declarator declares."""
    while node is not None:
        inner = node.child_by_field_name("declarator")
        if inner is None and node.type in ("reference_declarator", "init_declarator", "variadic_declarator"):
            inner = next((each for each in node.named_children), None)
        if inner is None and node.type == "parenthesized_declarator":  # of a pointer to a function
            inner = node.named_children[-1] if node.named_children else None
        if inner is None:
            return path_of(node)
        node = inner
    return ""


def function_of(node: Node | None) -> Node | None:
    """Return the declarator of a function in a declarator; None: it declares something else."""
    while node is not None:
        if node.type == "function_declarator":
            inner = node.child_by_field_name("declarator")
            return node if inner is None or inner.type != "parenthesized_declarator" else None
        inner = node.child_by_field_name("declarator")
        if inner is None and node.type == "reference_declarator":
            inner = next((each for each in node.named_children), None)
        node = inner
    return None


def is_array(declarator: Node) -> bool:
    """Return whether a variable is declared as an array, as in ``const char * names[] = {...}``."""
    inner = declarator.child_by_field_name("declarator")
    return declarator.type == "array_declarator" or (inner is not None and is_array(inner))


def parameters_of(node: Node) -> list[Parameter]:
    """Return the parameters of a declarator of a function or lambda."""
    return [
        Parameter(
            name_of(each.child_by_field_name("declarator")),
            each.child_by_field_name("type"),
            each.child_by_field_name("default_value"),
            _is_out(each),
            each.type == _PACK,
        )
        for each in _of(node.child_by_field_name("parameters"))
        if each.type in ("parameter_declaration", "optional_parameter_declaration", _PACK)
    ]


def declared(name: str, at: Node) -> Node | None:
    """Return the declaration of a local variable or parameter, as seen from a location in its function."""
    node: Node | None = at
    while node is not None:
        around = node.parent
        found: list[Node] = []
        if around is not None and around.type == "compound_statement":
            found = [each for each in around.named_children if each.end_byte <= node.start_byte]
        elif around is not None and around.type in ("for_range_loop", "for_statement"):
            found = [around, *around.named_children]
        elif node.type in ("lambda_expression", "function_definition"):
            function = function_of(node.child_by_field_name("declarator"))
            function = function or node.child_by_field_name("declarator")
            found = list(_of(function.child_by_field_name("parameters"))) if function is not None else []
        for each in reversed(found):
            one_by_one = each.children_by_field_name("declarator")
            if each.child_by_field_name("type") is not None and name in map(name_of, one_by_one):
                return each
        node = around
    return None


def is_pointer(declaration: Node | None) -> bool:
    """Return whether a declaration declares a plain pointer."""
    node = declaration.child_by_field_name("declarator") if declaration is not None else None
    while node is not None:
        if node.type in ("pointer_declarator", "abstract_pointer_declarator"):
            return True
        node = node.child_by_field_name("declarator")
    return False


def _is_out(node: Node) -> bool:
    declarator = node.child_by_field_name("declarator")
    return (
        declarator is not None
        and declarator.type == "reference_declarator"
        and text_of(declarator).startswith("&")
        and not text_of(declarator).startswith("&&")
        and all(text_of(each) != "const" for each in node.children)
    )


def _of(node: Node | None) -> Iterator[Node]:
    return iter([] if node is None else node.named_children)


def is_lost(made: Node) -> bool:
    """Return whether an object is destroyed at once or at the end of its block, and never moved elsewhere."""
    around, block = made.parent, made.parent
    if around is not None and around.type == "expression_statement":
        return True
    declarator = made if made.type == "init_declarator" else around
    if declarator is None or declarator.type != "init_declarator":
        return made.type == "function_declarator"
    while block is not None and block.type != "compound_statement":
        block = block.parent
    name = re.escape(name_of(declarator.child_by_field_name("declarator")))
    rest = text_of(block).replace(text_of(declarator), "")
    return not re.search(rf"move\(\s*{name}\s*\)|return\s+{name}\s*;|\b{name}\.(?:detach|share)\(", rest)
