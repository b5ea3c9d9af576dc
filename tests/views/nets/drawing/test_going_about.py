"""Going about on the page of a net: what is seen stays, lines are marked, links lead back, files are kept."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from dineros.views.nets import collapse, layout, to_svg, view_of
from tests.views.nets.drawing.page_parts import area, drawn, marked, opened, saved, scale, shown
from tests.views.nets.samples import case_study

if TYPE_CHECKING:
    from playwright.sync_api import Page

    from tests.views.browser import Visit

    Visits = Callable[..., Visit]


def test_clicks_and_escape_move_nothing(study: Page) -> None:
    before, was = area(study, "RedObjects", ".shape"), scale(study)
    for _ in range(3):
        study.click('[data-id="RedObjects"] .shape')
        assert study.is_visible("#detail")
        assert area(study, "RedObjects", ".shape") == pytest.approx(before, abs=0.5)
        study.keyboard.press("Escape")
        assert not study.is_visible("#detail")
        assert area(study, "RedObjects", ".shape") == pytest.approx(before, abs=0.5)
    assert scale(study) == pytest.approx(was)


def test_what_the_detail_would_cover_moves_into_sight(study: Page) -> None:
    right = max(("TShowResult", "TSense", "TStop"), key=lambda id: area(study, id)["right"])
    study.click(f'[data-id="{right}"] .shape')
    assert area(study, right)["right"] <= area(study, right)["width"] + study.evaluate(
        "document.querySelector('#picture').getBoundingClientRect().right"
    )


def test_windows_of_other_sizes_and_back(study: Page) -> None:
    whole = scale(study)
    for width in (700, 1000, 1300):
        study.set_viewport_size({"width": width, "height": 800})
        study.wait_for_timeout(50)
    assert scale(study) == pytest.approx(whole, rel=1e-3)
    study.keyboard.press("+")
    larger = scale(study)
    for width in (700, 1000, 1300):
        study.set_viewport_size({"width": width, "height": 800})
        study.wait_for_timeout(50)
    assert scale(study) == pytest.approx(larger, rel=1e-3)


@pytest.mark.long
def test_collapsing_keeps_scale_and_place_and_no_hint(study: Page) -> None:
    study.keyboard.press("+")
    study.keyboard.press("+")
    study.evaluate("document.querySelector('#picture [data-id=Safety]').focus()")
    was, sign = scale(study), area(study, "Safety", ".fold .knob")
    study.hover('[data-id="Safety"] .fold .knob')
    assert study.is_visible("#hint")
    study.mouse.down()
    study.mouse.up()
    drawn(study, 2)
    assert "TStop" not in shown(study)
    assert not study.is_visible("#hint")
    assert scale(study) == pytest.approx(was)
    assert area(study, "Safety", ".fold .knob") == pytest.approx(sign, abs=1)
    study.keyboard.press("c")
    drawn(study, 3)
    assert "Safety" not in shown(study)
    assert scale(study) == pytest.approx(was)


def test_lines_of_what_is_pointed_at_or_chosen_are_marked(study: Page) -> None:
    edges = view_of(case_study()).edges
    near = {edge.id for edge in edges if "TShowResult" in (edge.source, edge.target)}
    assert near
    study.hover('[data-id="TShowResult"] .shape')
    assert marked(study, "near") == near
    study.mouse.move(5, 5)
    assert marked(study, "near") == set()
    study.click('[data-id="TShowResult"] .shape')
    study.mouse.move(5, 5)
    assert marked(study, "near") == near
    assert marked(study, "marked") == {"TShowResult"}
    study.keyboard.press("Escape")
    assert marked(study, "near") == set()
    study.evaluate("document.querySelector('#picture [data-id=Shown]').focus()")  # by keyboard, too
    assert marked(study, "near") == {edge.id for edge in edges if "Shown" in (edge.source, edge.target)}


def test_a_collapsed_page_stands_for_what_is_chosen_in_it(study: Page) -> None:
    study.evaluate("document.querySelector('#picture [data-id=TStop]').focus()")
    study.keyboard.press("Enter")
    study.keyboard.press("c")
    drawn(study, 2)
    assert marked(study, "marked") == {"executor"}


@pytest.mark.long
def test_the_address_leads_to_what_is_seen(visit: Visits, study: Page, study_page: Path) -> None:
    study.click('[data-id="selector"] .fold')
    drawn(study, 2)
    study.click('[data-id="Feedback"] .shape')
    seen, address = shown(study), str(study.evaluate("location.hash"))
    again = opened(visit(), study_page, address)
    drawn(again, 2)
    again.wait_for_selector('[data-id="Feedback"].marked', state="attached")
    assert shown(again) == seen
    assert again.inner_text("#detail h2") == "Feedback"
    again.fill("#steps", "1")
    again.click("#around")
    drawn(again, 3)
    part = opened(visit(), study_page, str(again.evaluate("location.hash")))
    drawn(part, 2)
    assert shown(part) == shown(again)
    assert "TStop" not in shown(part)


@pytest.mark.long
def test_a_link_that_is_followed_on_the_page(study: Page) -> None:
    study.evaluate("location.hash = '#element=TStop'")
    drawn(study, 2)
    study.wait_for_selector('[data-id="TStop"].marked', state="attached")
    assert study.inner_text("#detail h2") == "TStop"


def test_a_link_to_nothing_says_so(visit: Visits, study_page: Path) -> None:
    page = opened(visit(), study_page, "#element=%3Cb%3Enobody%3C%2Fb%3E&steps=x")
    assert page.inner_text("#state") == "the link leads to <b>nobody</b>, which is not here"
    assert "TStop" in shown(page)


@pytest.mark.long
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_picture_is_saved_as_python_would(visit: Visits, study_page: Path, theme: str) -> None:
    page = opened(visit(color_scheme=theme), study_page)
    with page.expect_download() as download:
        page.click("#svg")
    positioned = json.loads(page.inner_text("#positioned"))
    kept = download.value.path().read_text(encoding="utf-8")
    assert kept == to_svg(positioned, theme="dark" if theme == "dark" else "light")
    assert download.value.suggested_filename == "sorting.svg"
    with page.expect_download() as download:
        page.click("#png")
    image = download.value.path().read_bytes()
    assert image.startswith(b"\x89PNG\r\n\x1a\n")
    assert struct.unpack(">II", image[16:24]) == (
        pytest.approx(2 * positioned["width"], abs=1),
        pytest.approx(2 * positioned["height"], abs=1),
    )


@pytest.mark.long
def test_layout_runs_beside_the_page_and_as_in_python(visit: Visits, tmp_path: Path) -> None:
    page = opened(visit(), saved(collapse(view_of(case_study()), ["executor"]), tmp_path))
    assert page.workers == []
    page.click('[data-id="executor"] .fold')
    drawn(page, 2)
    assert len(page.workers) == 1
    assert page.evaluate("typeof ELK") == "undefined"
    whole = layout(view_of(case_study()))
    with page.expect_download() as download:
        page.click("#svg")
    assert download.value.path().read_text(encoding="utf-8") == to_svg(whole)
