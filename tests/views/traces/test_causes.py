"""First cause and causal past on the page and in figures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from click.testing import CliRunner
from playwright.sync_api import Page

from dineros.cli.main import main
from dineros.metamodel.files import save
from dineros.metamodel.records import Fire, Header, read_records
from dineros.views.traces.coding import TraceCoder
from dineros.views.traces.figures import trace_svg
from tests.support.systems.talker import talker
from tests.views.browser import Visit
from tests.views.samples import Scribe, lasso
from tests.views.traces.test_building import built
from tests.views.traces.test_figures import parsed, texts
from tests.views.traces.test_page import cursor, page_of

NewVisit = Callable[..., Visit]
CAUSES = [1, 2, 3, 7, 8]
"""Steps that brought it about, counted from 0."""


def explained(first: int = 2) -> Scribe:
    """Return the witness of the samples, with its causes."""
    scribe = lasso()
    header = scribe.records[0]
    assert isinstance(header, Header)
    decided = {"signal(Red)": [2, 9], "Shown < 1": [0, 9], "Unsafe < 1": [1, 4]}
    scribe.records[0] = replace(header, cause=first, causes=[step + 1 for step in CAUSES], decided=decided)
    return scribe


def folded(page: Page) -> list[list[int]]:
    """Return first and last step of what is folded."""
    found: list[list[int]] = page.evaluate(
        "dinerosTrace.view.scale.folds.map((fold) => [fold.from, fold.to])"
    )
    return found


def test_the_head_says_the_first_cause_and_leads_there(tmp_path: Path, visit: NewVisit) -> None:
    page = visit().open(page_of(tmp_path / "t.html", explained()))
    button = page.locator("#head .cause")
    assert button.inner_text().startswith("first cause? step 2")
    assert "Shown < 1: from the start, to the end" in str(button.get_attribute("title"))
    button.click()
    assert cursor(page) == 1
    said = page.inner_text("#detail .causes")
    assert "First cause?" in said.replace("FIRST CAUSE?", "First cause?")
    assert "signal(Red) since step 2, to the end" in said
    assert "Unsafe < 1 since step 1, up to step 4" in said
    assert "A hint, found from this trace alone" in said
    page.keyboard.press("End")
    assert "What decides the outcome" in page.inner_text("#detail .causes")
    page.keyboard.press("c")
    assert cursor(page) == 1


def test_only_the_causes_are_shown_and_walked(tmp_path: Path, visit: NewVisit) -> None:
    one = visit()
    page = one.open(page_of(tmp_path / "t.html", explained()))
    page.keyboard.press("c")
    assert folded(page) == []
    page.keyboard.press("Shift+C")
    assert page.get_attribute("#causes", "aria-pressed") == "true"
    assert folded(page) == [[0, 0], [4, 6]]
    walked = [cursor(page)]
    for _ in range(4):
        page.keyboard.press("ArrowRight")
        walked.append(cursor(page))
    assert walked == CAUSES
    page.keyboard.press("ArrowLeft")
    assert cursor(page) == 7
    assert page.inner_text("#detail .causes") == "one of the steps that brought the outcome about"
    page.click("#causes")
    assert folded(page) == []
    page.keyboard.press("Home")
    assert "not needed for the outcome" in page.inner_text("#detail .causes")


def test_what_was_so_from_the_start(tmp_path: Path, visit: NewVisit) -> None:
    page = visit().open(page_of(tmp_path / "t.html", explained(first=0)))
    assert page.inner_text("#head .cause").startswith("first cause? from the start")
    page.keyboard.press("c")
    assert cursor(page) == -1
    assert "Shown < 1" in page.inner_text("#detail .causes")


def test_a_trace_that_does_not_say_it_has_no_button(tmp_path: Path, visit: NewVisit) -> None:
    page = visit().open(page_of(tmp_path / "t.html", lasso()))
    assert page.query_selector("#head .cause") is None
    assert not page.locator("#causes").is_visible()
    page.keyboard.press("c")
    page.keyboard.press("Shift+C")
    assert cursor(page) == 0
    assert folded(page) == []


def test_figures_mark_it() -> None:
    view = TraceCoder(built(explained()), "sample").snapshot()
    whole = parsed(trace_svg([view]))
    assert "first cause? 2" in texts(whole)
    assert "brought the outcome about" in texts(whole)
    space = {"s": "http://www.w3.org/2000/svg"}
    assert len(whole.xpath("//s:g[@class='causes']/s:rect", namespaces=space)) == len(CAUSES)
    plain = parsed(trace_svg([TraceCoder(built(lasso()), "sample").snapshot()]))
    assert not any("cause" in text for text in texts(plain))
    narrow = parsed(trace_svg([view], causes=True, width=600))
    strip = "//s:g[@class='strip']/s:rect/@width"
    cells = [float(width) for width in narrow.xpath(strip, namespaces=space)]
    assert min(cells) < max(cells) / 1.5  # those that are folded


def test_from_the_question_to_the_page(tmp_path: Path, visit: NewVisit) -> None:
    model, witness, page_file = (tmp_path / name for name in ("a.sym.xmi", "w.jsonl", "w.html"))
    save(talker(), model)

    def run(*arguments: Any) -> int:
        return CliRunner().invoke(main, [str(argument) for argument in arguments]).exit_code

    assert run("verify", model, "--signals", "none", "--ltl", "G (Noted <= 1)", "-o", witness) == 1
    header, *steps = read_records(witness)
    assert isinstance(header, Header)
    listens = [s.sequence for s in steps if isinstance(s, Fire) and s.transition == "Listen"]
    assert header.cause == listens[1]
    assert header.decided == {"Noted > 1": [listens[1], len(steps)]}
    assert run("trace", witness, "-o", page_file) == 0
    page = visit().open(page_file)
    page.keyboard.press("c")
    assert page.inner_text("#detail .text") == "Listen"
    assert "Noted > 1" in page.inner_text("#detail .causes")
