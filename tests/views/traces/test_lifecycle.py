"""Managed nodes in traces and pictures: a band for each, by its states."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from dineros.metamodel.records import Checkpoint, Header, Lifecycle, Start
from dineros.views.nets import layout, to_svg, view_of
from dineros.views.traces.building import TraceBuilder
from dineros.views.traces.coding import TraceCoder
from dineros.views.traces.facts import facts_of
from dineros.views.traces.figures import trace_svg
from dineros.views.traces.net_pane import net_content
from dineros.views.traces.page import trace_page
from tests.support.ros2_systems.managed_systems import camera
from tests.views.browser import Visit
from tests.views.samples import Scribe

NewVisit = Callable[..., Visit]


def life() -> Scribe:
    """Return a witness in which the camera is configured, fails to be activated, and is then."""
    witness = Scribe()
    witness.write(Header, kind="witness", model="cameras", source="", signals="none", overflow="weighted")
    for label, state in (("configure", "inactive"), ("activate", "inactive"), ("activate", "active")):
        witness.write(Lifecycle, node="camera", label=label, state=state, change={})
    return witness


def built(scribe: Scribe) -> TraceBuilder:
    builder = TraceBuilder(facts_of(camera()))
    for record in scribe.records:
        builder.add(record)
    return builder


def test_each_managed_node_has_a_lane_that_knows_its_states() -> None:
    builder = built(life())
    lanes = [lane for lane in builder.lanes.all if lane.group == "lifecycle"]
    assert [(lane.id, lane.initial) for lane in lanes] == [("camera", 0), ("detector", 0), ("display", 0)]
    assert [step.marks for step in builder.steps] == [[[0, "l", 1, 0]], [[0, "l", 1, 1]], [[0, "l", 2, 0]]]
    assert builder.steps[1].text == "camera: activate; it stays inactive"


def test_a_node_that_was_killed_is_in_the_state_that_its_checkpoint_says() -> None:
    run = Scribe("camera")
    run.write(Header, kind="run", model="cameras", source="")
    run.write(Checkpoint, marking={}, signals={}, lifecycle="active")
    run.write(Start, marking={}, signals={}, seed=1, resumed=True)
    run.write(Lifecycle, 1.0, label="shutdown", state="finalized", change={})
    builder = built(run)
    (lane,) = (lane for lane in builder.lanes.all if lane.kind == "state")
    assert (lane.id, lane.initial) == ("camera", 2)
    assert builder.steps[-1].marks == [[lane.index, "l", 3, 0]]


def test_figures_draw_a_band_for_each_state() -> None:
    figure = trace_svg([TraceCoder(built(life()), "sample").snapshot()])
    band = figure.partition('data-id="camera"')[2].partition("</g>")[0]
    heights = [float(part.partition('"')[0]) for part in band.split('height="')[1:]]
    assert len(set(heights)) == 3  # told by more than colours
    for word in ("unconfigured", "inactive", "active", "fails to change its state"):
        assert f">{word}</text>" in figure


def test_the_picture_of_a_managed_node_has_its_states() -> None:
    svg = to_svg(layout(view_of(camera())))
    assert svg.count('class="life"') == 3
    assert svg.count('class="state now"') == 3
    assert svg.partition('class="state now"')[2].partition("</text>")[0].endswith(">unconfigured")


def test_page_and_net_follow_the_states(tmp_path: Path, visit: NewVisit) -> None:
    view = TraceCoder(built(life()), "sample").snapshot()
    content = {"view": view, "net": net_content(camera())}
    (tmp_path / "t.html").write_text(trace_page(content, title="sample"), encoding="utf-8")
    page = visit().open(tmp_path / "t.html")
    now = "() => document.querySelector('#net [data-id=camera] .life .now').textContent"
    assert page.inner_text('#labels .lane[data-kind="state"] .what >> nth=0') == "camera"
    seen = []
    for _ in range(3):
        seen.append(page.evaluate(now))
        assert page.query_selector("#net [data-id=camera].marked")
        page.keyboard.press("ArrowRight")
    assert seen == ["inactive", "inactive", "active"]
    assert page.locator("#net .life .now").count() == 3  # the others stay where they were
    page.hover("#scroller", position={"x": 10, "y": 35})
    assert page.inner_text("#tip .level") == "camera: inactive"
