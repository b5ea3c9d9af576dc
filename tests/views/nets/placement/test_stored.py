"""Elements that an editor arranged stand where it put them, pages open or closed."""

from __future__ import annotations

import itertools
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dineros.metamodel import elements, pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.files import load, save
from dineros.views.nets import ViewModel, collapse, compare, layout, view_of
from dineros.views.nets.placement.picture import Picture, PlacedEdge
from tests.support.systems.talker import talker
from tests.views.nets.arranged import at, covered, displaced, nested_nets, scale_of, stands, systems
from tests.views.nets.geometry import crossed, enters, faults, label_overlaps
from tests.views.nets.samples import arranged_study, case_study

SEVERAL = settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
LESS = settings(SEVERAL, max_examples=8)


def check(view: ViewModel) -> Picture:
    picture = layout(view)
    assert list(displaced(view, picture)) == []
    assert list(covered(view, picture)) == []
    found = [fault for fault in faults(picture) if "label" not in fault and "overlap" not in fault]
    assert found == []
    return picture


def partly_closed(data: st.DataObject, view: ViewModel) -> ViewModel:
    ids = [box.id for box in view.boxes]
    return collapse(view, data.draw(st.lists(st.sampled_from(ids), unique=True), label="closed"))


@LESS
@given(nested_nets())
def test_with_all_pages_closed_positions_are_exact(net: pn.Net) -> None:
    check(collapse(view_of(net)))


@SEVERAL
@given(nested_nets(), st.data())
def test_any_pages_open_keep_the_order(net: pn.Net, data: st.DataObject) -> None:
    check(partly_closed(data, view_of(net)))


@pytest.mark.long
@SEVERAL
@given(systems(), st.data())
def test_channels_and_node_nets_stand_where_they_were_stored(net: pn.Net, data: st.DataObject) -> None:
    check(partly_closed(data, view_of(net)))


def test_positions_with_room_are_exact_to_the_point() -> None:
    model = arranged_study(apart=2.0)
    view = collapse(view_of(model))
    picture = check(view)
    place = stands(picture)
    stored = {item.id: item.position for item in view.shapes() if item.position and item.id in place}
    assert len(stored) == 13
    assert scale_of(stored, place) == pytest.approx(1, abs=0.001)


@pytest.mark.parametrize("closed", [["controller"], ["executor", "selector", "Safety"], []])
def test_the_case_study_with_arranged_channels_and_nodes(closed: list[str]) -> None:
    view = collapse(view_of(arranged_study()), closed)
    assert "EndControl" in {node.id for node in view.nodes if node.position is None}
    picture = check(view)
    assert list(faults(picture)) == []
    assert list(crossed(picture)) == []
    assert label_overlaps(picture) == []


def test_opening_a_page_moves_only_what_is_beside_it() -> None:
    view = view_of(arranged_study())
    closed, opened = (
        stands(layout(collapse(view))),
        stands(layout(collapse(view, _all_but(view, "executor")))),
    )
    # The selector and the topics are left of the executor, and above it.
    for one, other in (("selector", "LeftCellObjects"), ("LeftCellObjects", "RightCellObjects")):
        for axis in (0, 1):
            before, after = closed[other][axis] - closed[one][axis], opened[other][axis] - opened[one][axis]
            assert after == pytest.approx(before, abs=0.2)
    assert (
        opened["sensorics"][0] - opened["selector"][0] > closed["sensorics"][0] - closed["selector"][0] + 100
    )


def _all_but(view: ViewModel, open_: str) -> list[str]:
    return [box.id for box in view.boxes if box.id != open_]


def _framed(*, corner: bool) -> pn.Net:
    """Return two loops that were drawn inside of frames, in one plane."""
    page = pn.Page(id="outer", name="outer")
    for number, top in enumerate((100.0, 420.0)):
        inner = pn.Page(id=f"loop{number}", graphics=at(100, top, 500, 300))
        if not corner:
            inner.graphics = at(350, top + 150, 500, 300)
        a, t = pn.Place(id=f"a{number}", graphics=at(180, top + 150)), pn.Transition(id=f"t{number}")
        t.graphics = at(520, top + 140 + 20 * number)
        inner.objects.extend([a, t])
        flow(a, t, a)
        page.objects.append(inner)
    return pn.Net(id="framed", pages=[page, pn.Page(id="other")])


@pytest.mark.parametrize("corner", [True, False])
def test_frames_are_drawn_as_the_editor_drew_them(corner: bool) -> None:
    picture = layout(view_of(_framed(corner=corner)))
    boxes = {box["id"]: box for box in picture["boxes"]}
    for id in ("loop0", "loop1"):
        assert (boxes[id]["width"], boxes[id]["height"]) == (500, 300)
    assert boxes["loop1"]["y"] - boxes["loop0"]["y"] == pytest.approx(320, abs=0.2)
    assert boxes["loop1"]["x"] == boxes["loop0"]["x"]
    place = stands(picture)
    assert place["a0"] == pytest.approx((boxes["loop0"]["x"] + 80, boxes["loop0"]["y"] + 150), abs=0.2)
    assert place["t1"][0] - place["a0"][0] == pytest.approx(340, abs=0.2)
    assert place["t1"][1] - place["a0"][1] == pytest.approx(330, abs=0.2)


def test_a_size_that_does_not_hold_the_content_is_no_frame() -> None:
    net = _framed(corner=True)
    page = elements.find(net, "loop0", pn.Page)
    page.graphics = at(1000, 1000, 40, 30)
    box = view_of(net).box("loop0")
    assert (box.position, box.frame) == ((1000, 1000), None)


def test_drawings_in_small_units_grow() -> None:
    page = pn.Page(id="page")
    for x in range(4):
        for y in range(3):
            page.objects.append(pn.Place(id=f"p{x}{y}", graphics=at(x, y)))
    check(view_of(pn.Net(id="centimetres", pages=[page])))


def test_elements_at_one_point_can_all_be_seen() -> None:
    page = pn.Page(id="page", objects=[pn.Place(id=f"p{x}", graphics=at(0, 0)) for x in range(4)])
    page.objects.append(pn.Place(id="far", graphics=at(300, 0)))
    picture = layout(view_of(pn.Net(id="heap", pages=[page])))
    assert list(faults(picture)) == []
    place = stands(picture)
    assert place["far"][0] - place["p0"][0] == pytest.approx(300, abs=0.2)


def test_positions_that_are_no_points_are_none() -> None:
    place = pn.Place(id="p", graphics=at(float("nan"), 1))
    net = pn.Net(id="n", pages=[pn.Page(id="page", objects=[place])])
    assert view_of(net).node("p").position is None


def test_an_arranged_flat_net_is_not_grouped() -> None:
    from dineros.metamodel import pnm

    page = pn.Page(
        id="page", objects=[pn.Place(id=f"one.two.{x}", graphics=at(100 * x, 0)) for x in range(5)]
    )
    view = view_of(pnm.PetriNetModel(id="flat", pages=[page]))
    assert view.boxes == []
    check(view)


@pytest.mark.parametrize("suffix", [".xmi", ".pnml"])
def test_positions_of_pages_and_channels_come_from_files(tmp_path: Any, suffix: str) -> None:
    path = tmp_path / f"model.sym{suffix}"
    save(arranged_study(), path)
    view, kept = view_of(load(path)), view_of(arranged_study())
    assert {item.id: item.position for item in view.shapes()} == {
        item.id: item.position for item in kept.shapes()
    }


def test_what_has_no_position_stands_beside_the_rest() -> None:
    model = case_study()
    view = view_of(model)
    stored = {"selector": (0.0, 0.0), "controller": (900.0, 0.0)}
    for box in view.boxes:
        box.position = stored.get(box.id)
    for closed in (None, _all_but(view, "executor")):
        check(collapse(view, closed))


# Lines and captions


def _between(obstacle: pn.Place, *bends: tuple[float, float]) -> PlacedEdge:
    """Lay out an arc from (0, 0) to (400, 0) with a place that may be in its way; return the arc."""
    a, t = pn.Place(id="a", graphics=at(0, 0)), pn.Transition(id="t", graphics=at(400, 0))
    page = pn.Page(id="page", objects=[a, t, obstacle])
    flow(a, t, weight=2)
    if bends:
        page.arcs[0].graphics = pn.Graphics(positions=[pn.Point(x=x, y=y) for x, y in bends])
    picture = layout(view_of(pn.Net(id="lines", pages=[page])))
    assert list(faults(picture)) == []
    return picture["edges"][0]


def test_lines_are_straight_where_nothing_is_in_the_way() -> None:
    points = _between(pn.Place(id="b", graphics=at(200, 100)))["points"]
    assert len(points) == 2
    assert points[0][1] == points[1][1]


def test_lines_go_around_what_is_in_their_way() -> None:
    edge = _between(pn.Place(id="b", graphics=at(200, 0)))
    assert len(edge["points"]) >= 3
    assert "labelAt" in edge


def test_lines_keep_the_bends_that_were_drawn() -> None:
    points = _between(pn.Place(id="b", graphics=at(200, 0)), (100, -80), (300, -80))["points"]
    assert points[2][0] - points[1][0] == pytest.approx(200, abs=0.2)
    assert points[1][1] == points[2][1]


def test_captions_move_off_the_lines_of_their_node() -> None:
    a, t = pn.Place(id="a", graphics=at(0, 0)), pn.Transition(id="t", graphics=at(0, 150))
    b = pn.Place(id="b", graphics=at(150, 0))
    page = pn.Page(id="page", objects=[a, t, b])
    flow(t, a)
    view = view_of(pn.Net(id="captions", pages=[page]))
    picture = layout(view)
    nodes = {node["id"]: node for node in picture["nodes"]}
    across, along = nodes["a"]["captionAt"]
    assert abs(across) > 13 or along < -26
    assert nodes["a"]["glyph"] != view.node("a").glyph
    assert nodes["b"]["glyph"] == view.node("b").glyph
    assert "captionAt" not in nodes["t"]
    assert "captionAt" not in nodes["b"]
    assert list(faults(picture)) == []


@SEVERAL
@given(nested_nets(), st.data())
def test_labels_and_captions_keep_within_the_picture(net: pn.Net, data: st.DataObject) -> None:
    picture = layout(partly_closed(data, view_of(net)))
    assert [fault for fault in faults(picture) if "leaves" in fault or "missing" in fault] == []


# Two models


def _talkers() -> tuple[sym.SystemModel, sym.SystemModel]:
    """Return a model, and what became of it: moved as a whole, one place replaced by another in its place."""
    points = {
        "talker": (0, 0),
        "Chatter": (300, 0),
        "listener": (600, 0),
        "Words": (0, 0),
        "Say": (150, 0),
        "Said": (300, 90),
    }
    before, after = talker(), talker()
    for id, (x, y) in points.items():
        elements.find(before, id).graphics = at(x, y)
        elements.find(after, id).graphics = at(x + 1000, y - 500)
    page = elements.find(after, "talker", sym.NodeNet)
    page.objects.append(sym.Place(id="New", graphics=at(1300, -350)))
    old = elements.find(before, "talker", sym.NodeNet)
    old.objects.append(sym.Place(id="Gone", graphics=at(0, 150)))
    old.objects.append(sym.Place(id="Replaced", graphics=at(300, 150)))
    return before, after


def test_two_models_in_one_picture_stand_where_they_were_stored() -> None:
    before, after = _talkers()
    view = compare(view_of(before), view_of(after))
    picture = check(view)
    assert [fault for fault in faults(picture) if "label" not in fault] == []
    place = stands(picture)
    # What is gone stands where it stood, although the rest was moved.
    scale = (place["Say"][0] - place["Words"][0]) / 150
    assert place["Gone"] == pytest.approx((place["Words"][0], place["Words"][1] + 150 * scale), abs=0.3)
    assert place["New"][1] - place["Words"][1] == pytest.approx(150 * scale, abs=0.3)
    # Its place is taken.
    assert view.node("Replaced").position is None


def test_a_model_without_positions_is_shown_as_the_one_with_them() -> None:
    before, _ = _talkers()
    view = compare(view_of(before), view_of(talker()))
    assert view.node("Words").position == (0, 0)
    assert view.box("listener").position == (600, 0)
    check(view)


def test_no_line_crosses_a_name_that_can_stand_beside() -> None:
    """A ring as editors draw them: the lines of each sign come from two sides, and leave others free."""
    names = ("P-LoopFrame", "T-IntervalFrame", "P3", "T-PollFrame", "P4", "T-SubmitFrame")
    spots = ((55, 179), (173, 104), (342, 106), (436, 173), (340, 251), (169, 256))
    ring: list[pn.Place | pn.Transition] = []
    for name, (x, y) in zip(names, spots, strict=True):
        graphics = pn.Graphics(positions=[pn.Point(x=x, y=y)])
        ring.append((pn.Place if name[0] == "P" else pn.Transition)(id=name, graphics=graphics))
    margin = [pn.Graphics(positions=[pn.Point(x=x, y=300)]) for x in (-40, 560)]
    apart = [pn.Place(id=f"margin{number}", graphics=at) for number, at in enumerate(margin)]
    page = pn.Page(id="FrameChange", objects=[*ring, *apart])
    flow(*ring, ring[0])
    picture = layout(view_of(pn.Net(id="net", pages=[page])))
    for node in picture["nodes"]:
        (wide, high), (dx, dy) = node["room"], node.get("captionAt", (0, 0))
        top = node["y"] + node["height"] / 2 + dy
        caption = (node["x"] + dx - wide / 2, top, node["x"] + dx + wide / 2, top + high)
        for edge in picture["edges"]:
            for one, other in itertools.pairwise(edge["points"]):
                assert not enters(one, other, caption), (node["id"], edge["id"])
