"""Finds calls in C++ that create entities, by their names, whether or not a program executes them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from dineros.sources.cpp.making import MAKES
from dineros.sources.cpp.parsing import Source, line_of, text_of
from dineros.sources.left_out import MakingCall

if TYPE_CHECKING:
    from tree_sitter import Node

_METHODS = ("advertiseCamera", "subscribeCamera")
"""Methods of ``image_transport::ImageTransport`` with unambiguous names."""


def calls_of(sources: Iterable[Source], idioms: Iterable[str]) -> Iterator[MakingCall]:
    """Yield the calls in files that create entities, including dead code.

    Parameters
    ----------
    sources : iterable of Source
        The files.
    idioms : iterable of str
        Classes and functions of libraries that make entities.
    """
    idioms = list(idioms)
    ends = {path.rpartition("::")[2] for path in idioms}
    functions = [*MAKES, *_METHODS, *(each for each in ends if each.startswith("create_"))]
    others = [path.rpartition("::") for path in idioms if path.rpartition("::")[2][:1].islower()]
    functions += [f"(?<={scope}::){last}" for scope, _, last in others if not last.startswith("create_")]
    classes = [each for each in ends if each[0].isupper()]
    call = rf"\b(?:{'|'.join(functions)})\b(?=\s*[<(])"
    made = rf"\bmake_(?:shared|unique)\s*<\s*(?:\w+::)*(?P<cls>{'|'.join(classes)})\b"
    name = re.compile(f"{call}|{made}".encode())
    for source in sources:
        for found in name.finditer(source.text):
            which = "cls" if found["cls"] is not None else 0
            node = source.root.descendant_for_byte_range(*found.span(which))
            if node is not None and (node.type == "type_identifier" if which else _is_call(node)):
                yield MakingCall(source.path, line_of(node), found[which].decode())


def _is_call(node: Node) -> bool:
    """Return whether a name is that of a function that is called; actions are those of ``rclcpp_action``."""
    if node.type not in ("identifier", "field_identifier"):
        return False
    name, inner, outer = node, node, node.parent
    while outer is not None and outer.type in (
        *("template_function", "template_method", "field_expression", "qualified_identifier"),
        *("dependent_name", "dependent_field_identifier"),
    ):
        inner, outer = outer, outer.parent
    if outer is None or outer.type != "call_expression" or outer.child_by_field_name("function") != inner:
        return False
    return text_of(name) != "create_server" or "rclcpp_action" in text_of(inner)
