"""Parses C++ files into trees; files that cannot be parsed safely are ignored, with the reason."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Container, Iterator
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import TYPE_CHECKING

from dineros.metamodel.errors import DinerosError
from dineros.sources.folders import SourceFolder

if TYPE_CHECKING:
    from tree_sitter import Node, Parser

_MOST_KEPT = 1 << 16
"""Limit of the parts of trees whose texts are kept, as code is followed repeatedly."""
MOST_NESTED = 400
"""Limit of the nesting of brackets in a file; code written by hand has about twenty levels."""

_MARKS = re.compile(
    rb"\b(?!\w*TRANSIENT_LOCAL\b)[A-Z][A-Z0-9_]*_(?:PUBLIC|EXPORT|LOCAL|API|VISIBILITY)\b(?!\s*\()"
)
_DIRECTIVE = re.compile(rb"^[ \t]*#[ \t]*(if|ifdef|ifndef|elif|else|endif)\b[^\n]*", re.MULTILINE)
_BRACKET = re.compile(rb"[()\[\]{}]")


@dataclass(eq=False)
class Source:
    """A file in C++."""

    path: str
    """In the folder."""
    root: Node
    """Of its tree."""
    text: bytes
    """The parsed text: macros of visibility are replaced by blanks, those of the folder are expanded."""
    digest: str
    """Hash of the text with its macros expanded."""


@cache
def _parser() -> Parser:
    try:
        import tree_sitter
        import tree_sitter_cpp
    except ImportError as error:
        raise DinerosError("reading C++ needs tree-sitter", hint="pip install 'dineros[sources]'") from error
    return tree_sitter.Parser(tree_sitter.Language(tree_sitter_cpp.language()))


def is_there() -> bool:
    """Return whether C++ can be read: whether the extra ``sources`` is installed."""
    try:
        _parser()
    except DinerosError:
        return False
    return True


def parse(folder: SourceFolder, path: str, code: str) -> Source | None:
    """Return the text of a file as a tree; None, and a line in `unread`, if that is not possible."""
    content = code.encode()
    if _nested(content) > MOST_NESTED:
        folder.unread.append(f"{path}: its brackets are nested more than {MOST_NESTED} deep")
        return None
    text = _MARKS.sub(_blank, content)
    root = _parser().parse(text).root_node
    if root.has_error and _DIRECTIVE.search(text):
        least = errors_of(root)
        for other in (_DIRECTIVE.sub(_blank, text), _first_branches(text)):
            tried = _parser().parse(other).root_node
            if (number := errors_of(tried)) < least:
                root, text, least = tried, other, number
    return Source(path, root, text, hashlib.sha256(content).hexdigest())


def errors_of(root: Node) -> int:
    """Return how many parts of a tree could not be parsed."""
    found, todo = 0, [root]
    while todo:
        node = todo.pop()
        if node.has_error:
            found += node.is_error or node.is_missing
            todo += node.children
    return found


def _blank(found: re.Match[bytes]) -> bytes:
    return b" " * len(found[0])


def _nested(text: bytes) -> int:
    level = most = 0
    for found in _BRACKET.finditer(text):
        level += 1 if found[0] in b"([{" else -1
        most = max(most, level)
    return most


def _first_branches(text: bytes) -> bytes:
    """Return a text in which only the first branch of each condition is left."""
    lines, kept = text.split(b"\n"), [True]
    for number, line in enumerate(lines):
        found = _DIRECTIVE.match(line)
        word = found[1] if found else b""
        if word.startswith(b"if"):
            kept.append(kept[-1])
        elif word in (b"elif", b"else"):
            kept[-1] = False
        elif word == b"endif" and len(kept) > 1:
            kept.pop()
        if found or not kept[-1]:
            lines[number] = b" " * len(line)
    return b"\n".join(lines)


@lru_cache(maxsize=_MOST_KEPT)
def text_of(node: Node | None) -> str:
    """Return the text of a node."""
    return "" if node is None or node.text is None else node.text.decode("utf-8", "replace")


def forget_texts() -> None:
    """Release the texts of trees, and with them the trees."""
    text_of.cache_clear()
    path_of.cache_clear()


def nodes_in(node: Node | None, without: Container[str] = ()) -> Iterator[Node]:
    """Yield a node and all inside it, but not those inside nodes of some types; the last child first."""
    todo = [] if node is None else [node]
    while todo:
        each = todo.pop()
        yield each
        if each.type not in without:
            todo += each.named_children


def line_of(node: Node) -> int:
    """Return the line where a node begins, from 1."""
    return int(node.start_point[0]) + 1


def end_of(node: Node) -> Node:
    """Return the last part of a name, without arguments of templates: of ``a::b<c>`` the node of ``b``."""
    while True:
        inner = node.child_by_field_name("name")
        if inner is None and node.type == "dependent_name":
            inner = next(iter(node.named_children), None)
        if inner is None:
            return node
        node = inner


def on_text(call: Node) -> str:
    """Return the object expression of a method call: of ``a->b()`` the text ``a``."""
    function = call.child_by_field_name("function")
    return text_of(function.child_by_field_name("argument")) if function is not None else ""


_BLANKS = re.compile(r"\s+")
_TEMPLATED = {"template_type", "template_function", "template_method"}


@lru_cache(maxsize=_MOST_KEPT)
def path_of(node: Node | None) -> str:
    """Return the name that a node has, without arguments of templates: ``std::make_shared``."""
    if node is None:
        return ""
    if node.type == "qualified_identifier":
        scope, name = path_of(node.child_by_field_name("scope")), path_of(node.child_by_field_name("name"))
        return f"{scope}::{name}" if scope else name
    if node.type in _TEMPLATED:
        return path_of(node.child_by_field_name("name"))
    if node.type == "type_descriptor":
        return path_of(node.child_by_field_name("type"))
    if node.type == "dependent_name":  # value.template get<int>()
        return path_of(node.named_children[0]) if node.named_children else ""
    if node.type == "dependent_type":
        return path_of(node.named_children[0]) if node.named_children else ""
    text = text_of(node)
    return text if text.isidentifier() else _BLANKS.sub("", text)


def arguments_of_scope(node: Node | None) -> list[Node]:
    """Return the arguments of the template before the last name: of ``Part<A, B>::make_shared``, A and B."""
    scope = None
    while node is not None and node.type == "qualified_identifier":
        scope, node = node.child_by_field_name("scope"), node.child_by_field_name("name")
    return arguments_of(scope)


def arguments_of(node: Node | None) -> list[Node]:
    """Return the arguments of the last template in a name."""
    while node is not None:
        if node.type in _TEMPLATED:
            inner = node.child_by_field_name("arguments")
            return [] if inner is None else [each for each in inner.named_children if each.type != "comment"]
        if node.type == "type_descriptor":
            node = node.child_by_field_name("type")
        elif node.type == "dependent_name":  # node->template create_service<T>(...)
            node = next(iter(node.named_children), None)
        elif node.type == "qualified_identifier":
            inner = node.child_by_field_name("name")
            scope = node.child_by_field_name("scope")
            if path_of(inner) in ("SharedPtr", "UniquePtr", "ConstSharedPtr", "WeakPtr"):
                node = scope
            else:
                node = inner
        else:
            return []
    return []
