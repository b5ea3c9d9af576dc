"""Moves elements between pages, by commands; arcs follow, with reference places if needed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from dineros.metamodel import pn
from dineros.metamodel.base import EObject
from dineros.metamodel.constraints.wording import describe
from dineros.metamodel.editing import commands as c
from dineros.metamodel.editing.handles import Handles
from dineros.metamodel.editing.removing import referrers
from dineros.metamodel.elements import arcs, is_within, node_net_of, nodes, resolve
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.schema import class_of

Place = pn.Page | str
"""A page, or the name of a page that an earlier command makes."""


def moved(root: pn.Net, handles: Handles, elements: Sequence[EObject], page: pn.Page) -> list[c.Command]:
    """Return the commands that move elements of one page to another.

    Raises
    ------
    CommandError
        They are not on one page, the page is in another ROS node, or one of them contains the page.
    """
    source = _page_of(elements)
    if any(is_within(page, each) for each in elements):
        raise c.CommandError(f"{describe(page)} cannot be put into itself")
    if node_net_of(page) is not node_net_of(source):
        raise c.CommandError(
            f"{describe(page)} is part of another ROS node", hint="copy the elements that are needed"
        )
    return [] if page is source else _NodeMove(root, handles, elements, page).commands()


def grouped(root: pn.Net, handles: Handles, elements: Sequence[EObject], type: str) -> list[c.Command]:
    """Return the commands that make a page from elements of a page; the new one is named `$page`.

    Raises
    ------
    CommandError
        They are not on one page.
    """
    if type not in ("pn.Page", "sym.CallbackPage"):
        raise c.CommandError("what is drawn becomes a pn.Page or a sym.CallbackPage")
    source = _page_of(elements)
    made: list[c.Command] = [c.Create(handles.of(source) or "", "objects", type, called="$page")]
    points = [point for each in elements if (point := _point(each)) is not None]
    if points:
        x, y = _middle(points)
        made.append(c.Move("$page", x, y))
    return [*made, *_NodeMove(root, handles, elements, "$page").commands()]


def split(root: pn.Net, handles: Handles, page: EObject) -> list[c.Command]:
    """Return the commands that move a page's contents to the page around it, and delete the page.

    Raises
    ------
    CommandError
        It is not inside another page, or an object requires it, such as the port of a server.
    """
    above = page.eContainer()
    if not isinstance(page, pn.Page) or not isinstance(above, pn.Page):
        raise c.CommandError(f"{describe(page)} is not a page within a page")
    for other, name in referrers(root)[page]:
        if class_of(other).features[name].required:
            raise c.CommandError(f"{describe(other)} cannot exist without {describe(page)}")
    contents = list(page.objects)
    found: list[c.Command] = []
    shift = (0.0, 0.0)
    here, points = _point(page), [point for each in contents if (point := _point(each)) is not None]
    if here is not None and points:
        x, y = _middle(points)
        shift = (round(here[0] - x), round(here[1] - y))
    if contents:
        found += _NodeMove(root, handles, contents, above, shift).commands()
    left = [arc for arc in page.arcs if arc.source not in contents and arc.target not in contents]
    found += [c.Place(handles.of(arc) or "", handles.of(above) or "", "arcs") for arc in left]
    return [*found, c.Delete((handles.of(page) or "",))]


def joined(handles: Handles, ends: tuple[EObject, EObject], point: tuple[float, float]) -> list[c.Command]:
    """Return the commands that draw an arc between two ends; if they are on two pages, with a reference.

    Raises
    ------
    CommandError
        They are not a place and a transition, or they are in two ROS nodes.
    """
    place, other = ends if isinstance(ends[0], pn.PlaceNode) else (ends[1], ends[0])
    if not isinstance(place, pn.PlaceNode) or not isinstance(other, pn.TransitionNode):
        raise c.CommandError("an arc between two pages joins a place and a transition")
    page = other.page
    if page is None or node_net_of(page) is not node_net_of(place):
        raise c.CommandError(
            f"{describe(other)} is part of another ROS node", hint="draw a channel between them"
        )
    owner, base = handles.of(page) or "", _base(place)
    names = {each: handles.of(each) or "" for each in ends}
    found: list[c.Command] = []
    beside = (each for each in page.objects if isinstance(each, pn.PlaceNode) and _base(each) is base)
    if (stand := next(beside, None)) is not None:
        names[place] = handles.of(stand) or ""
    else:
        names[place] = "$reference"
        found = [_reference(owner, base, handles, "$reference"), c.Move("$reference", *point)]
    values: dict[str, c.Value] = {"source": names[ends[0]], "target": names[ends[1]]}
    return [*found, c.Create(owner, "arcs", "pn.Arc", values, called="$arc")]


class _NodeMove:
    """One move; `stand` returns the node that represents a place on a page."""

    def __init__(
        self,
        root: pn.Net,
        handles: Handles,
        elements: Sequence[EObject],
        target: Place,
        shift: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        self._root, self._handles, self._target, self._shift = root, handles, target, shift
        self._moving = dict.fromkeys(elements)
        self._made: list[c.Command] = []
        beside = [*target.objects] if isinstance(target, pn.Page) else []
        self._near = [each for each in (*beside, *_page_of(elements).objects) if isinstance(each, pn.Node)]
        self._merged = self._merging()
        self._stands: dict[tuple[pn.Node, Place | None], str] = {}

    def commands(self) -> list[c.Command]:
        found: list[c.Command] = [
            c.Place(self._handle(each), self._name(self._target), "objects") for each in self._moving
        ]
        if self._shift != (0.0, 0.0):
            found += [self._shifted(each, *point) for each in self._moving if (point := _point(each))]
        for arc in list(arcs(self._root)):
            ends = arc.source, arc.target
            if any(end in self._moving or end in self._merged for end in ends):
                found += self._lead(arc)
        for other in nodes(self._root):
            if isinstance(other, pn.ReferencePlace) and other not in self._merged:
                stand = self._merged.get(other.target)
                if stand is not None:
                    found.append(c.Set(self._handle(other), "target", self._handle(stand)))
        if self._merged:
            found.append(c.Delete(tuple(map(self._handle, self._merged))))
        return [*self._made, *found]

    def _merging(self) -> dict[pn.Node, pn.Node]:
        """Return the references that are replaced by nodes on the same page, with these nodes."""
        leading = referrers(self._root)
        known: dict[tuple[pn.Node, Place | None], pn.Node] = {}
        merged: dict[pn.Node, pn.Node] = {}
        for each in sorted(
            self._near, key=lambda node: (isinstance(node, pn.ReferencePlace), node in self._moving)
        ):
            if not isinstance(each, (pn.Place, pn.ReferencePlace)):
                continue
            key = (_base(each), self._page(each))
            first = known.setdefault(key, each)
            is_met = each in self._moving or first in self._moving
            is_needed = any(not isinstance(other, (pn.Arc, pn.ReferencePlace)) for other, _ in leading[each])
            if first is not each and isinstance(each, pn.ReferencePlace) and is_met and not is_needed:
                merged[each] = first
        return merged

    def _lead(self, arc: pn.Arc) -> Iterable[c.Command]:
        ends = {"source": arc.source, "target": arc.target}
        now = {name: self._merged.get(end, end) for name, end in ends.items()}
        pages = {name: self._page(end) for name, end in now.items()}
        names = {name: self._handle(end) for name, end in now.items()}
        page = pages["source"]
        if page is not pages["target"]:
            is_place = {name: isinstance(end, (pn.Place, pn.ReferencePlace)) for name, end in now.items()}
            if is_place["source"] == is_place["target"]:
                return  # such an arc is invalid anyway, and reported
            place, other = ("source", "target") if is_place["source"] else ("target", "source")
            page = pages[other]
            names[place] = self._stand(now[place], page)
        for name, end in ends.items():
            if names[name] != self._handle(end):
                yield c.Set(self._handle(arc), name, names[name])
        if page is not None and arc.eContainer() is not page:
            yield c.Place(self._handle(arc), self._name(page), "arcs")
        points = _bends(arc)
        if not points:
            return
        if pages["source"] is not pages["target"]:
            yield c.Bend(self._handle(arc), ())
        elif self._shift != (0.0, 0.0) and page is self._target:
            dx, dy = self._shift
            yield c.Bend(self._handle(arc), tuple((x + dx, y + dy) for x, y in points))

    def _stand(self, place: pn.Node, page: Place | None) -> str:
        """Return the node for a place of another page; a new reference if there is none."""
        base = _base(place)
        if (base, page) in self._stands:
            return self._stands[base, page]
        for each in self._near:
            if self._page(each) is page and each not in self._merged and _base(each) is base:
                return self._stands.setdefault((base, page), self._handle(each))
        assert page is not None
        called = self._stands[base, page] = f"$reference{len(self._stands)}"
        self._made.append(_reference(self._name(page), base, self._handles, called))
        if (point := _point(place)) is not None:
            dx, dy = self._shift if page is self._target else (0.0, 0.0)
            self._made.append(c.Move(called, point[0] + dx, point[1] + dy))
        return called

    def _page(self, node: pn.Node) -> Place | None:
        return self._target if node in self._moving else node.page

    def _shifted(self, element: EObject, x: float, y: float) -> c.Move:
        return c.Move(self._handle(element), x + self._shift[0], y + self._shift[1])

    def _handle(self, element: EObject) -> str:
        return self._handles.of(element) or ""

    def _name(self, page: Place) -> str:
        return page if isinstance(page, str) else self._handle(page)


def _page_of(elements: Sequence[EObject]) -> pn.Page:
    """Return the page of elements."""
    for each in elements:
        page = each.eContainer()
        if not isinstance(each, pn.PageObject) or not isinstance(page, pn.Page):
            raise c.CommandError(f"{describe(each)} is not on a page")
        if page is not elements[0].eContainer():
            raise c.CommandError(f"{describe(each)} and {describe(elements[0])} are on two pages")
    page = elements[0].eContainer()
    assert isinstance(page, pn.Page)
    return page


def _reference(page: str, base: pn.Node, handles: Handles, called: str) -> c.Create:
    """Return the command that makes a reference on a page, with the name of its place."""
    values: dict[str, c.Value] = {"target": handles.of(base) or ""}
    if base.name:
        values["name"] = base.name
    return c.Create(page, "objects", "pn.ReferencePlace", values, called=called)


def _base(node: pn.Node) -> pn.Node:
    try:
        return resolve(node)
    except DinerosError:  # no target, or a cycle
        return node


def _point(element: EObject) -> tuple[float, float] | None:
    graphics = element.graphics if isinstance(element, pn.Element) else None
    if graphics is None or not len(graphics.positions):
        return None
    return float(graphics.positions[0].x), float(graphics.positions[0].y)


def _bends(arc: pn.Arc) -> list[tuple[float, float]]:
    return [] if arc.graphics is None else [(float(each.x), float(each.y)) for each in arc.graphics.positions]


def _middle(points: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Return the middle of the rectangle around points."""
    columns, rows = zip(*points, strict=True)
    return round((min(columns) + max(columns)) / 2), round((min(rows) + max(rows)) / 2)
