"""Parsing XML that may come from anywhere: no document type, no entities, no network, bounded size and depth.

The limits: files of 64 MiB, half a million elements, nesting of 256 and texts of 10 MB (libxml2's own two).
A document type declaration is refused altogether, so that there are no entities to expand or to fetch.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TypeAlias, cast

from lxml import etree

from dineros.metamodel.errors import Location, ModelFileError
from dineros.metamodel.files.reading import read_bytes

Tree: TypeAlias = "etree._ElementTree"

ELEMENT_LIMIT = 500_000

_BEFORE_DOCUMENT_TYPE = re.compile(rb"(?>(?:\s++|<\?.*?\?>|<!--.*?-->)*+)<!DOCTYPE", re.DOTALL)


def parse(path: Path | str) -> Tree:
    """Parse an XML file; comments and processing instructions are dropped.

    Raises
    ------
    ModelFileError
        The file cannot be read, is not well-formed, has a document type, or exceeds a limit.
    """
    return parse_bytes(read_bytes(path), path)


def parse_bytes(content: bytes, path: Path | str) -> Tree:
    """Parse the content of an XML file; `path` is named in messages.

    Raises
    ------
    ModelFileError
        It is not well-formed, has a document type, or exceeds a limit.
    """
    if not content.strip():
        raise ModelFileError("is empty", location=Location(path), hint="a model is expected")
    # Counted before there is a tree, which would take gigabytes; comments and such count as well.
    if content.count(b"<") - content.count(b"</") > ELEMENT_LIMIT:
        raise ModelFileError(f"has more than {ELEMENT_LIMIT} elements", location=Location(path))
    _refuse_document_type(content, path)
    parser = etree.XMLParser(
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        dtd_validation=False,
        huge_tree=False,
        remove_comments=True,
        remove_pis=True,
    )
    try:
        root = etree.fromstring(content, parser)
    except etree.XMLSyntaxError as error:
        raise _not_well_formed(error, path) from error
    except (ValueError, LookupError, AssertionError) as error:  # an encoding lxml itself stumbles over
        raise ModelFileError(f"is not XML: {error}", location=Location(path)) from error
    tree = root.getroottree()
    if tree.docinfo.internalDTD is not None or tree.docinfo.doctype:  # in an encoding the search missed
        raise _document_type(path, None)
    return tree


def line_of(node: etree._Element) -> int | None:
    """Return the line an element starts on."""
    return cast("int | None", node.sourceline)


def attributes_of(node: etree._Element) -> list[tuple[str, str]]:
    """Return names and values of an element's attributes, in order."""
    return cast("list[tuple[str, str]]", node.items())


def _refuse_document_type(content: bytes, path: Path | str) -> None:
    start = content[:1_000_000].removeprefix(b"\xef\xbb\xbf")
    if start.startswith((b"\xff\xfe", b"\xfe\xff")) or b"\0" in start[:4]:  # UTF-16, UTF-32
        start = start.lstrip(b"\xff\xfe\0").replace(b"\0", b"")
    match = _BEFORE_DOCUMENT_TYPE.match(start)
    if match:
        raise _document_type(path, start.count(b"\n", 0, match.end()) + 1)


def _document_type(path: Path | str, line: int | None) -> ModelFileError:
    return ModelFileError(
        "has a document type declaration, which is not read for safety",
        location=Location(path, line),
        hint="remove the <!DOCTYPE ...>",
    )


def _not_well_formed(error: etree.XMLSyntaxError, path: Path | str) -> ModelFileError:
    line, column = error.position
    message = re.sub(r", line \d+, column \d+.*$", "", error.msg or "no document").strip()
    message = message.removesuffix(", try XML_PARSE_HUGE")
    hint = None
    if "Start tag expected" in message or "Document is empty" in message:
        hint = "is it an XML file?"
    if "depth" in message:
        message, hint = "elements nest deeper than 256", None
    return ModelFileError(
        f"is not well-formed XML: {message}", location=Location(path, line or None, column or None), hint=hint
    )
