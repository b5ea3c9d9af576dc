"""The page of a net, in a real browser, from a file and without a network."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from dineros.views.javascript.modules import linked
from dineros.views.nets import collapse, compare, view_of
from tests.support.systems.talker import talker
from tests.views.nets.arranged import displaced
from tests.views.nets.drawing.page_parts import area, centres, drawn, opened, positioned, saved, shown
from tests.views.nets.samples import arranged_study, case_study

if TYPE_CHECKING:
    from playwright.sync_api import Page

    from tests.views.browser import Visit

    Visits = Callable[..., Visit]


def width_shown(page: Page) -> float:
    return float(str(page.get_attribute("#picture", "viewBox")).split()[2])


def test_it_loads_without_a_network_and_asks_for_nothing(visit: Visits, study_page: Path) -> None:
    one = visit(offline=True)
    opened(one, study_page)
    assert one.requested == [study_page.as_uri()]
    assert len(shown(one.page)) == len(view_of(case_study()).nodes) + len(view_of(case_study()).boxes)


@pytest.mark.long
def test_pages_collapse_and_expand_in_place(study: Page) -> None:
    before = shown(study)
    study.click('[data-id="Safety"] .fold')
    drawn(study, 2)
    assert before - shown(study) == {
        "Safe",
        "Unsafe",
        "SensorReq",
        "SensorRes",
        "TSafe",
        "TUnsafe",
        "TRetry",
        "TStop",
    }
    assert "6 nodes" not in study.inner_text("#state")
    assert study.evaluate("document.activeElement.dataset.id") == "Safety"
    study.keyboard.press("Space")
    drawn(study, 3)
    assert shown(study) == before


def test_all_pages_collapse_and_expand_by_key(study: Page) -> None:
    before = shown(study)
    study.keyboard.press("c")
    drawn(study, 2)
    nets = {"selector", "controller", "synchronizer", "executor", "sensorics", "feedback"}
    assert nets <= shown(study)
    assert len(shown(study)) == len(nets) + 8
    study.keyboard.press("x")
    drawn(study, 3)
    assert shown(study) == before


def test_search_finds_opens_and_shows(study: Page) -> None:
    study.keyboard.press("c")
    drawn(study, 2)
    study.keyboard.press("/")
    study.keyboard.type("tstop")
    assert study.locator("#search-list li").first.inner_text().startswith("TStop")
    study.keyboard.press("Enter")
    drawn(study, 3)
    study.wait_for_selector('[data-id="TStop"].marked')
    assert study.inner_text("#detail h2") == "TStop"
    assert "ICStop: Danger" in study.inner_text("#detail")
    place = area(study, "TStop")
    assert place["x"] > 0 and place["y"] > 0 and place["x"] < 1300 and place["height"] > 15


def test_search_without_success_says_so(study: Page) -> None:
    study.keyboard.press("f")
    study.keyboard.type("zzz")
    assert study.inner_text("#state") == "nothing found"
    study.keyboard.press("Escape")
    assert study.evaluate("document.activeElement.id") == "picture"


def test_steps_around_an_element(study: Page) -> None:
    everything = shown(study)
    study.click('[data-id="Feedback"]')
    study.fill("#steps", "1")
    study.click("#around")
    drawn(study, 2)
    assert shown(study) == {"feedback", "ReceiveResult", "Feedback", "TShowResult", "UITopic"}
    study.click("#everything")
    drawn(study, 3)
    assert shown(study) == everything


def test_the_detail_leads_on_to_neighbours(study: Page) -> None:
    study.click('[data-id="TShowResult"]')
    study.click("#detail >> text=Shown")
    assert study.inner_text("#detail h2") == "Shown"
    study.keyboard.press("Escape")
    assert not study.is_visible("#detail")


def test_hovering_tells_more(study: Page) -> None:
    study.hover('[data-id="TPickSuccess"] .shape')
    assert "Input clause: ICPickSuccess" in study.inner_text("#hint")
    study.hover('[data-id="LeftCellObjects"] .shape')
    assert study.inner_text("#hint").startswith("LeftCellObjects topic")
    study.mouse.move(5, 400)
    assert not study.is_visible("#hint")


def test_wheel_drag_and_keys_move_the_picture(study: Page) -> None:
    whole = width_shown(study)
    study.mouse.move(600, 400)
    study.mouse.wheel(0, -400)
    study.wait_for_function(
        f"document.querySelector('#picture').getAttribute('viewBox').split(' ')[2] < {whole * 0.8}"
    )
    before = area(study, "Pick")
    study.mouse.down()
    study.mouse.move(650, 420, steps=4)
    study.mouse.up()
    after = area(study, "Pick")
    assert (after["x"] - before["x"], after["y"] - before["y"]) == pytest.approx((50, 20), abs=2)
    assert not study.is_visible("#detail")  # a drag is not a click
    study.keyboard.press("ArrowRight")
    assert area(study, "Pick")["x"] < after["x"]
    study.keyboard.press("0")
    assert width_shown(study) == pytest.approx(whole, rel=0.01)


def test_elements_are_reached_by_keyboard(study: Page) -> None:
    study.focus("#picture")
    study.keyboard.press("Tab")
    assert study.evaluate("document.activeElement.dataset.id") == "selector"
    assert study.evaluate("document.activeElement.ariaRoleDescription") == "ROS node"
    study.keyboard.press("Enter")
    assert study.inner_text("#detail h2") == "selector"


def test_it_follows_the_reader_s_colours(visit: Visits, study_page: Path) -> None:
    def paper(page: Page) -> Any:
        return page.evaluate("getComputedStyle(document.querySelector('#picture .paper')).fill")

    page = opened(visit(color_scheme="dark"), study_page)
    assert paper(page) == "rgb(16, 22, 31)"
    page.select_option("#theme", "light")
    assert paper(page) == "rgb(255, 255, 255)"


def test_help_lists_keys_and_signs(study: Page) -> None:
    study.keyboard.press("?")
    assert "search" in study.inner_text("#help")
    assert study.locator("#legend g[data-id]").count() >= 12
    study.keyboard.press("Escape")
    assert not study.is_visible("#help")


def test_differences_are_listed_and_walked_through(visit: Visits, tmp_path: Path) -> None:
    other = talker()
    other.pages[0].objects[0].tokens = 9  # type: ignore[attr-defined]
    other.channels.remove(other.channels[0])
    page = opened(visit(), saved(compare(view_of(talker()), view_of(other)), tmp_path))
    assert page.inner_text("#detail h2") == "4 differences"
    assert [sign.inner_text() for sign in page.locator("#detail .sign").all()] == ["≠", "−", "−", "−"]
    page.keyboard.press("n")
    assert page.inner_text("#detail h2") == "Words"
    assert "tokens: 3 → 9" in page.inner_text("#detail")
    page.keyboard.press("n")
    assert page.inner_text("#detail h2") == "Chatter"
    page.keyboard.press("p")
    assert page.inner_text("#detail h2") == "Words"


def test_names_cannot_become_markup(visit: Visits, tmp_path: Path) -> None:
    model = talker()
    evil = "</script><img src=x onerror=document.title='broken'>"
    model.name = evil
    model.pages[0].objects[0].name = evil
    page = opened(visit(), saved(view_of(model), tmp_path))
    assert page.title() == evil
    assert page.locator("img").count() == 0
    page.hover('[data-id="Words"] .shape')
    assert page.locator("img").count() == 0


def test_marking_signals_and_highlights_change_without_drawing_anew(visit: Visits, study_page: Path) -> None:
    page = opened(visit(), study_page)
    result = page.evaluate(
        f"const {{ DrawnNet }} = {linked('net/renderer.js')};"
        """
          const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
          document.body.append(svg);
          const positioned = JSON.parse(document.getElementById("positioned").textContent);
          const picture = new DrawnNet(svg, positioned, {Safe: 7});
          const tokens = (id) => picture.element(id).querySelector(".tokens");
          const dots = (id) => tokens(id).textContent || tokens(id).querySelectorAll("circle").length;
          const before = [dots("Safe"), dots("Safe@PickServer"), dots("Unsafe")];
          const group = picture.element("Safe");
          picture.setMarking({Safe: 2, Unsafe: 0, nobody: 3});
          picture.setSignals({Danger: true, nobody: true});
          picture.highlight(["TStop", "TPick-Safe@PickServer", "nobody"]);
          const marked = [...svg.querySelectorAll(".marked")].map((one) => one.dataset.id);
          picture.highlight([]);
          ({before, after: [dots("Safe"), dots("Safe@PickServer"), dots("Unsafe"), dots("StateGet")],
            same: group === picture.element("Safe"), marked, left: svg.querySelectorAll(".marked").length,
            danger: picture.element("Danger").getAttribute("class")});
        """
    )
    assert result == {
        "before": ["7", "7", 1],
        "after": [2, 2, 0, 1],
        "same": True,
        "marked": ["Safe@PickServer-TPick", "TStop"],
        "left": 0,
        "danger": "signal true",
    }


def test_a_collapsed_view_starts_collapsed(visit: Visits, tmp_path: Path) -> None:
    page = opened(visit(), saved(collapse(view_of(case_study()), ["executor"]), tmp_path))
    assert "TStop" not in shown(page)
    assert "executor" in shown(page)


def test_stored_positions_hold_while_pages_open_and_close(visit: Visits, tmp_path: Path) -> None:
    view = collapse(view_of(arranged_study()))
    page = opened(visit(), saved(view, tmp_path))
    before = centres(page)
    stored = {item.id: item.position for item in view.shapes() if item.position and item.id in before}
    assert len(stored) == 13
    assert list(displaced(view, positioned(page))) == []
    study_only = {id: before[id] for id in stored}
    page.click('[data-id="executor"] .fold')
    drawn(page, 2)
    assert "PickServer" in shown(page)
    assert list(displaced(view, positioned(page))) == []
    page.click('[data-id="PickServer"] .fold')
    drawn(page, 3)
    after = centres(page)
    for one, other in itertools.combinations(stored, 2):
        for axis in (0, 1):
            was, now = (at[other][axis] - at[one][axis] for at in (study_only, after))
            assert was * now > 0 or abs(was) < 0.2, (one, other)
    page.click('[data-id="executor"] .fold')
    drawn(page, 4)
    assert centres(page) == before
