"""What a PNML file holds, before it becomes a model: plain records that are cheap to move about.

The class of a model element cannot change once it exists, and whether a page is a node net may depend on
elements at the other end of the file; so a file is first read into records.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from lxml import etree

from dineros.metamodel.files.pnml.plain.values import Interval
from dineros.metamodel.files.pnml.source import child, children, local, text_of


@dataclass(eq=False, slots=True)
class Extension:
    """The fields of an element's DiNeROS blocks and the ``<element>`` of its own block."""

    fields: dict[str, etree._Element] = field(default_factory=dict)
    blocks: list[etree._Element] = field(default_factory=list)
    own: etree._Element | None = None

    def text(self, name: str) -> str | None:
        """Return the text of a field, or None if it is absent or blank."""
        xml = self.fields.get(name)
        return None if xml is None else text_of(xml) or None

    def mark(self, name: str) -> str | None:
        """Return an attribute of our own block."""
        return None if self.own is None else self.own.get(name)


@dataclass(eq=False, slots=True)
class Record:
    """What all records have; `xml` is None for inserted elements."""

    id: str
    xml: etree._Element | None
    page: PageRecord | None
    extension: Extension = field(default_factory=Extension)

    def where(self) -> etree._Element | None:
        """Return the XML element itself, or that of the nearest page around an inserted element."""
        record: Record | None = self
        while record is not None and record.xml is None:
            record = record.page
        return None if record is None else record.xml


@dataclass(eq=False, slots=True)
class NodeRecord(Record):
    """A place, a transition, a reference (`ref` is the id it refers to), a topic, a service or an action."""

    kind: str = "place"
    ref: str | None = None
    tokens: int | None = None
    """Of a place: the initial marking, None if the file has none."""
    capacity: int | None = None
    interval: Interval | None = None

    @property
    def is_channel(self) -> bool:
        """Topics, services and actions are in the file like transitions."""
        return self.kind in ("topic", "service", "action")

    @property
    def is_place(self) -> bool:
        """Places and references to them."""
        return self.kind in ("place", "referencePlace")


@dataclass(eq=False, slots=True)
class PageRecord(Record):
    """A page, or the net itself, which has no page around it and holds pages only."""

    name: str | None = None
    kind: str = "page"  # net, page, node (net), or callback (page)
    objects: list[PageRecord | NodeRecord] = field(default_factory=list)

    @property
    def label(self) -> str:
        """The name, or the id where there is none."""
        return self.name or self.id

    def is_called(self, name: str) -> bool:
        """Return whether this is the page's name or id."""
        return name in (self.id, self.name)

    def pages(self) -> Iterator[PageRecord]:
        """Yield the page itself and all pages inside, outer before inner."""
        stack = [self]
        while stack:
            page = stack.pop()
            yield page
            stack.extend([inner for inner in page.objects if isinstance(inner, PageRecord)][::-1])

    def nodes(self) -> Iterator[NodeRecord]:
        """Yield all nodes on the page and the pages inside, channels included."""
        for page in self.pages():
            for inner in page.objects:
                if isinstance(inner, NodeRecord):
                    yield inner

    def around(self) -> Iterator[PageRecord]:
        """Yield the page itself and all pages around it, the net included, from the inside out."""
        page: PageRecord | None = self
        while page is not None:
            yield page
            page = page.page

    @property
    def node_net(self) -> PageRecord | None:
        """The node net the page is or is in."""
        return next((page for page in self.around() if page.kind == "node"), None)


@dataclass(eq=False, slots=True)
class ArcRecord(Record):
    """An arc by the ids of its ends."""

    source: str = ""
    target: str = ""
    weight: int = 1
    kind: str = "normal"


@dataclass(eq=False, slots=True)
class NetRecord:
    """All records of a file."""

    root: PageRecord
    arcs: list[ArcRecord] = field(default_factory=list)
    ids: dict[str, Record] = field(default_factory=dict)
    extended: bool = False

    def unique(self, id: str) -> str:
        """Return the id, or the first of id.2, id.3, ... that is free."""
        number, candidate = 1, id
        while candidate in self.ids:
            number += 1
            candidate = f"{id}.{number}"
        return candidate

    def insert(self, record: PageRecord | NodeRecord) -> None:
        """Add a record that the file does not have to the page it names."""
        self.ids[record.id] = record
        assert record.page is not None
        record.page.objects.append(record)


def move(moves: list[tuple[PageRecord | NodeRecord, PageRecord]]) -> None:
    """Move nodes, and pages with all they hold, to the end of other pages."""
    moved = {record for record, page in moves if record.page is not page}
    for left in dict.fromkeys(record.page for record in moved):
        if left is not None:
            left.objects = [inner for inner in left.objects if inner not in moved]
    for record, page in moves:
        if record in moved:
            page.objects.append(record)
            record.page = page


def items(xml: etree._Element | None, name: str) -> list[etree._Element]:
    """Return the children of this name, or none where the element itself is absent."""
    return [] if xml is None else [inner for inner in children(xml) if local(inner) == name]


def item_text(xml: etree._Element, name: str) -> str | None:
    """Return the text of a child, or None if it is absent or blank."""
    inner = child(xml, name)
    return None if inner is None else text_of(inner) or None
