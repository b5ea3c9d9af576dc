"""Reading Romeo's ``.xml``: elements are checked one by one, then made a net."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from lxml import etree

from dineros.metamodel import pn
from dineros.metamodel.errors import Location, ModelFileError
from dineros.metamodel.files.exact import exact_number, fraction_of
from dineros.metamodel.files.romeo.refusing import Attributes, refuse_extras
from dineros.metamodel.files.xml import line_of, parse_bytes
from dineros.metamodel.positions import remember

_Element = TypeVar("_Element", bound=pn.Element)
_Node = TypeVar("_Node", pn.Place, pn.Transition)
_BLANK = re.compile(r"\s+")
_EMPTY_ROOT = re.compile(rb"<romeo\b[^<>]*?(?:/>|>\s*</romeo\s*>)")
_UNBOUNDED = frozenset({"inf", "infini", "infinity", "infinite"})
_ARCS = {
    "PlaceTransition": pn.ArcKind.normal,
    "TransitionPlace": pn.ArcKind.normal,
    "read": pn.ArcKind.read,
    "logicalInhibitor": pn.ArcKind.inhibitor,
}
_REFUSED_ARCS = {
    "timedInhibitor": "it stops the clock of its transition, and nets have no stopwatches",
    "flush": "it takes all tokens of its place, which arcs cannot say",
}


@dataclass(slots=True)
class _Given:
    """An arc as the file has it."""

    xml: etree._Element
    type: str
    place: pn.Place
    transition: pn.Transition
    weight: int

    @property
    def line(self) -> int | None:
        """Where it stands."""
        return line_of(self.xml)


def net_from_content(content: bytes, path: Path) -> pn.Net:
    """Return the net that the content of a Romeo file describes, on one page.

    Ids are the identifiers in the file, or labels where a file of an old version has none.

    Raises
    ------
    ModelFileError
        The file is not in this format, or holds what a time Petri net cannot; with line.
    """
    # Versions 3.6 to 3.8 close <romeo> before <TPN>, so the file has two roots. Lines must stay.
    lone = _EMPTY_ROOT.search(content[:4096])
    if lone is not None and b"<TPN" in content[lone.end() :]:
        blank = re.sub(rb"[^\n]", b" ", lone[0])
        content = content[: lone.start()] + blank + content[lone.end() :]
    root = parse_bytes(content, path).getroot()
    net = root.find("TPN") if root.tag == "romeo" else root
    if net is None or net.tag != "TPN":
        name = str(root.tag).rpartition("}")[2]
        hint = "rename the file to .pnml" if name == "pnml" else "nets of Romeo are <TPN>, or <romeo>"
        raise ModelFileError(
            f"is not a net of Romeo: its root is <{name}>", location=Location(path, line_of(root)), hint=hint
        )
    second = net.getnext() if net is not root else None
    while second is not None and second.tag != "TPN":
        second = second.getnext()
    if second is not None:
        raise ModelFileError(
            "holds two nets", location=Location(path, line_of(second)), hint="a model is one <TPN>"
        )
    return _RomeoReader(net, path).read()


class _RomeoReader:
    def __init__(self, xml: etree._Element, path: Path) -> None:
        self._xml = xml
        self._path = path
        self._names: set[str] = set()

    def read(self) -> pn.Net:
        refuse_extras(self._xml, self._path)
        net, page = self._net()
        places: dict[str, pn.Place] = {}
        transitions: dict[str, pn.Transition] = {}
        ranks: dict[pn.Transition, int] = {}
        given: list[_Given] = []
        for xml in self._xml.iterchildren("place"):
            self._known(places, xml, self._place(xml))
        for xml in self._xml.iterchildren("transition"):
            attributes = Attributes(xml, self._path)
            transition = self._transition(attributes)
            self._known(transitions, xml, transition)
            ranks[transition] = attributes.integer("priority", 0, 0)
        for xml in self._xml.iterchildren("arc"):
            given.append(self._given(Attributes(xml, self._path), places, transitions))
        page.objects.extend([*places.values(), *transitions.values()])
        page.arcs.extend(self._arcs(given))
        for high, rank in ranks.items():
            high.overrides.extend(low for low, other in ranks.items() if other < rank)
        return net

    def _net(self) -> tuple[pn.Net, pn.Page]:
        # Romeo names a net by the path of its file.
        title = Path((self._xml.get("name") or "").replace("\\", "/")).stem.strip() or self._path.stem
        net = pn.Net(id=self._identifier(title or "net"))
        if title and title != net.id:
            net.name = title
        page = pn.Page(id="page" if net.id != "page" else "page_2", net=net)
        self._names.add(page.id)
        return net, page

    def _place(self, xml: etree._Element) -> pn.Place:
        attributes = Attributes(xml, self._path)
        attributes.refuse_place()
        tokens = attributes.integer("initialMarking", 0, 0)
        id, name = self._called(xml, "P")
        return self._node(pn.Place(id=id, name=name, tokens=tokens), xml)

    def _transition(self, attributes: Attributes) -> pn.Transition:
        attributes.refuse_transition()
        id, name = self._called(attributes.xml, "T")
        transition = pn.Transition(id=id, name=name)
        interval = self._interval(attributes)
        is_free = interval.latest is None and not interval.earliest and not interval.earliestExcluded
        if not is_free:
            transition.interval = interval
        return self._node(transition, attributes.xml)

    def _interval(self, attributes: Attributes) -> pn.TimeInterval:
        low, high = (attributes.text(name) for name in ("eft", "lft"))
        low_open, high_open = (not attributes.flag(name) for name in ("eftIncl", "lftIncl"))
        earliest = self._bound(attributes, "eft", low)
        if high.lower() in _UNBOUNDED:
            return pn.TimeInterval(earliest=earliest, earliestExcluded=low_open)
        latest = self._bound(attributes, "lft", high)
        order = fraction_of(latest) - fraction_of(earliest)
        if order < 0 or (not order and (low_open or high_open)):
            raise attributes.error(f"the interval from {low} to {high} is empty")
        return pn.TimeInterval(
            earliest=earliest, latest=latest, earliestExcluded=low_open, latestExcluded=high_open
        )

    def _bound(self, attributes: Attributes, name: str, text: str) -> float:
        try:
            bound = exact_number(text)
        except ValueError:
            hint = "parameters are not read: parametric nets are not analysed"
            raise attributes.error(f"{name} is a number, not {text[:40]!r}", hint) from None
        if bound < 0:
            raise attributes.error(f"{name} is {text}, and an interval begins at 0 or later")
        return bound

    def _given(
        self, attributes: Attributes, places: dict[str, pn.Place], transitions: dict[str, pn.Transition]
    ) -> _Given:
        kind = attributes.text("type")
        if kind not in _ARCS:
            known = f"types are {', '.join(_ARCS)}"
            raise attributes.error(
                f"an arc of type {kind[:40]!r} is not read", _REFUSED_ARCS.get(kind, known)
            )
        attributes.refuse_arc()
        ends = []
        for name, known_nodes in (("place", places), ("transition", transitions)):
            node = known_nodes.get(attributes.text(name))
            if node is None:
                missing = f"{name} {attributes.text(name)[:40]!r}"
                raise attributes.error(f"the arc names {missing}, which does not exist")
            ends.append(node)
        place, transition = ends
        assert isinstance(place, pn.Place) and isinstance(transition, pn.Transition)
        return _Given(attributes.xml, kind, place, transition, attributes.integer("weight", 1, 1))

    def _arcs(self, given: list[_Given]) -> list[pn.Arc]:
        seen: dict[tuple[str, str, str], _Given] = {}
        for each in given:
            key = (each.type, each.place.id, each.transition.id)
            if key in seen:
                both = f"place {each.place.id} and transition {each.transition.id}"
                message = f"two arcs of type {each.type} join {both}; the other is on line {seen[key].line}"
                raise Attributes(each.xml, self._path).error(message, "their weights may or may not add up")
            seen[key] = each
        made = []
        for (kind, place, transition), each in seen.items():
            weight = each.weight
            if kind == "read":
                taken = seen.get(("PlaceTransition", place, transition))
                weight -= 0 if taken is None else taken.weight
            if weight < 1:
                continue  # what it takes already asks for as much as it reads
            source, target = each.place, each.transition
            ends = (target, source) if kind == "TransitionPlace" else (source, target)
            suffix = "" if _ARCS[kind] is pn.ArcKind.normal else f"-{_ARCS[kind]}"
            arc = pn.Arc(
                id=self._identifier(f"{ends[0].id}-{ends[1].id}{suffix}"),
                source=ends[0],
                target=ends[1],
                weight=weight,
                kind=_ARCS[kind],
            )
            made.append(self._placed(arc, each.xml))
        return made

    def _node(self, node: _Node, xml: etree._Element) -> _Node:
        position = xml.find("graphics/position")
        if position is not None:
            x, y = (self._coordinate(Attributes(position, self._path), axis) for axis in ("x", "y"))
            node.graphics = pn.Graphics(positions=[pn.Point(x=x, y=y)])
        return self._placed(node, xml)

    def _coordinate(self, attributes: Attributes, axis: str) -> float:
        try:
            return exact_number(attributes.text(axis))
        except ValueError as error:
            raise attributes.error(f"{axis} {error}, not {attributes.text(axis)[:40]!r}") from None

    # Names -------------------------------------------------------------------------------------------------

    def _called(self, xml: etree._Element, letter: str) -> tuple[str, str | None]:
        """Return id and name: identifier and label, or the label alone in files of old versions."""
        label = (xml.get("label") or "").strip()
        identifier = (xml.get("identifier") or "").strip() or label or f"{letter}{xml.get('id', '')}"
        id = self._identifier(identifier)
        name = label or identifier
        return id, (name if name != id else None)

    def _identifier(self, name: str) -> str:
        stem = _BLANK.sub("_", name) or "_"
        identifier, number = stem, 1
        while identifier in self._names:
            number += 1
            identifier = f"{stem}_{number}"
        self._names.add(identifier)
        return identifier

    def _known(self, nodes: dict[str, _Element], xml: etree._Element, node: _Element) -> None:
        number = Attributes(xml, self._path).text("id")
        if nodes.setdefault(number, node) is not node:
            raise Attributes(xml, self._path).error(f"the id {number[:40]!r} is taken by another {xml.tag}")

    def _placed(self, element: _Element, xml: etree._Element) -> _Element:
        remember(element, Location(self._path, line_of(xml)))
        return element
