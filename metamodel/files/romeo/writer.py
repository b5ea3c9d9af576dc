"""Writing Romeo's ``.xml``: places and transitions by number, then arcs."""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import isfinite
from pathlib import Path

from lxml import etree

from dineros.metamodel import pn, sym
from dineros.metamodel.elements import label, places, transitions
from dineros.metamodel.errors import Location, ModelFileError
from dineros.metamodel.files.exact import decimal_text, fraction_of
from dineros.metamodel.files.schema import number_text
from dineros.metamodel.files.tina.writer import Flow, flows_of

_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_NOT_PLAIN = re.compile(r"[^A-Za-z0-9_]")
_TYPES = {
    "normal": "PlaceTransition",
    "output": "TransitionPlace",
    "read": "read",
    "inhibitor": "logicalInhibitor",
}


def net_content(net: pn.Net, path: Path | None = None) -> bytes:
    """Return a net in Romeo's format; `path` stands in messages.

    Identifiers are the ids, with ``_`` for characters that Romeo does not take; labels are the names, or ids.

    Raises
    ------
    ModelFileError
        The net holds what the format cannot say (see `write_romeo`).
    """
    return _RomeoWriter(net, Location(path)).content()


class _RomeoWriter:
    def __init__(self, net: pn.Net, location: Location) -> None:
        self._net = net
        self._location = location
        self._names: set[str] = set()

    def content(self) -> bytes:
        net = self._net
        if isinstance(net, sym.SystemModel) and len(net.channels):
            raise ModelFileError(
                "a system model with channels cannot be written for Romeo",
                location=self._location,
                hint="flatten it first",
            )
        root = etree.Element("romeo", version="Romeo v3.9.0")
        xml = etree.SubElement(root, "TPN", name=label(net))
        all_places, all_transitions = list(places(net)), list(transitions(net))
        ranks = self._ranks(all_transitions)
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

    def _error(self, node: pn.Node, what: str, hint: str) -> ModelFileError:
        kind = "place" if isinstance(node, pn.Place) else "transition"
        return ModelFileError(
            f"{kind} {node.id!r} {what}", location=self._location, element=node.id, hint=hint
        )

    def _place(self, net: etree._Element, place: pn.Place, number: int) -> None:
        if place.capacity is not None:
            raise self._error(place, "has a capacity, which Romeo cannot say", "use .pnml, or .xmi")
        xml = self._node(net, place, number)
        xml.set("initialMarking", str(place.tokens))
        xml.set("eft", "0")
        xml.set("lft", "inf")
        _drawn(xml, place)
        etree.SubElement(xml, "scheduling", gamma="0", omega="0")

    def _transition(self, net: etree._Element, transition: pn.Transition, number: int, rank: int) -> None:
        if isinstance(transition, sym.Transition) and transition.clause is not None:
            raise self._error(transition, "has a clause, which Romeo cannot say", "flatten the model first")
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

    def _bound(self, transition: pn.Transition, bound: float) -> str:
        if not isfinite(bound) or bound < 0:
            raise self._error(
                transition, f"has an interval with the bound {bound}", "bounds are numbers from 0"
            )
        exact = fraction_of(bound)
        text = decimal_text(exact)
        return f"{exact.numerator}/{exact.denominator}" if text is None else text

    def _node(self, net: etree._Element, node: pn.Place | pn.Transition, number: int) -> etree._Element:
        kind = "place" if isinstance(node, pn.Place) else "transition"
        xml = etree.SubElement(net, kind, id=str(number), identifier=self._identifier(node.id))
        xml.set("label", node.name or node.id)
        return xml

    def _identifier(self, id: str) -> str:
        stem = id if _PLAIN.fullmatch(id) else _NOT_PLAIN.sub("_", id if id[:1].isalpha() else f"_{id}")
        identifier, number = stem, 1
        while identifier in self._names:
            number += 1
            identifier = f"{stem}_{number}"
        self._names.add(identifier)
        return identifier

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

    def _ranks(self, ordered: Sequence[pn.Transition]) -> list[int]:
        """Return a number by transition: higher ones go before all lower ones, as priorities say."""
        below = [_below(transition) for transition in ordered]
        ranks: dict[pn.Transition, int] = {}
        for transition, under in sorted(
            zip(ordered, below, strict=True), key=lambda pair: (len(pair[1]), ordered.index(pair[0]))
        ):
            if transition in under:
                raise self._error(transition, "has priority over itself", "break the circle of priorities")
            ranks[transition] = 1 + max((ranks[low] for low in under), default=-1)
        for transition, under in zip(ordered, below, strict=True):
            for other in ordered:
                if (ranks[other] < ranks[transition]) != (other in under):
                    hint = f"give one of {transition.id} and {other.id} priority over the other, or neither"
                    what = "has priorities that Romeo's numbers, which order all transitions, cannot say"
                    raise self._error(transition, what, hint)
        return [ranks[transition] for transition in ordered]


def _below(transition: pn.Transition) -> set[pn.Transition]:
    """Return what a transition has priority over, directly or through others."""
    found: set[pn.Transition] = set()
    todo = list(transition.overrides)
    while todo:
        low = todo.pop()
        if low not in found:
            found.add(low)
            todo.extend(low.overrides)
    return found


def _drawn(xml: etree._Element, node: pn.Node) -> None:
    """Add where a node is drawn, if it has a position."""
    graphics = etree.SubElement(xml, "graphics", color="0")
    if node.graphics is not None and len(node.graphics.positions):
        point = node.graphics.positions[0]
        etree.SubElement(graphics, "position", x=number_text(point.x), y=number_text(point.y))
        etree.SubElement(graphics, "deltaLabel", deltax="10", deltay="10")
