"""axe-core finds no serious fault: on pages of every kind, as they begin and in use, light and dark."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from dineros.metamodel.files import load, save
from dineros.views.nets import compare, save_picture, view_of
from dineros.views.traces.coding import TraceCoder
from dineros.views.traces.net_pane import net_content
from dineros.views.traces.page import trace_page
from tests.support.systems.talker import talker
from tests.views.axe import faults
from tests.views.browser import Visit, wait_until
from tests.views.editing.conftest import Edit, edit
from tests.views.live.conftest import Serve, own_state, serve
from tests.views.reports.test_check_report import report
from tests.views.samples import CASE_STUDY, lasso, save_run
from tests.views.traces.test_building import built

if TYPE_CHECKING:
    from playwright.sync_api import Page

__all__ = ["edit", "own_state", "serve"]  # fixtures

Visits = Callable[..., Visit]
TRACE = "globalThis.dinerosTrace && dinerosTrace.view.frames > 0"


@pytest.fixture(params=["light", "dark"])
def one(visit: Visits, request: pytest.FixtureRequest) -> Visit:
    return visit(color_scheme=request.param)


def keys(page: Page, *pressed: str) -> Callable[[], object]:
    """Return what presses keys, one after the other."""
    return lambda: [page.keyboard.press(key) for key in pressed]  # type: ignore[func-returns-value]


def check(page: Page, *uses: Callable[[], object]) -> None:
    """Look for faults at first and after each use."""
    assert faults(page) == []
    for use in uses:
        use()
        assert faults(page) == [], use


def test_what_is_not_accessible_is_found(one: Visit) -> None:
    one.page.set_content("<title>x</title><main><button></button></main>")
    assert [fault.partition(":")[0] for fault in faults(one.page)] == ["critical", "serious"]


def test_pages_of_nets(one: Visit, tmp_path: Path) -> None:
    save_picture(view_of(load(CASE_STUDY)), tmp_path / "net.html")
    page = one.page
    page.goto((tmp_path / "net.html").as_uri())
    wait_until(page, "Number(document.body.dataset.ready) >= 1")
    check(
        page,
        lambda: page.click('[data-id="TStop"] .shape'),
        keys(page, "/", *"safe", "ArrowDown"),
        keys(page, "Escape", "?"),
    )


def test_pages_that_compare_nets(one: Visit, tmp_path: Path) -> None:
    other = talker()
    other.pages[0].objects[0].tokens = 9  # type: ignore[attr-defined]
    other.channels.remove(other.channels[0])
    save_picture(compare(view_of(talker()), view_of(other)), tmp_path / "net.html")
    one.page.goto((tmp_path / "net.html").as_uri())
    wait_until(one.page, "Number(document.body.dataset.ready) >= 1")
    check(one.page)


def test_pages_of_traces(one: Visit, tmp_path: Path) -> None:
    view, other = (
        TraceCoder(built(lasso(differs=differs)), "sample").snapshot() for differs in (False, True)
    )
    net = net_content(load(CASE_STUDY))
    content = {"view": view, "other": other, "divergence": {"a": 7, "b": 7}, "net": net}
    (tmp_path / "trace.html").write_text(trace_page(content, title="sample"), encoding="utf-8")
    page = one.open(tmp_path / "trace.html")
    check(
        page,
        keys(page, "ArrowDown", "End"),
        keys(page, "b", *"drop", "Enter"),
        keys(page, "Escape", "?"),
    )


@pytest.mark.long
def test_the_live_page(serve: Serve, one: Visit, tmp_path: Path) -> None:
    page = one.page
    (tmp_path / "run").mkdir()
    page.goto(serve(tmp_path / "run", load(CASE_STUDY)).url)
    page.wait_for_selector("#connection[data-state=live]")
    check(page)
    save_run(tmp_path / "run")
    page.wait_for_selector("#net [data-id=SelectRed]", state="attached")
    check(page)


def test_reports(one: Visit, tmp_path: Path) -> None:
    (tmp_path / "report.html").write_text(report(), encoding="utf-8")
    one.page.goto((tmp_path / "report.html").as_uri())
    check(one.page, lambda: one.page.click("summary >> nth=0"))


def test_the_editor(edit: Edit, one: Visit, tmp_path: Path) -> None:
    save(talker(), tmp_path / "talker.sym.xmi")
    page = one.page
    page.goto(edit(tmp_path / "talker.sym.xmi")[1].url)
    wait_until(page, "document.querySelector('.djs-shape')")

    def open_in_place() -> None:
        page.locator("[aria-label^='node net listener']").press("Space")
        page.wait_for_selector("#canvas .djs-shape[aria-expanded=true]")
        page.locator("[aria-label^='callback page OnChatter']").press("Space")
        page.wait_for_selector("#canvas .djs-shape[aria-label^='place Heard']")

    check(page, open_in_place)
