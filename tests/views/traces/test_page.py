"""The Trace Visualizer in a real browser."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page

from dineros.metamodel.files import load
from dineros.metamodel.records import Fire, Header
from dineros.views.nets.placement.picture import Picture
from dineros.views.traces.coding import TraceCoder
from dineros.views.traces.comparing import first_divergence
from dineros.views.traces.net_pane import net_content
from dineros.views.traces.page import trace_page
from tests.views.browser import Visit, work
from tests.views.samples import CASE_STUDY, Scribe, lasso, long_run, run
from tests.views.traces.test_building import built

NewVisit = Callable[..., Visit]


@pytest.fixture(scope="module")
def net() -> Picture:
    found = net_content(load(CASE_STUDY))
    assert found is not None
    return found


def page_of(path: Path, *scribes: Any, **more: Any) -> Path:
    view = TraceCoder(built(*scribes), "sample").snapshot()
    path.write_text(trace_page({"view": view, **more}, title="sample"), encoding="utf-8")
    return path


def cursor(page: Page) -> int:
    return int(page.evaluate("dinerosTrace.cursor"))


def labels(page: Page, kind: str = "") -> list[str]:
    selector = f"#labels .lane[data-kind={kind}]" if kind else "#labels .lane"
    return [str(element.get_attribute("data-id")) for element in page.query_selector_all(selector)]


def test_a_page_needs_no_network(tmp_path: Path, visit: NewVisit, net: Picture) -> None:
    file = page_of(tmp_path / "t.html", lasso(), net=net)
    one = visit(offline=True)
    page = one.open(file)
    assert one.requested == [file.as_uri()]
    assert page.inner_text("h1") == "sample"
    assert page.inner_text(".verdict") == "violated"
    assert labels(page, "client") == ["safety"]
    # The page's own policy forbids it as well.
    assert page.evaluate("fetch('http://127.0.0.1:9/').then(() => 'reached', () => 'refused')") == "refused"
    one.problems.clear()  # what was just tried


def test_cursor_keys_move_lanes_net_and_detail_together(
    tmp_path: Path, visit: NewVisit, net: Picture
) -> None:
    one = visit()
    page = one.open(page_of(tmp_path / "t.html", lasso(), net=net))
    assert cursor(page) == 0
    before = page.evaluate("document.getElementById('lanes').toDataURL()")
    assert "TRetry" in page.inner_text("#detail .text")
    assert page.query_selector("#net [data-id=TRetry].marked")
    assert page.query_selector("#net [data-id=SensorReq] .tokens circle")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    one.settle()
    assert cursor(page) == 2
    assert "SelectRed" in page.inner_text("#detail .text")
    assert page.get_attribute("#net", "data-step") == "2"
    assert page.query_selector("#net [data-id=SelectRed].marked")
    assert not page.query_selector("#net [data-id=TRetry].marked")
    assert page.query_selector("#net [data-id=SortRed] .tokens circle")
    assert not page.query_selector("#net [data-id=RedObjects] .tokens circle")
    assert page.evaluate("document.getElementById('lanes').toDataURL()") != before
    page.keyboard.press("ArrowLeft")
    assert cursor(page) == 1
    assert page.query_selector("#net .signal.true[data-id=Red]")
    page.keyboard.press("End")
    assert cursor(page) == 8
    assert "in the loop" in page.inner_text("#detail")
    page.keyboard.press("Home")
    assert "in the stem" in page.inner_text("#detail")
    page.keyboard.press("ArrowLeft")
    assert "before the first step" in page.inner_text("#detail")


def test_the_detail_names_the_change_and_the_deciding_literal(tmp_path: Path, visit: NewVisit) -> None:
    page = visit().open(page_of(tmp_path / "t.html", lasso()), "#3")
    assert cursor(page) == 2
    rows = [row.inner_text().split("\t") for row in page.query_selector_all("#detail tr")]
    assert rows == [["−1", "RedObjects", "1 → 0"], ["+1", "SortRed", "0 → 1"]]
    assert page.inner_text(".literal.deciding") == "✓Red"
    assert "since step 2" in page.inner_text(".why")


def test_a_click_moves_the_cursor_and_the_mouse_tells(tmp_path: Path, visit: NewVisit) -> None:
    one = visit()
    page = one.open(page_of(tmp_path / "t.html", lasso()))
    x, y = page.evaluate(
        "(() => { const box = dinerosTrace.view.scroller.getBoundingClientRect();"
        " return [box.left + dinerosTrace.view.scale.x(3), box.top + 60]; })()"
    )
    page.mouse.move(x, y)
    assert "publisher queue takes a message" in page.inner_text("#tip")
    page.mouse.click(x, y)
    assert cursor(page) == 3


def test_filter_nodes_and_silent_transitions(tmp_path: Path, visit: NewVisit) -> None:
    one = visit()
    page = one.open(page_of(tmp_path / "t.html", lasso()))
    everything = labels(page)
    page.fill("#filter", "select|retry -red")
    assert labels(page) == ["TRetry"]
    page.fill("#filter", "")
    assert labels(page) == everything
    page.click("[data-node=executor]")
    assert labels(page, "transition") == ["SelectRed"]
    page.click("[data-node=executor]")
    page.click("#labels .heading[data-group=signals]")
    assert labels(page, "signal") == []
    silent = page.locator("#labels .silent[data-group=transitions]")
    assert silent.inner_text().endswith("silent")
    silent.click()
    assert "Pick[1].TPick" in page.inner_text("#labels")


def test_folding_hides_runs_of_steps_that_do_not_matter(tmp_path: Path, visit: NewVisit) -> None:
    one = visit()
    page = one.open(page_of(tmp_path / "t.html", long_run(400)))
    page.click("#time")
    page.fill("#filter", "T1")
    wide = page.evaluate("dinerosTrace.view.scale.total")
    page.keyboard.press("Escape")
    page.keyboard.press("f")
    folded = page.evaluate("dinerosTrace.view.scale.folds.length")
    assert folded > 3
    assert page.evaluate("dinerosTrace.view.scale.total") < wide / 2
    # What is shown stays where it is: each mark has a cell of its own, and a click finds it.
    assert page.evaluate(
        "(() => { const { view, traces } = dinerosTrace;"
        " return view.rows.filter((row) => row.type === 'lane').every((row) =>"
        " row.lane.at.every((step) => view.scale.step(view.scale.x(step)) === step)); })()"
    )
    page.keyboard.press("f")
    assert page.evaluate("dinerosTrace.view.scale.total") == wide


def test_search_jumps_from_match_to_match(tmp_path: Path, visit: NewVisit) -> None:
    page = visit().open(page_of(tmp_path / "t.html", *run().values()))
    page.fill("#search", "getcontrol")
    found = page.evaluate("dinerosTrace.tools.matches")
    assert len(found) > 5
    page.keyboard.press("Enter")
    first = cursor(page)
    assert first in found
    page.keyboard.press("Enter")
    assert cursor(page) == found[found.index(first) + 1]
    page.keyboard.press("Shift+Enter")
    assert cursor(page) == first
    assert page.inner_text("#found") == f"{found.index(first) + 1} of {len(found)}"


def test_by_time_or_by_number_of_firings(tmp_path: Path, visit: NewVisit) -> None:
    one = visit()
    page = one.open(page_of(tmp_path / "t.html", *run().values()))
    assert page.inner_text("#axis") == "wall-clock time"
    page.keyboard.press("t")
    assert page.inner_text("#axis") == "firings"
    x = page.evaluate("dinerosTrace.view.scale.x(4) - dinerosTrace.view.scale.x(3)")
    assert x == pytest.approx(page.evaluate("dinerosTrace.view.scale.x(9) - dinerosTrace.view.scale.x(8)"))


def test_a_lane_is_chosen_and_its_marks_visited(tmp_path: Path, visit: NewVisit) -> None:
    page = visit().open(page_of(tmp_path / "t.html", lasso()))
    page.click("#labels .lane[data-id=Danger]")
    page.keyboard.press("]")
    assert cursor(page) == 7
    page.keyboard.press("]")
    assert cursor(page) == 8
    page.keyboard.press("[")
    assert cursor(page) == 7
    page.keyboard.press("h")
    assert "Danger" not in labels(page)
    page.click("#unhide")
    assert "Danger" in labels(page)
    page.keyboard.press("Home")
    page.keyboard.press("n")
    assert cursor(page) == 6  # the lost message


def test_two_traces_side_by_side(tmp_path: Path, visit: NewVisit) -> None:
    a, b = built(lasso()), built(lasso(differs=True))
    parting = first_divergence(a, b)
    assert parting is not None
    other = TraceCoder(b, "other").snapshot()
    file = page_of(tmp_path / "t.html", lasso(), other=other, divergence=parting.to_json())
    page = visit().open(file)
    assert cursor(page) == 7
    assert [heading.inner_text() for heading in page.query_selector_all("#detail h2")] == [
        "A: step 8 of 9", "B: step 8 of 9"]  # fmt: skip
    assert "Danger becomes true" in page.inner_text("#detail")
    assert "Blue becomes true" in page.inner_text("#detail")
    page.keyboard.press("Home")
    page.keyboard.press("v")
    assert cursor(page) == 7
    assert labels(page, "transition") == ["SelectRed", "SelectRed", "TRetry", "TRetry"]


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_theme_follows_the_system_and_can_be_changed(tmp_path: Path, visit: NewVisit, theme: str) -> None:
    page = visit(color_scheme=theme).open(page_of(tmp_path / "t.html", lasso()))
    assert page.get_attribute("html", "data-theme") == theme
    page.keyboard.press("d")
    assert page.get_attribute("html", "data-theme") != theme


def test_print_shows_one_picture(tmp_path: Path, visit: NewVisit) -> None:
    one = visit()
    page = one.open(page_of(tmp_path / "t.html", lasso()))
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    page.emulate_media(media="print")
    assert page.locator("#print > svg").is_visible()
    assert not page.locator("#scroller").is_visible()
    assert page.locator("#print > svg g.lane").count() == len(labels(page))


def test_names_that_look_like_markup_do_no_harm(tmp_path: Path, visit: NewVisit) -> None:
    scribe = lasso()
    text = "</script><script>globalThis.broken = 1</script><img src=x onerror='globalThis.broken = 2'>"
    object.__setattr__(scribe.records[0], "property", text)
    object.__setattr__(scribe.records[1], "text", text)
    page = visit().open(page_of(tmp_path / "t.html", scribe))
    assert page.inner_text(".property") == text
    assert page.inner_text("#detail .text") == text
    assert page.evaluate("globalThis.broken") is None


def test_20_000_steps_render_and_scroll(tmp_path: Path, visit: NewVisit) -> None:
    """What is done for a picture is as much as the window shows, however long the trace is."""
    one = visit()
    page = one.open(page_of(tmp_path / "t.html", long_run(20_000)))
    page.keyboard.press("t")
    one.settle()
    assert page.evaluate("dinerosTrace.view.scale.width") > 100_000
    for i in range(10):
        at = f"({i} * 7919 * 13) % dinerosTrace.view.scale.width"
        page.evaluate(f"dinerosTrace.view.scroller.scrollLeft = {at}")
        one.settle()
        done = work(page, "dinerosTrace.view.paint();")
        assert 200 < done["marks"] < 400 and 90 < done["steps"] < 200
    page.evaluate("dinerosTrace.view.fit()")  # all of them in one window
    one.settle()
    done = work(page, "dinerosTrace.view.paint();")
    assert 500 < done["steps"] < 1000 < done["marks"] < 10_000
    moves = "for (let i = 1; i <= 10; i++) { dinerosTrace.select(i * 1000); dinerosTrace.view.paint(); }"
    done = work(page, moves)
    assert 5000 < done["steps"] < 10_000 < done["marks"] < 100_000
    assert cursor(page) == 10_000


def test_labels_and_lanes_scroll_together_by_keyboard(tmp_path: Path, visit: NewVisit) -> None:
    page = visit(viewport={"width": 1300, "height": 300}).open(page_of(tmp_path / "t.html", lasso()))
    tops = "() => ['labels', 'scroller'].map((id) => document.getElementById(id).scrollTop)"
    last = page.locator("#labels button:visible").last
    last.focus()
    page.wait_for_timeout(100)
    labels_top, lanes_top = page.evaluate(tops)
    assert labels_top == lanes_top > 0
    lane = page.locator("#labels .lane").last
    row = page.evaluate("dinerosTrace.view.rows.filter((row) => row.type === 'lane').at(-1).y")
    box, window = lane.bounding_box(), page.locator("#scroller").bounding_box()
    assert box is not None and window is not None
    assert box["y"] == pytest.approx(window["y"] + row - lanes_top, abs=1)


def test_a_clause_says_nothing_of_signals_that_are_off(tmp_path: Path, visit: NewVisit) -> None:
    witness = Scribe()
    off: dict[str, Any] = {"signals": "none", "signals_initial": {"Danger": False}}
    witness.write(Header, kind="witness", model="sorting", source=str(CASE_STUDY), overflow="weighted", **off)
    witness.write(Fire, transition="TStop", node="executor", text="TStop", change={})
    page = visit().open(page_of(tmp_path / "t.html", witness))
    clause = page.inner_text("#detail .clause")
    assert "Danger" in clause and "signals are off" in clause
    assert "✗" not in clause and "decided" not in clause
    assert labels(page, "signal") == []


def test_the_net_follows_steps_of_signals(tmp_path: Path, visit: NewVisit, net: Picture) -> None:
    page = visit().open(page_of(tmp_path / "t.html", lasso(), net=net))
    page.keyboard.press("ArrowRight")
    assert "signal Red becomes true" in page.inner_text("#detail .text")
    assert page.query_selector("#net [data-id=Red].true.marked")
    lamp, pane = page.locator("#net [data-id=Red] .lamp").bounding_box(), page.locator("#net").bounding_box()
    assert lamp is not None and pane is not None
    assert pane["x"] < lamp["x"] < pane["x"] + pane["width"]
    assert pane["y"] < lamp["y"] < pane["y"] + pane["height"]
    assert lamp["width"] > 3  # it can be seen
