"""The values of enumerators."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

from dineros.sources.cpp.parsing import text_of

if TYPE_CHECKING:
    from tree_sitter import Node

_NUMBER = re.compile(r"([+-]?)(0[xX][0-9a-fA-F]+|0[bB][01]+|[0-9]+)[uUlL]*")
_SHIFTED = re.compile(r"\(?\s*1[uUlL]*\s*<<\s*([0-9]{1,2})\s*\)?")


def enumerators_of(node: Node, space: str) -> Iterator[tuple[str, str, Node]]:
    """Yield the enumerators of an enumeration: name, namespace or class around it, and definition.

    Those without scope have two full names.
    """
    body = node.child_by_field_name("body")
    name = text_of(node.child_by_field_name("name"))
    inside = f"{space}::{name}".strip(":")
    is_scoped = any(each.type in ("class", "struct") for each in node.children)
    for each in body.named_children if body is not None else ():
        if each.type == "enumerator":
            last = text_of(each.child_by_field_name("name"))
            for around in (inside,) if is_scoped else dict.fromkeys((space, inside)):
                yield last, around, each


def value_of(enumerator: Node) -> int | None:
    """Return the number of an enumerator; None: its text does not say it."""
    value: int | None = -1
    known: dict[str, int | None] = {}
    around = enumerator.parent
    for each in around.named_children if around is not None else ():
        if each.type != "enumerator":
            if each.type != "comment":
                value = None  # of a directive
            continue
        given = each.child_by_field_name("value")
        value = _number(text_of(given), known) if given is not None else None if value is None else value + 1
        known[text_of(each.child_by_field_name("name"))] = value
        if each == enumerator:
            return value
    return None


def _number(text: str, known: dict[str, int | None]) -> int | None:
    text = text.strip()
    found = _NUMBER.fullmatch(text)
    if found is not None:
        digits = found[2]
        is_octal = len(digits) > 1 and digits.startswith("0") and digits.isdigit()
        number = int(digits, 8 if is_octal else 0) if not is_octal or re.fullmatch("[0-7]+", digits) else None
        return None if number is None else -number if found[1] == "-" else number
    shifted = _SHIFTED.fullmatch(text)
    return 1 << int(shifted[1]) if shifted is not None else known.get(text)
