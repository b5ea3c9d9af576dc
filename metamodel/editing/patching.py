"""Edits an XML file of another program in place: only the changed bytes differ.

The change is computed from two files in our own format, before and after it: attributes, texts, elements
added or removed. Each is located by the id of its element and a path from there. The same change is made in
the file, which has the same elements in another form. Reading the result shows whether it was successful
(`storing`).
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import SequenceMatcher
from typing import TypeVar

from lxml import etree

from dineros.metamodel.editing.spans import NotReadableError, Span, attribute_values, spans

_ESCAPES = {
    "&": "&amp;",
    "<": "&lt;",
    ">": "&gt;",
    '"': "&quot;",
    "'": "&apos;",
    "\t": "&#9;",
    "\n": "&#10;",
    "\r": "&#13;",
}
Path = tuple[tuple[str, int], ...]
"""Path from an element with an id: names of elements, and their positions among those of the same name."""


T = TypeVar("T")


class NoPatchError(Exception):
    """The change cannot be made in this file."""


@dataclass(frozen=True)
class _Edit:
    """A replacement of bytes of the file."""

    start: int
    end: int
    text: bytes


def patched(original: bytes, before: bytes, after: bytes) -> bytes:
    """Return a file with the change between two other files.

    Parameters
    ----------
    original : bytes
        The file; its model is that of `before`.
    before, after : bytes
        The models before and after the change, in our own format.

    Raises
    ------
    NoPatchError
        This kind of change cannot be made in the file. In any case, the result must be read and compared,
        since a file may contain the same value several times.
    """
    try:
        edits = sorted(_Patch(original, before, after).edits(), key=lambda edit: (edit.start, edit.end))
    except (NotReadableError, etree.XMLSyntaxError) as error:
        raise NoPatchError(str(error)) from error
    pieces, at = [], 0
    for edit in edits:
        if edit.start < at:
            raise NoPatchError("two changes at one place")
        pieces += [original[at : edit.start], edit.text]
        at = edit.end
    return b"".join([*pieces, original[at:]])


class _Patch:
    def __init__(self, original: bytes, before: bytes, after: bytes) -> None:
        parser = etree.XMLParser(resolve_entities=False, no_network=True)
        self._content = original
        self._root = spans(original)
        self._here = _unique((span.attributes.get("id"), span) for span in self._root.walk())
        self._old = _unique((each.get("id"), each) for each in etree.fromstring(before, parser).iter("*"))
        self._new = _unique((each.get("id"), each) for each in etree.fromstring(after, parser).iter("*"))
        self._edits: list[_Edit] = []

    def edits(self) -> list[_Edit]:
        for id, old in self._old.items():
            if id in self._new:
                if _anchor_of(old) != _anchor_of(self._new[id]):
                    raise NoPatchError(f"{id} is now in another place")
                self._compare(id, (), old, self._new[id])
        return self._edits

    def _compare(self, anchor: str, path: Path, old: etree._Element, new: etree._Element) -> None:
        """Record the differences between two elements, without nested elements that have ids."""
        if old.tag != new.tag:
            raise NoPatchError("another kind of element")
        for name in sorted({*map(str, old.attrib), *map(str, new.attrib)}):
            if old.get(name) != new.get(name):
                self._attribute(self._find(anchor, path), _written(name, new), old.get(name), new.get(name))
        children = list(old.iterchildren("*")), list(new.iterchildren("*"))
        if not children[0] and not children[1]:
            if (old.text or "") != (new.text or ""):
                self._text(self._find(anchor, path), new.text or "")
            return
        keys = [_keys(each) for each in children]
        paths = [_paths(path, each) for each in children]
        for kind, i1, i2, j1, j2 in SequenceMatcher(None, keys[0], keys[1], autojunk=False).get_opcodes():
            if kind == "equal":
                for i, j in zip(range(i1, i2), range(j1, j2), strict=True):
                    if children[0][i].get("id") not in self._old:
                        self._compare(anchor, paths[0][i], children[0][i], children[1][j])
                continue
            for i in range(i1, i2):
                if children[0][i].get("id") in self._new:
                    raise NoPatchError("another order")
                self._take_out(self._child(anchor, paths[0][i], children[0][i]))
            if j1 < j2:
                behind = self._child(anchor, paths[0][i1 - 1], children[0][i1 - 1]) if i1 else None
                self._put_in(self._find(anchor, path), behind, children[1][j1:j2])

    def _child(self, anchor: str, path: Path, element: etree._Element) -> Span:
        id = element.get("id")
        return self._find(id, ()) if id in self._old else self._find(anchor, path)

    def _find(self, anchor: str | None, path: Path) -> Span:
        span = self._here.get(anchor or "")
        for tag, number in path:
            if span is None:
                break
            same = [child for child in span.children if child.tag == tag]
            span = same[number] if number < len(same) else None
        if span is None:
            raise NoPatchError("the file writes it in another form")
        return span

    def _attribute(self, span: Span, name: str, before: str | None, after: str | None) -> None:
        known = attribute_values(self._content, span)
        if after is None:
            if name not in known:
                raise NoPatchError("the file writes it in another form")
            start, end = known[name]
            whole = re.search(
                rb"\s+" + re.escape(name.encode()) + rb"\s*=\s*.$", self._content[span.start : start]
            )
            if whole is None:
                raise NoPatchError("the file writes it in another form")
            self._edits.append(_Edit(span.start + whole.start(), end + 1, b""))
        elif name in known:
            self._edits.append(_Edit(*known[name], _escaped(after)))
        elif before is None or before != span.attributes.get(name):
            at = span.head_end - (2 if span.is_empty_tag else 1)
            self._edits.append(_Edit(at, at, b" " + name.encode() + b'="' + _escaped(after) + b'"'))

    def _text(self, span: Span, text: str) -> None:
        if span.children or span.is_empty_tag:
            raise NoPatchError("the file writes it in another form")
        self._edits.append(_Edit(span.head_end, span.tail_start, _escaped(text)))

    def _take_out(self, span: Span) -> None:
        self._edits.append(_Edit(self._indentation(span.start), span.end, b""))

    def _indentation(self, start: int) -> int:
        """Return the position of the line break and indentation before an element."""
        return len(self._content[:start].rstrip(b" \t\r\n"))

    def _put_in(self, parent: Span, behind: Span | None, elements: list[etree._Element]) -> None:
        sibling = behind or (parent.children[0] if parent.children else None)
        blank = self._content[self._indentation(sibling.start) : sibling.start] if sibling else b""
        snippet = b"".join(blank + self._snippet(each, blank) for each in elements)
        if behind is not None:
            self._edits.append(_Edit(behind.end, behind.end, snippet))
        elif parent.is_empty_tag:
            tag = re.match(rb"<([^\s>/]+)", self._content[parent.start : parent.head_end])
            assert tag is not None
            self._edits.append(
                _Edit(parent.head_end - 2, parent.head_end, b">" + snippet + b"</" + tag[1] + b">")
            )
        else:
            self._edits.append(_Edit(parent.head_end, parent.head_end, snippet))

    def _snippet(self, element: etree._Element, blank: bytes) -> bytes:
        text: bytes = etree.tostring(element, encoding="UTF-8", with_tail=False)
        text = text[text.index(b"?>") + 2 :].lstrip() if text.startswith(b"<?xml") else text
        for name, value in self._root.attributes.items():
            if name == "xmlns" or name.startswith("xmlns:"):
                text = text.replace(b" " + name.encode() + b'="' + _escaped(value) + b'"', b"")
        own = (
            re.search(rb"\n[ \t]*$", text[: text.rindex(b"</")]) if b"\n" in text and b"</" in text else None
        )
        return text.replace(own[0], blank or b"\n") if own else text


def _unique(pairs: Iterable[tuple[str | None, T]]) -> dict[str, T]:
    """Return elements by id, without ids that occur twice."""
    found = [(id, each) for id, each in pairs if id]
    often = Counter(id for id, _ in found)
    return {id: each for id, each in found if often[id] == 1}


def _anchor_of(element: etree._Element) -> str | None:
    parent = element.getparent()
    while parent is not None and parent.get("id") is None:
        parent = parent.getparent()
    return None if parent is None else parent.get("id")


def _keys(children: list[etree._Element]) -> list[tuple[str, str]]:
    """Return keys of children: the id if there is one, else the name and the position among equal names."""
    keys: list[tuple[str, str]] = []
    counts: Counter[str] = Counter()
    for child in children:
        tag, id = str(child.tag), child.get("id")
        if id is not None:
            keys.append((tag, f"#{id}"))
        else:
            keys.append((tag, str(counts[tag])))
            counts[tag] += 1
    return keys


def _paths(path: Path, children: list[etree._Element]) -> list[Path]:
    counts: Counter[str] = Counter()
    found = []
    for child in children:
        tag = etree.QName(child).localname
        found.append((*path, (tag, counts[tag])))
        counts[tag] += 1
    return found


def _written(name: str, element: etree._Element) -> str:
    """Return the name of an attribute in files, with its prefix."""
    qualified = etree.QName(name)
    prefix = next((key for key, uri in element.nsmap.items() if uri == qualified.namespace and key), None)
    return f"{prefix}:{qualified.localname}" if qualified.namespace and prefix else qualified.localname


def _escaped(text: str) -> bytes:
    return "".join(_ESCAPES.get(character, character) for character in text).encode()
