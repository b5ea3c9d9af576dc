"""Figures of traces as SVG and PNG."""

from __future__ import annotations

import struct
from typing import Any

import pytest
from lxml import etree

from dineros.views.traces.coding import TraceCoder
from dineros.views.traces.comparing import first_divergence
from dineros.views.traces.figures import trace_png, trace_svg
from tests.views.samples import lasso, long_run, run, schedule
from tests.views.traces.test_building import built

SVG = {"s": "http://www.w3.org/2000/svg"}
LOAD = {"LeftCellObjects.publisher.SortRed.Load": ("LeftCellObjects", "publisher", "SortRed")}


def snapshot(*scribes: Any) -> dict[str, Any]:
    loads = LOAD if scribes[0].node is None else None
    return TraceCoder(built(*scribes, loads=loads), "sample").snapshot()


def parsed(text: str) -> Any:
    return etree.fromstring(text.encode())


def lanes(picture: Any, kind: str) -> list[str]:
    return list(picture.xpath(f"//s:g[@class='lane {kind}']/@data-id", namespaces=SVG))


def texts(picture: Any) -> list[str]:
    return list(picture.xpath("//s:text/text()", namespaces=SVG))


def test_a_witness_has_all_that_fig_18_shows() -> None:
    picture = parsed(trace_svg([snapshot(lasso())]))
    assert lanes(picture, "signal") == ["Red", "Danger"]
    assert lanes(picture, "queue") == ["SortRed"]
    assert lanes(picture, "client") == ["safety"]
    assert lanes(picture, "transition") == ["SelectRed", "TRetry"]
    assert lanes(picture, "place") == ["Shown"]
    said = texts(picture)
    assert "sample — violated: G (Shown < 1 & signal(Red))" in said
    assert {
        "firings",
        "stem",
        "forever: 8–9",
        "publisher SortRed ≤ 10",
        "message lost",
        "not answered",
    } <= set(said)
    assert any(text.endswith(" silent") for text in said)
    dashed = picture.xpath("//s:g[@class='lane client']/s:path[@stroke-dasharray]", namespaces=SVG)
    assert len(dashed) == 2  # the client waits and the server works, both forever


def test_a_run_has_all_that_fig_19_shows() -> None:
    picture = parsed(trace_svg([snapshot(*run().values())], time=True))
    assert "wall-clock time" in texts(picture)
    assert lanes(picture, "client") == ["L"]
    bars = picture.xpath("//s:g[@class='lane client'][@data-id='L']/s:rect", namespaces=SVG)
    assert len(bars) == 1
    handled = picture.xpath("//s:g[@class='lane transition'][@data-id='SelectRed']/s:rect", namespaces=SVG)
    assert len(handled) == 1  # as long as its handler took
    assert "fires with handlers" in texts(picture)


def test_every_step_is_in_the_strip_and_every_lane_has_a_title() -> None:
    picture = parsed(trace_svg([snapshot(lasso())]))
    assert len(picture.xpath("//s:g[@class='strip']/s:rect", namespaces=SVG)) == 9
    drawn = picture.xpath("//s:g[starts-with(@class, 'lane ')]", namespaces=SVG)
    assert drawn
    assert all(lane.find("s:title", SVG) is not None for lane in drawn)


def test_the_filter_chooses_lanes_and_folding_makes_the_picture_narrow() -> None:
    view = snapshot(long_run(400))
    wide, narrow = (
        parsed(trace_svg([view], fold=fold, filter="T1|signals -danger")) for fold in (False, True)
    )
    assert set(lanes(wide, "transition")) == {"T1", *(f"T1{digit}" for digit in range(10))}
    assert lanes(wide, "signal") == []
    assert any(text.startswith("…") for text in texts(narrow))
    assert len(narrow.xpath("//s:g[@class='strip']/s:rect", namespaces=SVG)) > 0


def test_two_traces_and_where_they_part() -> None:
    a, b = built(lasso()), built(lasso(differs=True))
    parting = first_divergence(a, b)
    assert parting is not None
    views = [TraceCoder(builder, "x").snapshot() for builder in (a, b)]
    said = texts(parsed(trace_svg(views, divergence=parting.to_json())))
    assert "first divergence: 8" in said
    assert {"A  Red", "B  Red"} <= set(said)
    assert said.count("A  TRetry") == said.count("B  TRetry") == 1


def test_light_and_dark_differ_in_colours_only() -> None:
    view = snapshot(lasso())
    light, dark = (trace_svg([view], theme) for theme in ("light", "dark"))
    assert light != dark
    assert texts(parsed(light)) == texts(parsed(dark))


def test_png() -> None:
    content = trace_png([snapshot(lasso())], scale=1)
    assert content[:8] == b"\x89PNG\r\n\x1a\n"
    width, height = struct.unpack(">II", content[16:24])
    picture = parsed(trace_svg([snapshot(lasso())]))
    assert (width, height) == pytest.approx(
        (float(picture.get("width")), float(picture.get("height"))), abs=1
    )


def test_names_with_markup_are_shown_as_they_are() -> None:
    scribe = lasso()
    object.__setattr__(scribe.records[0], "property", '<b> & "x"')
    assert 'sample — violated: <b> & "x"' in texts(parsed(trace_svg([snapshot(scribe)])))


def test_an_empty_trace_is_drawn() -> None:
    scribe = lasso()
    scribe.records = scribe.records[:1]
    assert parsed(trace_svg([snapshot(scribe)])).tag.endswith("svg")


def test_a_schedule_has_its_windows_on_the_axis_of_time() -> None:
    view = snapshot(schedule())
    assert [step["d"]["window"] for step in view["steps"]] == [[100.0, 100.0], [130.0, 190.0], [135.0, None]]
    picture = parsed(trace_svg([view], time=True, width=1000))
    assert {"time of the schedule", "can fire"} <= set(texts(picture))
    windows = {
        lane: [
            (float(bar.get("x")), float(bar.get("width")))
            for bar in picture.xpath(f"//s:g[@data-id='{lane}']/s:rect", namespaces=SVG)
        ]
        for lane in ("tick", "work", "send")
    }
    assert windows["tick"] == []  # it can fire at one moment only
    (work,), (send,) = windows["work"], windows["send"]
    # The axis ends at 190, the last time at which a step can happen, and is 1000 pixels long.
    assert work[1] == pytest.approx(1000 * 60 / 190, abs=0.2)
    assert send[0] - work[0] == pytest.approx(1000 * 5 / 190, abs=0.2)
    assert send[0] + send[1] == pytest.approx(work[0] + work[1], abs=0.2)
    by_number = parsed(trace_svg([view]))
    assert "can fire" not in texts(by_number) and "firings" in texts(by_number)
