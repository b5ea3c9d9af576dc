"""Breakpoints on the live page: the view stops, the application continues."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page

from dineros.metamodel.files import load
from dineros.metamodel.records import Record
from dineros.views.serving.handle import PageHandle
from tests.views.browser import Visit, wait_until
from tests.views.live.test_live_page import append, script, steps, wait_for_steps
from tests.views.samples import CASE_STUDY
from tests.views.traces.test_breakpoints import add, hits, listed

NewVisit = Callable[..., Visit]
Serve = Callable[..., PageHandle]


def parts(folder: Path) -> tuple[list[Record], list[Record]]:
    """Write the beginning of a run to a folder; return two more parts of it."""
    folder.mkdir()
    records = script()
    append(folder, records[:12])
    return records[12:20], records[20:]


def following(page: Page) -> bool:
    return page.get_attribute("#follow", "aria-pressed") == "true"


@pytest.mark.long
def test_the_view_stops_and_the_application_goes_on(tmp_path: Path, visit: NewVisit, serve: Serve) -> None:
    second, third = parts(tmp_path / "run")
    handle = serve(tmp_path / "run", load(CASE_STUDY))
    one = visit()
    page = one.page
    page.goto(handle.url)
    wait_for_steps(page, 3)
    add(page, "SelectRed", "GetControl >= 1", "request")
    assert listed(page) == ["SelectRed", "request"]  # GetControl is not a place
    page.keyboard.press("b")
    assert following(page)  # what was before stops nothing
    before = steps(page)
    append(tmp_path / "run", second)
    append(tmp_path / "run", third)
    page.wait_for_selector("#connection[data-state=stopped]")
    first = next(step for step in hits(page, "request") if step >= before)
    assert page.evaluate("dinerosTrace.cursor") == first
    assert not following(page)
    assert f"stopped at step {first + 1}: request" in page.inner_text("#break-message")
    assert "The application continues" in page.inner_text("#break-message")
    wait_until(page, "dinerosTrace.breakpoints.watches[1].hits.length === 2")  # it does
    assert page.evaluate("dinerosTrace.cursor") == first
    wait_until(page, "document.getElementById('break-message').textContent.includes('1 more hit since')")
    assert page.inner_text("#connection").startswith("stopped at a breakpoint · live")
    page.click("#follow")
    assert page.evaluate("dinerosTrace.cursor") == steps(page) - 1
    assert page.inner_text("#break-message") == ""
    page.wait_for_selector("#connection[data-state=live]")


@pytest.mark.long
def test_they_survive_a_reload_and_a_restart_of_the_server(
    tmp_path: Path, visit: NewVisit, serve: Serve
) -> None:
    second, third = parts(tmp_path / "run")
    handle = serve(tmp_path / "run", load(CASE_STUDY))
    one = visit()
    one.loses_its_server = True
    page = one.page
    page.goto(handle.url)
    wait_for_steps(page, 3)
    add(page, "reply", "StateEnd >= 1")
    page.reload()
    wait_for_steps(page, 3)
    assert listed(page) == ["reply", "StateEnd >= 1"]
    assert following(page)

    handle.stop()
    page.wait_for_selector("#connection[data-state=ended]")
    append(tmp_path / "run", second)  # while nobody serves
    append(tmp_path / "run", third)
    before = steps(page)
    again = serve(tmp_path / "run", load(CASE_STUDY))
    assert again.url == handle.url
    wait_for_steps(page, before + 1)
    assert listed(page) == ["reply", "StateEnd >= 1"]
    page.wait_for_selector("#connection[data-state=stopped]")  # at what it missed
    cursor = page.evaluate("dinerosTrace.cursor")
    assert cursor == min(hits(page))
    assert cursor >= before
    page.goto(again.url)
    wait_for_steps(page, before + 1)
    assert listed(page) == ["reply", "StateEnd >= 1"]


def test_set_before_the_run_begins(tmp_path: Path, visit: NewVisit, serve: Serve) -> None:
    """What is set while no model is known is kept for the model once it is."""
    folder = tmp_path / "later"
    handle = serve(folder, load(CASE_STUDY))
    page = visit().page
    page.goto(handle.url)
    page.wait_for_selector("#connection[data-state=live]")
    add(page, "fired(SelectRed)", "request")
    folder.mkdir()
    append(folder, script())
    page.wait_for_selector("#connection[data-state=stopped]")
    assert page.evaluate("dinerosTrace.cursor") == min(hits(page))
    page.reload()
    wait_for_steps(page, 15)
    assert listed(page) == ["fired(SelectRed)", "request"]


@pytest.mark.long
def test_two_pages_have_the_same(tmp_path: Path, browser: Browser, serve: Serve) -> None:
    parts(tmp_path / "run")
    url = serve(tmp_path / "run", load(CASE_STUDY)).url
    with browser.new_context() as context:
        page, other = context.new_page(), context.new_page()
        for one in (page, other):
            one.goto(url)
            wait_for_steps(one, 3)
        add(page, "request")
        wait_until(other, "dinerosTrace.breakpoints.watches.length === 1")
        assert listed(other) == ["request"]
        other.click("#breaks .remove")
        wait_until(page, "dinerosTrace.breakpoints.watches.length === 0")


@pytest.mark.long
def test_who_looks_elsewhere_is_left_there(tmp_path: Path, visit: NewVisit, serve: Serve) -> None:
    second, third = parts(tmp_path / "run")
    page = visit().page
    page.goto(serve(tmp_path / "run", load(CASE_STUDY)).url)
    wait_for_steps(page, 3)
    add(page, "request")
    page.keyboard.press("Home")
    append(tmp_path / "run", second + third)
    wait_until(page, "dinerosTrace.breakpoints.steps.length === 2")
    assert page.evaluate("dinerosTrace.cursor") == 0
    page.keyboard.press(".")
    assert page.evaluate("dinerosTrace.cursor") == hits(page)[0]
