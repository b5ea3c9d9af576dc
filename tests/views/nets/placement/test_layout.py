"""Layout: nothing overlaps, everything is there once, lines end at what they join."""

from __future__ import annotations

import time

import pytest
from hypothesis import HealthCheck, given, settings

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.files import load
from dineros.views.javascript import client
from dineros.views.nets import around, collapse, layout, view_of
from dineros.views.nets.placement import placing
from tests.support.systems.small_systems import small_system_models
from tests.views.nets.geometry import faults, label_overlaps
from tests.views.nets.samples import arranged, case_study, models

SEVERAL = settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.too_slow])
NAMES = list(models())


@pytest.mark.parametrize("name", NAMES)
def test_nothing_overlaps(name: str) -> None:
    picture = layout(view_of(models()[name]))
    assert list(faults(picture)) == []
    assert label_overlaps(picture) == []


@pytest.mark.parametrize("name", NAMES)
def test_everything_is_there_once(name: str) -> None:
    view = view_of(models()[name])
    picture = layout(view)
    for kind in ("boxes", "nodes", "edges"):
        assert [item["id"] for item in picture[kind]] == [item.id for item in getattr(view, kind)]


@SEVERAL
@given(small_system_models(clients=2))
def test_any_system_model_has_a_picture(model: sym.SystemModel) -> None:
    assert list(faults(layout(view_of(model)))) == []


@pytest.mark.parametrize("collapsed", [["executor"], ["controller", "Safety"], None])
def test_collapsed_boxes_hide_their_content(collapsed: list[str] | None) -> None:
    view = collapse(view_of(case_study()), collapsed)
    picture = layout(view)
    assert list(faults(picture)) == []
    hidden = {"Safe", "TStop"} if collapsed != ["controller", "Safety"] else {"Safe", "TStop", "GetReqL"}
    assert hidden.isdisjoint(node["id"] for node in picture["nodes"])
    executor = next((box for box in picture["boxes"] if box["id"] == "executor"), None)
    assert executor is not None
    lines = [edge for edge in picture["edges"] if "executor" in (edge["source"], edge["target"])]
    assert bool(lines) == bool(executor.get("collapsed"))


def test_lines_to_a_closed_page_are_one_for_each_kind_and_end() -> None:
    view = view_of(case_study())
    hidden = {edge.id: edge for edge in view.edges}
    box_of = {node.id: node.box for node in view.nodes}
    seen = set()
    for edge in layout(collapse(view, ["executor"]))["edges"]:
        if "stands" in edge:
            seen.add((edge["kind"], edge["source"], edge["target"]))
            labels = {hidden[id].label for id in edge["stands"]}
            assert edge.get("label", "") == (labels.pop() if len(labels) == 1 else "")
            for id in edge["stands"]:
                assert hidden.pop(id).kind == edge["kind"]
        else:
            del hidden[edge["id"]]
            assert "executor" not in (edge["source"], edge["target"])
    assert len(seen) >= 4
    inside = {box.id for box in view.boxes if "executor" in (box.id, box.parent)}
    assert all({box_of[edge.source], box_of[edge.target]} <= inside for edge in hidden.values())


def test_without_v8_it_is_said_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(client, "find_spec", lambda name: None)
    monkeypatch.setattr(placing, "evaluate", client.Layouter().evaluate)
    with pytest.raises(client.LayouterError) as raised:
        layout(view_of(case_study()))
    assert str(raised.value) == "mini-racer is not installed (pip install 'dineros[view]')"


def test_equal_views_are_laid_out_equally() -> None:
    view = view_of(case_study())
    assert layout(view) == layout(view)


def test_where_an_editor_put_things_they_stay() -> None:
    picture = layout(view_of(arranged()))
    at = {node["id"]: (node["x"], node["y"]) for node in picture["nodes"]}
    scale = (at["t"][0] - at["a"][0]) / 60
    assert scale >= 1
    for one, other, (dx, dy) in (("a", "t", (60, 0)), ("a", "u", (0, 90)), ("u", "b", (60, 0))):
        assert at[other][0] - at[one][0] == pytest.approx(dx * scale, abs=0.2)
        assert at[other][1] - at[one][1] == pytest.approx(dy * scale, abs=0.2)
    bent = next(edge for edge in picture["edges"] if edge["id"] == "a-t")
    assert bent["points"][1] == pytest.approx([at["a"][0] + 30 * scale, at["a"][1] - 40 * scale], abs=0.2)


def test_a_foreign_model_keeps_its_arrangement(foreign_model: pn.Net) -> None:
    picture = layout(view_of(foreign_model))
    assert list(faults(picture)) == []
    nodes = {node["id"]: node for node in picture["nodes"]}
    for page in ("ModeSwap", "FrameChange"):
        ids = [id for id, node in nodes.items() if node["box"] == page]
        for one in ids:
            for other in ids:
                before = nodes[one]["position"][0] - nodes[other]["position"][0]
                after = nodes[one]["x"] - nodes[other]["x"]
                assert (before > 0) == (after > 0)
                assert abs(after) >= abs(before) - 0.2


def test_the_first_page_is_where_the_tokens_are(foreign_model: pn.Net) -> None:
    boxes = {box["id"]: box for box in layout(view_of(foreign_model))["boxes"]}
    assert boxes["ModeSwap"]["y"] < boxes["FrameChange"]["y"]


def test_five_hundred_elements_take_seconds() -> None:
    pages, entries, exits = [], [], []
    for number in range(25):
        places = [pn.Place(id=f"p{number}.{i}", tokens=i == 0) for i in range(10)]
        steps = [pn.Transition(id=f"t{number}.{i}") for i in range(10)]
        pages.append(pn.Page(id=f"page{number}", name=f"part {number}", objects=[*places, *steps]))
        for i, step in enumerate(steps):
            flow(places[i], step, places[(i + 1) % 10])
        flow(places[3], steps[7])
        entries.append(places[0])
        exits.append(steps[2])
    for page, step, entry in zip(pages, exits, entries[1:], strict=False):
        flow(step, pn.ReferencePlace(id=f"to {entry.id}", target=entry, page=page))
    view = view_of(pn.Net(id="large", pages=pages))
    assert len(view.nodes) == 524
    started = time.process_time()
    picture = layout(view)
    assert time.process_time() - started < 60
    assert list(faults(picture)) == []


def test_a_neighbourhood_is_laid_out_on_its_own() -> None:
    picture = layout(around(view_of(case_study()), ["TStop"], 1))
    assert {node["id"] for node in picture["nodes"]} == {"TStop", "Safe", "SensorReq"}
    assert {box["id"] for box in picture["boxes"]} == {"executor", "Safety"}
    assert picture["width"] < 900
    assert list(faults(picture)) == []


@pytest.fixture
def foreign_model() -> pn.Net:
    """Return a net with the positions of one that another editor made: two loops, the first one marked."""
    from tests.views.nets.samples import EDITED

    return load(EDITED)
