"""Reading the structure of a PNML file (ISO/IEC 15909-2): pages, nodes, references and arcs, as records."""

from __future__ import annotations

from collections.abc import Callable

from lxml import etree

from dineros.metamodel.errors import ModelFileError, counted, near_matches
from dineros.metamodel.files.pnml.delays import convert_test_arcs
from dineros.metamodel.files.pnml.plain.checks import (
    NetWide,
    check_attributes,
    check_element,
    check_parts,
    check_text,
)
from dineros.metamodel.files.pnml.plain.known import ELEMENTS
from dineros.metamodel.files.pnml.plain.values import (
    capacity_of,
    check_labels,
    interval_of,
    kind_of,
    label_text,
    note_blocks,
    only,
    tokens_of,
    weight_of,
)
from dineros.metamodel.files.pnml.records import (
    ArcRecord,
    Extension,
    NetRecord,
    NodeRecord,
    PageRecord,
    Record,
)
from dineros.metamodel.files.pnml.source import Source, canonical, child, children, local
from dineros.metamodel.files.pnml.vocabulary import (
    ACTION,
    ALL_FIELDS,
    CALLBACK_TYPES,
    DINEROS,
    NODE_PAGE,
    OWN,
    OWN_VERSION,
    SERVICE,
    TOPIC,
    TRANSITION_TYPES,
    VERSIONS,
    tag,
)
from dineros.metamodel.files.xml import line_of

_CHANNELS = {TOPIC: "topic", SERVICE: "service", ACTION: "action"}
_NODES = ("place", "transition", "referencePlace", "referenceTransition")


def read_records(net: etree._Element, source: Source) -> NetRecord:
    """Read a P/T net; what is wrong inside is complained about, `source.refuse_errors` raises it.

    Raises
    ------
    ModelFileError
        It has no page.
    """
    if not (net.get("id") or "").strip():
        source.note("the net is given an id")
        known = {xml.get("id") for xml in net.iter()}
        net.set(
            "id", next(id for id in map("net{}".format, ("", *range(2, len(known) + 3))) if id not in known)
        )
    record = PageRecord(_id(net, source), net, None, _extension(net, source), kind="net")
    return _PnmlReader(record, source).read()


class _PnmlReader:
    """Reads pages, then nodes, then arcs, and continues after errors."""

    def __init__(self, root: PageRecord, source: Source) -> None:
        self._source = source
        self._net = NetRecord(root)
        self._net.ids[root.id] = root
        self._checks = NetWide(source)
        self._arcs: list[tuple[etree._Element, PageRecord]] = []
        self._taken: list[tuple[Record, etree._Element]] = []
        """Arcs whose id another element has, and that element."""
        self._loose = PageRecord("", None, root, kind="page")
        """Holds elements outside of pages."""

    def read(self) -> NetRecord:
        root, source = self._net.root, self._source
        assert root.xml is not None
        check_attributes(root.xml, "net", source)
        stack = [root]
        while stack:
            stack.extend(self._page(stack.pop())[::-1])
        self._place_loose()
        for xml, page in self._arcs:
            self._collect(self._arc, xml, page)
        if self._taken:
            first, xml = self._taken[0]
            lines = "" if first.xml is None else f" (lines {line_of(first.xml)} and {line_of(xml)})"
            taken = (
                f"{counted(len(self._taken), 'arc id')} taken by another element, such as {first.id!r}{lines}"
            )
            source.note(f"{taken}, replaced")
        convert_test_arcs(self._net)
        self._checks.finish()
        if not root.objects and not source.errors:
            hint = "put its elements into a <page>"
            raise source.error("the net has no page", root.xml, hint=hint)
        net = self._net
        net.extended = any(each.extension.blocks for each in [*net.ids.values(), *net.arcs])
        for node in root.nodes():
            if node.ref is not None:
                self._collect(_check_reference, node, net, source)
        return net

    def _collect(self, read: Callable[..., object], *given: object) -> None:
        try:
            read(*given)
        except ModelFileError as error:
            self._source.errors.append(error)

    def _page(self, page: PageRecord) -> list[PageRecord]:
        assert page.xml is not None
        inner: list[PageRecord] = []
        check_text(page.xml, self._source)
        self._collect(only, page.xml, "name", self._source)
        for xml in children(page.xml):
            if check_element(xml, ELEMENTS["net" if page.kind == "net" else "page"], page.xml, self._source):
                self._collect(self._part, xml, page, inner)
        return inner

    def _part(self, xml: etree._Element, page: PageRecord, inner: list[PageRecord]) -> None:
        kind = local(xml)
        if kind == "name":
            page.name = label_text(xml, self._source) or page.name
        elif kind in ("page", "nodePage"):
            check_attributes(xml, "page", self._source)
            record = PageRecord(_id(xml, self._source), xml, page, _extension(xml, self._source))
            record.kind = _page_kind(record, kind, self._source)
            record.name = (record.extension.mark("name") or "").strip() or None
            inner.append(record)
            page.objects.append(record)
            self._register(record)
        elif kind == "arc":
            self._arcs.append((xml, page))
        elif kind in _NODES:
            self._node(xml, kind, page)

    def _node(self, xml: etree._Element, kind: str, page: PageRecord) -> None:
        source = self._source
        check_parts(xml, kind, source)
        if page is self._net.root:
            page = self._loose
        node = NodeRecord(_id(xml, source), xml, page, Extension(), kind)
        page.objects.append(node)
        self._register(node)
        self._collect(self._node_says, node, xml, kind)
        self._collect(check_labels, xml, source)
        note_blocks(xml, source)

    def _node_says(self, node: NodeRecord, xml: etree._Element, kind: str) -> None:
        source = self._source
        node.extension = _extension(xml, source)
        if kind.startswith("reference"):
            node.ref = source.attribute(xml, "ref")
        elif kind == "transition":
            node.kind = _transition_kind(node, source)
            if not node.is_channel:
                self._checks.transition(xml)
                node.interval = interval_of(xml, source)
        else:
            self._checks.place(xml)
            node.tokens = tokens_of(xml, source)
            node.capacity = capacity_of(xml, source)

    def _arc(self, xml: etree._Element, page: PageRecord) -> None:
        source = self._source
        check_parts(xml, "arc", source)
        start, end = source.attribute(xml, "source"), source.attribute(xml, "target")
        id = (xml.get("id") or "").strip() and xml.get("id")
        if not id:
            source.note("arcs without an id are given one")
            id = self._net.unique(f"{start}-{end}")
        elif id in self._net.ids:
            self._taken.append((self._net.ids[id], xml))
            id = self._net.unique(id)
        page = self._loose if page is self._net.root else page
        arc = ArcRecord(id, xml, page, _extension(xml, source), start, end)
        self._net.arcs.append(arc)
        self._net.ids[id] = arc
        arc.weight, arc.kind = weight_of(xml, source), kind_of(xml, source)
        check_labels(xml, source)

    def _place_loose(self) -> None:
        """Put a page around what is in the net itself."""
        page, net = self._loose, self._net
        if not page.objects:
            return
        self._source.note("elements outside of pages")
        page.id = net.unique("page")
        net.ids[page.id] = page
        net.root.objects.insert(0, page)

    def _register(self, record: Record) -> None:
        first = self._net.ids.setdefault(record.id, record)
        if first is not record:
            line = line_of(first.xml) if first.xml is not None else "?"
            hint = f"by line {line}; all elements of a file share one space of ids"
            raise self._source.error(f"the id {record.id!r} is taken", record.xml, id=record.id, hint=hint)


def _id(xml: etree._Element, source: Source) -> str:
    return source.attribute(xml, "id")


def _check_reference(node: NodeRecord, net: NetRecord, source: Source) -> None:
    target = net.ids.get(node.ref or "")
    wanted = "place" if node.is_place else "transition"
    if target is None:
        known = [each.id for each in net.root.nodes() if each.is_place == node.is_place]
        hint = near_matches(node.ref or "", known)
        raise source.error(
            f"{node.id!r} refers to {node.ref!r}, which does not exist", node.xml, id=node.id, hint=hint
        )
    if not isinstance(target, NodeRecord) or target.is_channel or target.is_place != node.is_place:
        raise source.error(
            f"{node.id!r} refers to {node.ref!r}, which is not a {wanted}", node.xml, id=node.id
        )


# ------------------------------------------------------------------------------------------------- blocks


def _extension(xml: etree._Element, source: Source) -> Extension:
    extension = Extension()
    for block in xml.iterchildren(tag=tag("toolspecific")):
        tool = block.get("tool")
        if tool == DINEROS:
            if block.get("version") not in VERSIONS:
                hint = f"versions {' and '.join(VERSIONS)} are known"
                raise source.error(
                    f"version {block.get('version')!r} of the DiNeROS extension", block, hint=hint
                )
            extension.blocks.append(block)
            for inner in children(block):
                first = extension.fields.setdefault(local(inner), inner)
                if first is not inner and local(inner) in ALL_FIELDS and canonical(first) != canonical(inner):
                    raise source.error(f"<{local(inner)}> occurs here twice, with different content", inner)
        elif tool == OWN:
            if block.get("version") != OWN_VERSION:
                hint = "it was written by a newer DiNeROS"
                raise source.error(
                    f"version {block.get('version')!r} of the block of DiNeROS", block, hint=hint
                )
            extension.own = child(block, "element")
    return extension


def _page_kind(page: PageRecord, tag_name: str, source: Source) -> str:
    kind = page.extension.text("type")
    if kind == NODE_PAGE or (kind is None and tag_name == "nodePage"):
        return "node"
    if kind in CALLBACK_TYPES and tag_name != "nodePage":
        return "callback"
    if kind is not None:
        known = [NODE_PAGE, *CALLBACK_TYPES]
        hint = near_matches(kind, known) or f"types are {', '.join(known)}"
        raise source.error(
            f"{kind!r} is not a type of a page", page.extension.fields["type"], id=page.id, hint=hint
        )
    return {"sym.NodeNet": "node", "sym.CallbackPage": "callback"}.get(
        page.extension.mark("class") or "", "page"
    )


def _transition_kind(node: NodeRecord, source: Source) -> str:
    kind = node.extension.text("type")
    if kind is not None and kind not in (*_CHANNELS, *TRANSITION_TYPES):
        known = [*TRANSITION_TYPES, *_CHANNELS]
        hint = near_matches(kind, known) or f"types are {', '.join(known)}"
        where = node.extension.fields["type"]
        raise source.error(f"{kind!r} is not a type of a transition", where, id=node.id, hint=hint)
    return _CHANNELS.get(kind or "", "transition")
