"""Writing Romeo's ``.xml``: places and transitions by number, then arcs."""

from __future__ import annotations

from pathlib import Path

from lxml import etree

from dineros.metamodel import pn
from dineros.metamodel.elements import label
from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files.romeo.net_of_romeo import NetOfRomeo
from dineros.metamodel.files.schema import number_text
from dineros.metamodel.files.tina.writer import Flow, flows_of

_TYPES = {
    "normal": "PlaceTransition",
    "output": "TransitionPlace",
    "read": "read",
    "inhibitor": "logicalInhibitor",
}


def net_content(net: pn.Net, path: Path | None = None) -> bytes:
    """Return a net in Romeo's format; `path` is named in messages.

    Identifiers are the ids, with ``_`` for characters that Romeo does not take; labels are the names, or ids.

    Raises
    ------
    ModelFileError
        The net holds what the format cannot say.
    DinerosError
        A reference has no target, or references run in a circle.
    """
    return _RomeoWriter(net, path).content()


class _RomeoWriter(NetOfRomeo):
    def content(self) -> bytes:
        net = self._net
        root = etree.Element("romeo", version="Romeo v3.9.0")
        xml = etree.SubElement(root, "TPN", name=label(net))
        all_places, all_transitions = self._places, self._transitions
        ranks = self._ranks()
        flows = flows_of(net)
        try:
            for number, place in enumerate(all_places, 1):
                self._place(xml, place, number)
            for number, transition in enumerate(all_transitions, 1):
                self._transition(xml, transition, number, ranks[number - 1])
        except ValueError as error:  # lxml refuses control characters
            raise ModelFileError(
                "the net has text with characters that XML cannot hold", location=self._location
            ) from error
        numbers = {place: number for number, place in enumerate(all_places, 1)}
        for number, transition in enumerate(all_transitions, 1):
            self._arcs(xml, flows[transition], numbers, number)
        etree.indent(root)
        text: bytes = etree.tostring(root, xml_declaration=True, encoding="UTF-8")
        return text + b"\n"

    def _place(self, net: etree._Element, place: pn.Place, number: int) -> None:
        xml = self._node(net, place, number)
        xml.set("initialMarking", str(place.tokens))
        xml.set("eft", "0")
        xml.set("lft", "inf")
        _drawn(xml, place)
        etree.SubElement(xml, "scheduling", gamma="0", omega="0")

    def _transition(self, net: etree._Element, transition: pn.Transition, number: int, rank: int) -> None:
        interval = transition.interval or pn.TimeInterval()
        xml = self._node(net, transition, number)
        xml.set("eft", self._bound(transition, interval.earliest))
        xml.set("eftIncl", "0" if interval.earliestExcluded else "1")
        xml.set("lft", "inf" if interval.latest is None else self._bound(transition, interval.latest))
        xml.set("lftIncl", "0" if interval.latest is not None and interval.latestExcluded else "1")
        for name, value in (("speed", "1"), ("priority", str(rank)), ("cost", "0"), ("unctrl", "0")):
            xml.set(name, value)
        xml.set("obs", "1")
        xml.set("guard", "")
        _drawn(xml, transition)
        etree.SubElement(xml, "update")

    def _node(self, net: etree._Element, node: pn.Place | pn.Transition, number: int) -> etree._Element:
        kind = "place" if isinstance(node, pn.Place) else "transition"
        xml = etree.SubElement(net, kind, id=str(number), identifier=self._identifier(node.id))
        xml.set("label", node.name or node.id)
        return xml

    def _arcs(self, net: etree._Element, flow: Flow, numbers: dict[pn.Place, int], transition: int) -> None:
        for (place, kind), own in flow.items():
            weight = own + flow.get((place, "normal"), 0) if kind == "read" else own
            xml = etree.SubElement(
                net,
                "arc",
                place=str(numbers[place]),
                transition=str(transition),
                type=_TYPES[kind],
                weight=str(weight),
                tokenColor="-1",
            )
            if kind != "output":
                xml.set("inhibitingCondition", "")
            etree.SubElement(xml, "nail", xnail="0", ynail="0")
            etree.SubElement(xml, "graphics", color="0")


def _drawn(xml: etree._Element, node: pn.Node) -> None:
    """Add where a node is drawn, if it has a position."""
    graphics = etree.SubElement(xml, "graphics", color="0")
    if node.graphics is not None and len(node.graphics.positions):
        point = node.graphics.positions[0]
        etree.SubElement(graphics, "position", x=number_text(point.x), y=number_text(point.y))
        etree.SubElement(graphics, "deltaLabel", deltax="10", deltay="10")
