"""Breakpoints on the page of a trace: set by keyboard, kept by the browser, listed, jumped to."""

from __future__ import annotations

import operator
import random
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from playwright.sync_api import Page

from dineros.metamodel.records import Header
from dineros.views.traces.building import TraceBuilder
from dineros.views.traces.facts import prototype
from tests.views.browser import Visit, work
from tests.views.samples import lasso, long_run, run
from tests.views.traces.test_building import built
from tests.views.traces.test_page import cursor, page_of

NewVisit = Callable[..., Visit]


def add(page: Page, *texts: str) -> None:
    """Set breakpoints as a user does, with the keyboard only."""
    page.keyboard.press("b")
    assert page.evaluate("document.activeElement.id") == "break"
    for text in texts:
        page.keyboard.press("Control+A")
        page.keyboard.type(text)
        page.keyboard.press("Enter")
    page.keyboard.press("Escape")


def listed(page: Page) -> list[str]:
    return [str(item.get_attribute("data-text")) for item in page.query_selector_all("#breaks li[data-text]")]


def hits(page: Page, text: str = "") -> list[int]:
    found: list[int] = page.evaluate(
        "(text) => text ? dinerosTrace.breakpoints.watches.find((one) => one.condition.text === text).hits"
        " : dinerosTrace.breakpoints.steps",
        text,
    )
    return found


def test_breakpoints_are_set_hit_and_jumped_to(tmp_path: Path, visit: NewVisit) -> None:
    page = visit().open(page_of(tmp_path / "t.html", lasso()))
    assert not page.locator("#breaks").is_visible()
    add(page, "SortRed >= 1", "TRetry", "drop", "Danger = true")
    assert listed(page) == ["SortRed >= 1", "TRetry", "drop", "signal(Danger)"]
    assert hits(page) == [0, 2, 6, 7]
    visited = []
    page.keyboard.press("Home")
    for _ in range(4):
        page.keyboard.press(".")
        visited.append(cursor(page))
    assert visited == [2, 6, 7, 7]
    assert page.inner_text("#break-message") == "no breakpoint is hit after this step"
    page.keyboard.press(",")
    assert cursor(page) == 6
    assert "step 7: drop" in page.inner_text("#break-message")
    page.click("#breaks li[data-text=drop] .remove")
    assert hits(page) == [0, 2, 7]
    page.locator("#breaks li[data-text=TRetry] .goto").click()
    assert cursor(page) == 6  # none after it
    page.keyboard.press("Home")
    page.locator("#breaks li[data-text='SortRed >= 1'] .goto").click()
    assert cursor(page) == 2


def test_the_keyboard_alone_is_enough(tmp_path: Path, visit: NewVisit) -> None:
    page = visit().open(page_of(tmp_path / "t.html", lasso()))
    add(page, "drop", "TRetry")
    page.focus("#break")
    for _ in range(4):  # add, previous, next, the first breakpoint
        page.keyboard.press("Tab")
    assert "drop" in page.evaluate("document.activeElement.innerText")
    page.keyboard.press("Enter")
    assert cursor(page) == 6
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.getAttribute('aria-label')") == "remove breakpoint drop"
    page.keyboard.press("Enter")
    assert listed(page) == ["TRetry"]
    assert page.evaluate("document.activeElement.closest('#breaks') !== null")  # not lost


def test_they_survive_a_reload_for_each_model_of_its_own(tmp_path: Path, visit: NewVisit) -> None:
    one = visit()
    page = one.open(page_of(tmp_path / "t.html", lasso()))
    add(page, "drop", "!signal(Danger)")
    one.reload()
    assert listed(page) == ["drop", "!signal(Danger)"]
    assert hits(page) == [6, 8]
    other = lasso()
    header = other.records[0]
    assert isinstance(header, Header)
    other.records[0] = replace(header, model="another")
    one.open(page_of(tmp_path / "other.html", other))
    assert listed(page) == []
    one.open(tmp_path / "t.html")
    page.click("#breaks li[data-text=drop] .remove")
    one.reload()
    assert listed(page) == ["!signal(Danger)"]


@pytest.mark.parametrize("kept", ["no JSON", "{}", '[1, null, "(((", "drop"]', "null"])
def test_what_the_browser_has_kept_may_be_anything(tmp_path: Path, visit: NewVisit, kept: str) -> None:
    one = visit()
    page = one.open(page_of(tmp_path / "t.html", lasso()))
    page.evaluate("(kept) => localStorage.setItem('dineros.breakpoints.sorting', kept)", kept)
    one.reload()
    assert listed(page) == (["drop"] if "drop" in kept else [])
    add(page, "TRetry")
    assert listed(page)[-1] == "TRetry"


def test_without_storage_they_are_kept_until_the_page_closes(tmp_path: Path, visit: NewVisit) -> None:
    one = visit()
    one.page.add_init_script(
        "Object.defineProperty(window, 'localStorage',"
        " { get() { throw new DOMException('no', 'SecurityError'); } });"
    )
    page = one.open(page_of(tmp_path / "t.html", lasso()))
    add(page, "drop")
    assert hits(page) == [6]
    assert "the browser stores nothing" in page.inner_text("#breaks .unstored")


def test_what_is_no_breakpoint_is_said(tmp_path: Path, visit: NewVisit) -> None:
    page = visit().open(page_of(tmp_path / "t.html", lasso()))
    for text, says in (
        ("", "say what to stop at"),
        ("SortRed >=", "is not a breakpoint"),
        ("!fired(TRetry)", "is not a breakpoint"),
        ("Nothing >= 2", "no place is named Nothing"),
        ("fired(SortRed)", "no transition is named SortRed"),
        ("signal(TRetry)", "no signal is named TRetry"),
        ("SortRed", "SortRed is a place: say how many tokens, such as SortRed >= 1"),
        ("<b>x</b>", "is not a breakpoint"),
    ):
        add(page, text)
        assert says in page.inner_text("#break-message"), text
        assert page.get_attribute("#break", "aria-invalid") == "true"
    assert listed(page) == []


def test_the_chosen_lane_is_offered(tmp_path: Path, visit: NewVisit) -> None:
    page = visit().open(page_of(tmp_path / "t.html", lasso()))
    page.click("#labels .lane[data-id=Danger]")
    page.keyboard.press("b")
    assert page.input_value("#break") == "signal(Danger)"
    page.keyboard.press("Escape")
    page.click("#labels .lane[data-id=SelectRed]")
    page.keyboard.press("b")
    assert page.input_value("#break") == "fired(SelectRed)"
    assert page.locator("#break-names option[value='fired(TPick)']").count() == 1


OPERATORS = {
    ">=": operator.ge,
    "<=": operator.le,
    "==": operator.eq,
    "!=": operator.ne,
    ">": operator.gt,
    "<": operator.lt,
}


def expected(builder: TraceBuilder, place: str, symbol: str, number: int) -> list[int]:
    """Return the steps that make a comparison true, by the markings."""
    marking = dict(builder.initial)

    def holds() -> bool:
        tokens = sum(count for name, count in marking.items() if place in (name, prototype(name)))
        return bool(OPERATORS[symbol](tokens, number))

    found = []
    for index, step in enumerate(builder.steps):
        before = holds()
        for name, change in step.change.items():
            marking[name] = marking.get(name, 0) + change
        if holds() and not before:
            found.append(index)
    return found


def test_hits_are_those_of_the_markings(tmp_path: Path, visit: NewVisit) -> None:
    scribes = list(run().values())
    builder = built(*scribes)
    page = visit().open(page_of(tmp_path / "t.html", *scribes))
    draw = random.Random(1)
    places = sorted({prototype(place) for step in builder.steps for place in step.change})
    asked = {
        f"{place} {symbol} {number}": (place, symbol, number)
        for place, symbol, number in (
            (draw.choice(places), draw.choice(list(OPERATORS)), draw.randint(0, 2)) for _ in range(25)
        )
    }
    add(page, *asked, "TGet", "fired(GetControl[2].TGet)")
    for text, condition in asked.items():
        assert hits(page, text) == expected(builder, *condition), text
    fires = [
        i for i, step in enumerate(builder.steps)
        if step.event == "fire" and step.transition == "GetControl[2].TGet"
    ]  # fmt: skip
    assert hits(page, "TGet") == hits(page, "fired(GetControl[2].TGet)") == fires
    assert fires


def test_breakpoints_on_20_000_steps(tmp_path: Path, visit: NewVisit) -> None:
    page = visit().open(page_of(tmp_path / "t.html", long_run(20_000)))
    add(page, "signal(Danger)", "E >= 1")
    assert len(hits(page, "signal(Danger)")) == 2_500
    done = work(
        page,
        "const { breakpoints } = dinerosTrace;"
        "breakpoints.field.value = 'SensorRes >= 1'; breakpoints.submit();"
        "breakpoints.jump(1); dinerosTrace.view.paint();",
    )
    assert 20_000 <= done["steps"] < 25_000, "each step is looked at once"
