"""Reading the structure of a PNML file (ISO/IEC 15909-2): pages, nodes, references and arcs, as records."""

from __future__ import annotations

from lxml import etree

from dineros.metamodel.errors import near_matches
from dineros.metamodel.files.pnml.records import (
    ArcRecord,
    Extension,
    NetRecord,
    NodeRecord,
    PageRecord,
    Record,
)
from dineros.metamodel.files.pnml.source import Source, canonical, child, children, local, text_of
from dineros.metamodel.files.pnml.vocabulary import (
    ACTION,
    ALL_FIELDS,
    CALLBACK_TYPES,
    DINEROS,
    NODE_PAGE,
    OWN,
    OWN_VERSION,
    PNML,
    PTNET,
    SERVICE,
    TOPIC,
    TRANSITION_TYPES,
    VERSIONS,
    tag,
)
from dineros.metamodel.files.xml import line_of

_CHANNELS = {TOPIC: "topic", SERVICE: "service", ACTION: "action"}
_PARTS = {
    "net": {"name", "graphics", "toolspecific", "page", "nodePage"},
    "page": {
        "name", "graphics", "toolspecific", "page", "nodePage",
        "place", "transition", "referencePlace", "referenceTransition", "arc",
    },
    "place": {"name", "graphics", "toolspecific", "initialMarking"},
    "transition": {"name", "graphics", "toolspecific"},
    "referencePlace": {"name", "graphics", "toolspecific"},
    "referenceTransition": {"name", "graphics", "toolspecific"},
    "arc": {"name", "graphics", "toolspecific", "inscription", "type"},
}  # fmt: skip


def read_records(root: etree._Element, source: Source) -> NetRecord:
    """Read the one net of a file.

    Raises
    ------
    ModelFileError
        The file is no PNML file of one P/T net, an element has no id or one that is taken, or holds something
        that a P/T net does not have.
    """
    net = _only_net(root, source)
    record = PageRecord(_id(net, source), net, None, _extension(net, source), kind="net")
    result = NetRecord(record)
    result.ids[record.id] = record
    stack = [record]
    while stack:
        page = stack.pop()
        inner = _read_page(page, result, source)
        stack.extend(inner[::-1])
    if not record.objects:
        raise source.error("the net has no page", net, hint="put its elements into a <page>")
    result.extended = any(each.extension.blocks for each in [*result.ids.values(), *result.arcs])
    for node in record.nodes():
        if node.ref is not None:
            _check_reference(node, result, source)
    return result


def _only_net(root: etree._Element, source: Source) -> etree._Element:
    if root.tag != tag("pnml"):
        hint = f'the root is <pnml xmlns="{PNML}">'
        raise source.error(f"is not PNML: the root is <{local(root)}>{_namespace(root)}", root, hint=hint)
    nets = [inner for inner in children(root) if _core(inner, "net")]
    if len(nets) != 1:
        where = nets[1] if nets else root
        raise source.error(f"holds {len(nets) or 'no'} nets", where, hint="a model is one <net>")
    kind = source.attribute(nets[0], "type").strip()
    if kind != PTNET:
        raise source.error(f"the net type {kind!r} is not supported", nets[0], hint=f"P/T nets are {PTNET}")
    return nets[0]


def _namespace(xml: etree._Element) -> str:
    namespace = etree.QName(xml).namespace
    return f" in the namespace {namespace!r}" if namespace else " without a namespace"


def _core(xml: etree._Element, name: str) -> bool:
    return bool(xml.tag == tag(name))


def _id(xml: etree._Element, source: Source) -> str:
    return source.attribute(xml, "id")


def _read_page(page: PageRecord, net: NetRecord, source: Source) -> list[PageRecord]:
    assert page.xml is not None
    inner: list[PageRecord] = []
    allowed = _PARTS["net" if page.kind == "net" else "page"]
    for xml in children(page.xml):
        kind = local(xml)
        _check_part(xml, allowed, page.xml, source)
        if kind == "name":
            page.name = text_of(xml) or page.name
        elif kind in ("page", "nodePage"):
            record = PageRecord(_id(xml, source), xml, page, _extension(xml, source))
            record.kind = _page_kind(record, kind, source)
            record.name = (record.extension.mark("name") or "").strip() or None
            inner.append(record)
            page.objects.append(record)
            _register(record, net, source)
        elif kind == "arc":
            ends = source.attribute(xml, "source"), source.attribute(xml, "target")
            arc = ArcRecord(_id(xml, source), xml, page, _extension(xml, source), *ends)
            net.arcs.append(arc)
            _register(arc, net, source)
        elif kind in _PARTS:
            node = NodeRecord(_id(xml, source), xml, page, _extension(xml, source), kind)
            if kind.startswith("reference"):
                node.ref = source.attribute(xml, "ref")
            elif kind == "transition":
                node.kind = _transition_kind(node, source)
            page.objects.append(node)
            _register(node, net, source)
        if kind in _PARTS and kind not in ("net", "page"):
            for part in children(xml):
                _check_part(part, _PARTS[kind], xml, source)
    return inner


def _check_part(xml: etree._Element, allowed: set[str], outer: etree._Element, source: Source) -> None:
    if local(xml) not in allowed or not _core(xml, local(xml)):
        near = near_matches(local(xml), allowed)
        hint = near or "what other tools need belongs into a <toolspecific> block"
        raise source.error(f"<{local(xml)}> is no part of the <{local(outer)}> of a P/T net", xml, hint=hint)


def _register(record: Record, net: NetRecord, source: Source) -> None:
    first = net.ids.setdefault(record.id, record)
    if first is not record:
        line = line_of(first.xml) if first.xml is not None else "?"
        raise source.error(f"the id {record.id!r} is taken", record.xml, id=record.id, hint=f"by line {line}")


def _check_reference(node: NodeRecord, net: NetRecord, source: Source) -> None:
    target = net.ids.get(node.ref or "")
    wanted = "place" if node.is_place else "transition"
    if target is None:
        known = [each.id for each in net.root.nodes() if each.is_place == node.is_place]
        hint = near_matches(node.ref or "", known)
        raise source.error(
            f"{node.id!r} refers to {node.ref!r}, which is not there", node.xml, id=node.id, hint=hint
        )
    if not isinstance(target, NodeRecord) or target.is_channel or target.is_place != node.is_place:
        raise source.error(f"{node.id!r} refers to {node.ref!r}, which is no {wanted}", node.xml, id=node.id)


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
                    raise source.error(f"<{local(inner)}> stands here twice, and differs", inner)
        elif tool == OWN:
            if block.get("version") != OWN_VERSION:
                hint = "it was written by a newer DiNeROS"
                raise source.error(f"version {block.get('version')!r} of our own block", block, hint=hint)
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
            f"{kind!r} is no type of a page", page.extension.fields["type"], id=page.id, hint=hint
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
        raise source.error(f"{kind!r} is no type of a transition", where, id=node.id, hint=hint)
    return _CHANNELS.get(kind or "", "transition")
