"""Positions of XML elements in the bytes of a file, so that one value can be changed without the rest."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat

_ATTRIBUTE = re.compile(rb"""\s+([^\s=>/]+)\s*=\s*("[^"]*"|'[^']*')""")
_TAG = re.compile(rb"<[^\s>/]+")
_ENCODING = re.compile(rb"""<\?xml[^>]*\bencoding\s*=\s*["']([^"']+)["']""")


@dataclass(eq=False)
class Span:
    """An XML element in the bytes of its file.

    Attributes
    ----------
    tag : str
        Its name, without namespace.
    attributes : dict of str
        Its attributes, by their names in the file.
    start, head_end, tail_start, end : int
        Start and end of its start tag, start and end of its end tag; an empty tag has no separate end tag,
        and `tail_start` is `head_end`.
    parent : Span or None
        The element around it.
    children : list of Span
        The elements in it.
    """

    tag: str
    attributes: dict[str, str]
    start: int
    head_end: int
    tail_start: int = 0
    end: int = 0
    parent: Span | None = None
    children: list[Span] = field(default_factory=list)

    @property
    def is_empty_tag(self) -> bool:
        """Whether it is written as an empty tag."""
        return self.tail_start == self.end

    def walk(self) -> Iterator[Span]:
        """Yield it with all nested elements."""
        stack = [self]
        while stack:
            each = stack.pop()
            yield each
            stack.extend(reversed(each.children))


class NotReadableError(ValueError):
    """The bytes are not XML in UTF-8."""


def spans(content: bytes) -> Span:
    """Return the root of a file that a reader of models has read before.

    Raises
    ------
    NotReadableError
        The bytes are not XML in UTF-8.
    """
    declared = _ENCODING.match(content.removeprefix(b"\xef\xbb\xbf"))
    if declared and declared[1].lower() not in (b"utf-8", b"us-ascii", b"ascii"):
        raise NotReadableError("another encoding")
    parser = expat.ParserCreate("UTF-8")
    stack: list[Span] = []
    roots: list[Span] = []

    def start(name: str, attributes: dict[str, str]) -> None:
        at = parser.CurrentByteIndex
        span = Span(name.rpartition(":")[2], attributes, at, _head_end(content, at))
        if stack:
            span.parent = stack[-1]
            stack[-1].children.append(span)
        else:
            roots.append(span)
        stack.append(span)

    def end(_: str) -> None:
        span = stack.pop()
        if content[span.head_end - 2 : span.head_end] == b"/>":
            span.tail_start = span.end = span.head_end
        else:
            span.tail_start = parser.CurrentByteIndex
            span.end = content.index(b">", span.tail_start) + 1

    parser.StartElementHandler, parser.EndElementHandler = start, end
    try:
        content.decode("utf-8")
        parser.Parse(content, True)
    except (expat.ExpatError, ValueError) as error:
        raise NotReadableError(str(error)) from error
    return roots[0]


def _head_end(content: bytes, start: int) -> int:
    """Return the end of a start tag; the values of attributes may contain '>'."""
    tag = _TAG.match(content, start)
    at = tag.end() if tag else start
    while attribute := _ATTRIBUTE.match(content, at):
        at = attribute.end()
    return content.index(b">", at) + 1


def attribute_values(content: bytes, span: Span) -> dict[str, tuple[int, int]]:
    """Return the positions of the values of an element's attributes, without quotes."""
    tag = _TAG.match(content, span.start)
    at = tag.end() if tag else span.start
    found: dict[str, tuple[int, int]] = {}
    while attribute := _ATTRIBUTE.match(content, at):
        found[attribute[1].decode()] = (attribute.start(2) + 1, attribute.end(2) - 1)
        at = attribute.end()
    return found
