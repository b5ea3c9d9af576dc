"""Writing PNML (ISO/IEC 15909-2), with the DiNeROS extension and our own blocks where they are needed."""

from __future__ import annotations

from lxml import etree

from dineros.metamodel import elements, pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.errors import Location, ModelFileError
from dineros.metamodel.files.pnml.build import expected_class
from dineros.metamodel.files.pnml.delays import TestArcs, write_delay
from dineros.metamodel.files.pnml.layout import Layout
from dineros.metamodel.files.pnml.own import block, class_name, encode
from dineros.metamodel.files.pnml.source import LARGEST, local
from dineros.metamodel.files.pnml.vocabulary import EDITOR, NAMESPACES, OWN, PTNET, Version, tag
from dineros.metamodel.files.pnml.write_extension import ExtensionWriter

_CHANNELS: dict[type[sym.Channel], str] = {
    sym.TopicChannel: "topic",
    sym.ServiceChannel: "service",
    sym.ActionChannel: "action",
}
_DEEPEST = 240  # readers stop at 256 levels of XML


class Writer:
    """Writes one net."""

    def __init__(self, net: pn.Net, version: Version) -> None:
        self._net = net
        self._known: dict[str, pn.Element] = {}
        self._frozen: list[etree._Element] = []
        self._current: pn.Element = net
        self._test_arcs = TestArcs(net)
        self._extension = ExtensionWriter(version, self._refer)

    def content(self) -> bytes:
        """Return the bytes of the file.

        Raises
        ------
        ModelFileError
            The net has no page, an element has no id or one that is taken, a reference leads out of the net,
            a value cannot be read again, or a text holds characters that XML does not have.
        """
        for element in elements.elements(self._net):
            self._register(element)
        try:
            root = self._root()
        except ValueError as error:  # lxml refuses control characters
            raise self._error("has text with characters that XML cannot hold", self._current) from error
        _indent(root, set(self._frozen))
        text: bytes = etree.tostring(root, xml_declaration=True, encoding="UTF-8")
        return text + b"\n"

    def _error(self, message: str, element: pn.Element, hint: str | None = None) -> ModelFileError:
        from dineros.metamodel.positions import location_of

        what = f"{type(element).__name__} {element.id!r} {message}"
        return ModelFileError(
            what, location=location_of(element) or Location(), element=element.id, hint=hint
        )

    def _register(self, element: pn.Element) -> None:
        if not element.id or element.id != element.id.strip():
            raise self._error(
                "has no id that PNML can hold", element, "give it an id without spaces around it"
            )
        if self._known.setdefault(element.id, element) is not element:
            raise self._error("has the id of another element", element, "ids are unique in a file")

    def _refer(self, element: EObject) -> str:
        id: str | None = getattr(element, "id", None)
        if id is None or self._known.get(id) is not element:
            raise self._error(f"refers to {id!r}, which is not in the net", self._current)
        return id

    def _root(self) -> etree._Element:
        net = self._net
        if not len(net.pages):
            raise self._error("has no page", net, "PNML nets have pages; use .xmi or add a page")
        root = etree.Element(tag("pnml"), nsmap=NAMESPACES)
        xml = etree.SubElement(root, tag("net"), id=net.id, type=PTNET)
        layout = self._head(xml, net)
        self._extension.net(xml, net)
        self._extension.wrote |= layout.extended
        at = len(xml)
        layout.foreign(xml)
        pages: list[tuple[pn.Page, etree._Element, int]] = []
        for page in net.pages:
            pages.append((page, etree.SubElement(xml, tag("page"), id=page.id), 3))
        channels = self._channels_by_canvas()
        pages.reverse()
        while pages:
            page, inside, depth = pages.pop()
            if depth > _DEEPEST:
                raise self._error("is nested too deep", page, "use fewer pages inside pages")
            pages.extend(self._page(page, inside, depth, channels.get(page, []))[::-1])
        self._net_block(xml, layout.said, at)
        return root

    def _channels_by_canvas(self) -> dict[pn.Page, list[sym.Channel]]:
        canvases: dict[pn.Page, list[sym.Channel]] = {}
        for channel in self._net.channels if isinstance(self._net, sym.SystemModel) else ():
            self._current = channel
            if channel.canvas is not None:
                self._refer(channel.canvas)
            canvases.setdefault(channel.canvas or self._net.pages[0], []).append(channel)
        return canvases

    def _net_block(self, xml: etree._Element, said: set[str], at: int) -> None:
        """Add our block to the net, once it is known whether the extension marks it as a system model."""
        net = self._net
        self._current = net
        expected: type[pn.Net] = sym.SystemModel if self._extension.wrote else pn.Net
        own = self._own(xml, net, said | {"pages", "channels"}, expected)
        if isinstance(net, sym.SystemModel):
            written = [
                each for page in elements.pages(net) for each in self._channels_by_canvas().get(page, [])
            ]
            if written != list(net.channels):
                for channel in net.channels:
                    own = block(xml) if own is None else own
                    etree.SubElement(own, tag("channels"), ref=channel.id)
        if own is not None:
            outer = own.getparent()
            assert outer is not None
            xml.insert(at, outer)

    def _page(
        self, page: pn.Page, xml: etree._Element, depth: int, channels: list[sym.Channel]
    ) -> list[tuple[pn.Page, etree._Element, int]]:
        self._finish(xml, page, self._head(xml, page), {"objects", "arcs"}, "page")
        inner = []
        for element in page.objects:
            self._current = element
            if isinstance(element, pn.Page):
                inner.append((element, etree.SubElement(xml, tag("page"), id=element.id), depth + 1))
            elif isinstance(element, pn.Node):
                self._node(element, xml)
        for channel in channels:
            inside = etree.SubElement(xml, tag("transition"), id=channel.id)
            kind = _CHANNELS[type(channel)]
            layout = self._head(inside, channel)
            own = self._finish(inside, channel, layout, {"canvas"}, kind)
            if channel.canvas is None:
                (block(inside) if own is None else own).set("canvas", "")
        for arc in page.arcs:
            self._arc(arc, xml)
        return inner

    def _node(self, node: pn.Node, page: etree._Element) -> None:
        if isinstance(node, pn.Place):
            xml = etree.SubElement(page, tag("place"), id=node.id)
            layout = self._head(xml, node, "initialMarking")
            balloons = isinstance(node, sym.Place) and len(node.balloons)
            if node.tokens or balloons or layout.has_label("initialMarking"):
                layout.text(xml, "initialMarking", self._number(node.tokens, node, "tokens", 0))
            self._finish(xml, node, layout, {"tokens"}, "place")
        elif isinstance(node, pn.Transition):
            xml = etree.SubElement(page, tag("transition"), id=node.id)
            layout = self._head(xml, node)
            said = set() if self._extension.says_interval(node) else write_delay(xml, node)
            self._finish(xml, node, layout, said, "transition")
        elif isinstance(node, (pn.ReferencePlace, pn.ReferenceTransition)):
            kind = "referencePlace" if isinstance(node, pn.ReferencePlace) else "referenceTransition"
            xml = etree.SubElement(page, tag(kind), id=node.id, ref=self._refer(node.target))
            self._finish(xml, node, self._head(xml, node), {"target"}, kind)

    def _arc(self, arc: pn.Arc, page: etree._Element) -> None:
        self._current = arc
        source, target = self._refer(arc.source), self._refer(arc.target)
        weight = self._number(arc.weight, arc, "weight", 1)
        xml = etree.SubElement(page, tag("arc"), id=arc.id, source=source, target=target)
        layout = self._head(xml, arc, "inscription")
        if arc.weight != 1 or layout.has_label("inscription"):
            layout.text(xml, "inscription", weight)
        if str(arc.kind) == "inhibitor":  # said in the three forms that tools look for
            xml.set("type", "inhibitor")
            etree.SubElement(xml, tag("type"), value="inhibitor")
            etree.SubElement(xml, tag("toolspecific"), tool=EDITOR, version="1.0", type="inhibitor")
        is_test = arc in self._test_arcs
        if is_test:
            etree.SubElement(xml, tag("type"), value="test")
        said = {"source", "target", "weight"} | ({"kind"} if is_test or str(arc.kind) != "read" else set())
        self._finish(xml, arc, layout, said, "arc")
        if str(arc.kind) == "read" and not is_test:
            # A pair of normal arcs is right for every reader; our blocks join it again.
            self._half(arc, page, weight)

    def _half(self, arc: pn.Arc, page: etree._Element, weight: str) -> None:
        number, id = 1, f"{arc.id}.back"
        while id in self._known:
            number += 1
            id = f"{arc.id}.back.{number}"
        self._known[id] = arc
        source, target = self._refer(arc.target), self._refer(arc.source)
        xml = etree.SubElement(page, tag("arc"), id=id, source=source, target=target)
        if arc.weight != 1:
            etree.SubElement(etree.SubElement(xml, tag("inscription")), tag("text")).text = weight
        block(xml).set("half", arc.id)

    def _number(self, value: int, element: pn.Element, what: str, minimum: int) -> str:
        if not minimum <= value <= LARGEST:
            raise self._error(f"has {value} {what}", element, f"{what} may be from {minimum} to {LARGEST}")
        return str(value)

    def _head(self, xml: etree._Element, element: pn.Element, *texts: str) -> Layout:
        self._current = element
        layout = Layout(element, self._frozen, texts)
        layout.head(xml)
        return layout

    def _finish(
        self, xml: etree._Element, element: pn.Element, layout: Layout, said: set[str], kind: str
    ) -> etree._Element | None:
        """Add the blocks: the extension's, ours, and those of other tools."""
        self._extension.wrote |= layout.extended
        count = len(xml)
        said = said | layout.said | self._extension.element(xml, element)
        record = self._extension.kind(element, kind)
        extended = len(xml) > count or layout.extended
        expected = expected_class(record, extended, type(self._net))
        own = self._own(xml, element, said, expected)
        layout.foreign(xml)
        return own

    def _own(
        self, xml: etree._Element, element: pn.Element, said: set[str], expected: type[pn.Element]
    ) -> etree._Element | None:
        own = block(xml)
        if type(element) is not expected:
            own.set("class", class_name(type(element)))
        for name, value in self._extension.marks(element).items():
            own.set(name, value)
        encode(own, element, said, self._refer)
        if len(own) or own.attrib:
            return own
        outer = own.getparent()
        assert outer is not None and outer.get("tool") == OWN
        xml.remove(outer)
        return None


def _indent(root: etree._Element, frozen: set[etree._Element]) -> None:
    """Put every element on a line of its own, but leave blocks of other tools and plain text alone."""
    stack = [(root, 0)]
    while stack:
        xml, depth = stack.pop()
        if not len(xml) or xml in frozen:
            continue
        if local(xml) in ("name", "initialMarking", "inscription", "cn") and len(xml) == 1:
            continue
        inner = list(xml)
        xml.text = "\n" + "  " * (depth + 1)
        for each in inner:
            each.tail = xml.text
            stack.append((each, depth + 1))
        inner[-1].tail = "\n" + "  " * depth
