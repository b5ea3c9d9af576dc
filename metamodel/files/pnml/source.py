"""Reading text, numbers and XML fragments out of a PNML file, with errors that name file and line."""

from __future__ import annotations

import re
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path

from lxml import etree

from dineros.metamodel.errors import Location, ModelFileError, raise_collected
from dineros.metamodel.files.exact import exact_number
from dineros.metamodel.files.pnml.vocabulary import NAMESPACES, tag
from dineros.metamodel.files.schema import shortened
from dineros.metamodel.files.xml import line_of

LARGEST = 2**31 - 1
_INTEGER = re.compile(r"[+-]?[0-9]+")


class Source:
    """The file being read.

    Parameters
    ----------
    path : Path or str
        The file, for locations in messages.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = path
        self.errors: list[ModelFileError] = []
        """What is wrong so far; `refuse_errors` raises it."""
        self.notes: list[str] = []
        """Elements that were read in another way than the standard specifies."""
        self._class: tuple[str, int | None] | None = None

    def note(self, text: str) -> None:
        """Remember, once, what was taken as what."""
        if text not in self.notes:
            self.notes.append(text)

    def use_class(self, name: str, element: etree._Element) -> None:
        """Note the class of some tokens; P/T nets have one.

        Raises
        ------
        ModelFileError
            Tokens of another class were read before.
        """
        first, line = self._class or (name, line_of(element))
        self._class = first, line
        if first != name:
            what = f"tokens of two classes: {shortened(first)} on line {line}, {shortened(name)} here"
            raise self.error(what, element, hint="only nets with tokens of one class are read")

    def complain(
        self,
        message: str,
        element: etree._Element | None,
        *,
        id: str | None = None,
        hint: str | None = None,
    ) -> None:
        """Remember an error about an XML element, so that all errors of a file are reported together."""
        self.errors.append(self.error(message, element, id=id, hint=hint))

    def refuse_errors(self) -> None:
        """Raise what was complained about, in the order of the file.

        Raises
        ------
        ModelFileError
            There was one complaint; `CollectedModelFileError` where there were more.
        """
        raise_collected(self.errors)

    def location(self, element: etree._Element | None) -> Location:
        """Return file and line of an XML element."""
        return Location(self.path, None if element is None else line_of(element))

    def error(
        self,
        message: str,
        element: etree._Element | None,
        *,
        id: str | None = None,
        hint: str | None = None,
    ) -> ModelFileError:
        """Return an error about an XML element, to be raised."""
        return ModelFileError(message, location=self.location(element), element=id, hint=hint)

    def attribute(self, element: etree._Element, name: str) -> str:
        """Return an attribute that must be there and not be blank."""
        value = element.get(name)
        if value is None or not value.strip():
            raise self.error(f"<{local(element)}> has no {name}", element, hint=f'add {name}="..."')
        return value

    def integer(self, text: str, element: etree._Element, what: str, minimum: int = -LARGEST - 1) -> int:
        """Return a whole number between `minimum` and 2^31 - 1."""
        text = text.strip()
        # The length is checked first: int() of a million digits takes seconds.
        if not _INTEGER.fullmatch(text):
            raise self.error(f"{what} {shortened(text)} is not a whole number", element)
        digits = text.lstrip("+-").lstrip("0") or "0"
        value = int(text[0].strip("+0123456789") + digits) if len(digits) <= 10 else None
        if value is None or value > LARGEST or value < minimum:
            bounds = f"from {minimum} to {LARGEST}"
            raise self.error(f"{what} {shortened(text)} is out of range", element, hint=f"it may be {bounds}")
        return value

    def number(self, text: str, element: etree._Element, what: str) -> float:
        """Return a finite decimal or rational number, exactly (see `exact`)."""
        try:
            return exact_number(text)
        except ValueError:
            raise self.error(f"{what} {shortened(text.strip())} is not a number", element) from None


def local(element: etree._Element) -> str:
    """Return the tag of an element without its namespace."""
    return str(element.tag).rpartition("}")[2]


def children(element: etree._Element) -> Iterator[etree._Element]:
    """Yield the child elements, without comments and processing instructions."""
    return element.iterchildren(tag=etree.Element)


def child(element: etree._Element, name: str) -> etree._Element | None:
    """Return the first child with this local name, in any namespace, or None."""
    return next((found for found in children(element) if local(found) == name), None)


def text_of(element: etree._Element) -> str:
    """Return the text of an element, plain or wrapped in `<text>`, without the white space around it."""
    wrapped = child(element, "text")
    return "".join(map(str, (element if wrapped is None else wrapped).itertext())).strip()


def canonical(element: etree._Element) -> str:
    """Return an element as canonical XML text that keeps its namespaces.

    The element is first put under a root with PNML as the default namespace, as it will be when written,
    so that prefixes of PNML elements do not depend on the file it came from.
    """
    root = etree.Element(tag("pnml"), nsmap=NAMESPACES)
    copy = deepcopy(element)
    copy.tail = None
    root.append(copy)
    try:
        return etree.tostring(copy, method="c14n").decode()
    except etree.C14NError:  # relative namespace names have no canonical form
        return etree.tostring(copy, encoding="unicode")


def parse_fragment(text: str) -> etree._Element | None:
    """Parse one XML element from text, or return None if it is not one."""
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
    try:
        root = etree.fromstring(text, parser)
    except (etree.XMLSyntaxError, ValueError):
        return None
    tree: etree._ElementTree = root.getroottree()
    return None if tree.docinfo.doctype else root  # type: ignore[attr-defined] # missing in the stubs
