"""Nets that an editor arranged, in whole or in part, and what must hold for their pictures."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any, TypeAlias

from hypothesis import strategies as st

from dineros.metamodel import elements, pn, sym
from dineros.metamodel.build import flow
from dineros.views.nets import ViewModel
from dineros.views.nets.contents.model import Box, Node
from dineros.views.nets.placement.picture import Picture
from tests.support.systems.small_systems import small_system_models
from tests.views.nets.geometry import box_area, node_area, overlap

Point: TypeAlias = tuple[float, float]
STEPS = st.sampled_from([6, 30]).flatmap(lambda most: st.integers(-most, most))
COORDINATES = st.tuples(STEPS, STEPS).map(lambda at: (at[0] * 20.0, at[1] * 20.0))
EXACT = 0.25
"""Coordinates are rounded to a tenth."""


def at(x: float, y: float, width: float = 0, height: float = 0) -> pn.Graphics:
    """Return the position of an element, and the size of its frame."""
    dimension = pn.Point(x=width, y=height) if width else None
    return pn.Graphics(positions=[pn.Point(x=x, y=y)], dimension=dimension)


@st.composite
def nested_nets(draw: st.DrawFn) -> pn.Net:
    """Draw a net of pages in pages; any of its elements may have a position."""
    pages = [pn.Page(id="page0")]
    for number in range(1, draw(st.integers(2, 5))):
        page = pn.Page(id=f"page{number}", name=draw(st.sampled_from(["p", "a page with a long name"])))
        draw(st.sampled_from(pages)).objects.append(page)
        pages.append(page)
    for number in range(draw(st.integers(2, 9))):
        page = draw(st.sampled_from(pages))
        place = pn.Place(id=f"p{number}", name=draw(st.sampled_from(["p", "a place with a long name"])))
        step = pn.Transition(id=f"t{number}")
        page.objects.extend([place, step])
        flow(place, step)
        known = [other for other in page.objects if isinstance(other, pn.Place)]
        flow(step, draw(st.sampled_from(known)), weight=draw(st.integers(1, 2)))
        outer = page.page
        if outer is not None and draw(st.booleans()):
            outer.objects.append(pn.ReferencePlace(id=f"r{number}", target=place))
    net = pn.Net(id="net", pages=[pages[0], pn.Page(id="other")])
    return _arranged(draw, net)


@st.composite
def systems(draw: st.DrawFn) -> pn.Net:
    """Draw a system model; any of its elements, channels too, may have a position."""
    return _arranged(draw, draw(small_system_models(clients=2)))


def _arranged(draw: st.DrawFn, net: pn.Net) -> pn.Net:
    share = draw(st.sampled_from([0.3, 0.7, 1.0]))
    found: list[pn.Element] = [*elements.pages(net), *elements.nodes(net)]
    if isinstance(net, sym.SystemModel):
        found.extend(net.channels)
    for element in found:
        if draw(st.floats(0, 1)) < share:
            element.graphics = at(*draw(COORDINATES))
    return net


def sheets(view: ViewModel) -> Iterator[list[Node | Box]]:
    """Yield the elements of each sheet that stand where they were stored."""
    for sheet in [None, *(box.id for box in view.boxes)]:
        items: list[Node | Box] = [node for node in view.nodes if node.box == sheet]
        items += [box for box in view.boxes if box.parent == sheet]
        items = [item for item in items if item.position is not None]
        points: dict[Point | None, Node | Box] = {}
        for item in sorted(items, key=lambda item: isinstance(item, Node)):  # the order of the view
            points.setdefault(item.position, item)
        if len(points) > 1:
            yield list(points.values())


def stands(picture: Picture) -> dict[str, Point]:
    """Return where the centre of everything is."""
    found = {node["id"]: (node["x"], node["y"]) for node in picture["nodes"]}
    for box in picture["boxes"]:
        found[box["id"]] = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    return found


def displaced(view: ViewModel, picture: Picture) -> Iterator[str]:
    """Yield what stands elsewhere than it was stored.

    Where no page of a sheet is open, that is where it was stored, up to the scale of the sheet; where one is,
    what was left of or above something still is, and at least as far away.
    """
    place = stands(picture)
    opened = {box["id"] for box in picture["boxes"] if not box.get("collapsed")}
    for items in sheets(view):
        shown = [item for item in items if item.id in place]
        stored = {item.id: item.position for item in shown if item.position is not None}
        if any(id in opened for id in stored):
            yield from _disordered(stored, place)
        elif len(stored) > 1:
            yield from _moved(stored, place)


def _moved(stored: dict[str, Point], place: dict[str, Point]) -> Iterator[str]:
    scale = scale_of(stored, place)
    if scale < 1 - EXACT / 20:
        yield f"the sheet of {next(iter(stored))} shrank: {scale}"
    first = next(iter(stored))
    for id in stored:
        for axis in (0, 1):
            wanted = (stored[id][axis] - stored[first][axis]) * scale
            found = place[id][axis] - place[first][axis]
            if abs(found - wanted) > EXACT:
                yield f"{id} is {found} from {first} instead of {wanted}"


def scale_of(stored: dict[str, Point], place: dict[str, Point]) -> float:
    """Return by how much a sheet grew, measured where that is most exact."""
    pairs = [
        (abs(stored[one][axis] - stored[other][axis]), abs(place[one][axis] - place[other][axis]))
        for one, other in itertools.combinations(stored, 2)
        for axis in (0, 1)
    ]
    before, after = max(pairs)
    return after / before


def _disordered(stored: dict[str, Point], place: dict[str, Point]) -> Iterator[str]:
    for one, other in itertools.combinations(stored, 2):
        for axis in (0, 1):
            before = stored[other][axis] - stored[one][axis]
            after = place[other][axis] - place[one][axis]
            if (before == 0 and abs(after) > EXACT) or before * after < 0 or abs(after) < abs(before) - EXACT:
                yield f"{one} and {other} were {before} apart, and are {after}"


def covered(view: ViewModel, picture: Picture) -> Iterator[str]:
    """Yield what covers something else of its sheet without having been stored so."""
    pairs = {
        frozenset(pair) for items in sheets(view) for pair in itertools.combinations([i.id for i in items], 2)
    }
    known = {item.id: item for item in view.shapes()}
    siblings: dict[str | None, list[tuple[str, Any]]] = {}
    for box in picture["boxes"]:
        siblings.setdefault(box.get("parent"), []).append((box["id"], box_area(box)))
    for node in picture["nodes"]:
        siblings.setdefault(node.get("box"), []).append((node["id"], node_area(node)))
    for items in siblings.values():
        for (id, area), (other_id, other) in itertools.combinations(items, 2):
            if not overlap(area, other):
                continue
            if frozenset((id, other_id)) in pairs and _stored_so(known[id], known[other_id]):
                continue
            yield f"{id} and {other_id} overlap"


def _stored_so(one: Node | Box, other: Node | Box) -> bool:
    """Tell whether two elements overlap at three times their stored distance, while they are closed."""
    assert one.position is not None and other.position is not None
    areas = []
    for item in (one, other):
        assert item.position is not None
        wide, down = item.room if isinstance(item, Node) else (0.0, 0.0)
        x, y, side = 3 * item.position[0], 3 * item.position[1], max(item.width, wide) / 2 + 7
        areas.append((x - side, y - item.height / 2 - 7, x + side, y + item.height / 2 + down + 7))
    return overlap(areas[0], areas[1])
