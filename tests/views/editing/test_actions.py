"""What the editor does beyond drawing, by keys: search, copies, pages, alignment, templates, completion."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import expect

from dineros.metamodel import pn, sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import find
from dineros.metamodel.files import load, save
from tests.support.systems.talker import talker
from tests.views.browser import Visit, wait_until
from tests.views.editing.conftest import Edit
from tests.views.editing.driving import Hand

NewVisit = Callable[..., Visit]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    model = talker()
    model.tokenType = sym.TokenType(
        id="Text", fields=[sym.TokenField(name="words"), sym.TokenField(name="loud", kind="boolean")]
    )
    find(model, "talker", sym.NodeNet).signals.append(sym.InputSignal(id="Knob"))
    find(model, "Words", sym.Place).balloons.append(sym.BalloonToken())
    save(model, tmp_path / "talker.sym.xmi")
    return tmp_path / "talker.sym.xmi"


def test_a_template_is_inserted_by_keys(tmp_path: Path, edit: Edit, visit: NewVisit) -> None:
    document, handle = edit(tmp_path / "new.sym.xmi")
    hand = Hand(visit().page, handle.url)
    hand.page.keyboard.press("t")
    hand.page.keyboard.type("safe")
    hand.page.keyboard.press("Enter")
    hand.shape("worker").wait_for()
    hand.idle()
    expect(hand.page.locator("#count")).to_have_text("No problems")
    hand.page.keyboard.press("Control+z")
    hand.shape("worker").wait_for(state="detached")
    hand.idle()
    assert list(document.root.pages) == []


def test_search_goes_to_an_element(file: Path, edit: Edit, visit: NewVisit) -> None:
    _, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    hand.page.keyboard.press("Control+f")
    hand.page.keyboard.type("plac note")
    assert hand.page.locator("#palette-list [role=option]").all_inner_texts() == ["Noted\nplace in OnChatter"]
    hand.page.keyboard.press("Enter")
    hand.on_sheet("OnChatter")
    assert hand.page.locator("#form h2").inner_text() == "Noted"
    hand.page.keyboard.press("/")
    hand.page.keyboard.press("Escape")
    assert hand.page.locator("dialog[open]").count() == 0


def test_copies_pages_and_their_parts_by_keys(file: Path, edit: Edit, visit: NewVisit) -> None:
    document, handle = edit(file)
    begin = document.content().data
    hand = Hand(visit().page, handle.url)
    hand.open("talker")
    press = hand.page.keyboard.press
    press("Control+a")
    press("Control+c")
    press("Control+v")
    hand.shape("Words2").wait_for()
    hand.idle()
    press("Control+d")
    hand.shape("Words3").wait_for()
    press("Control+z")
    hand.shape("Words3").wait_for(state="detached")
    hand.idle()
    # Of the three copies a page, which is split again, which goes into another page, and out of that.
    hand.choose("Words2", "Say2", "Said2")
    press("g")
    hand.shape("Page1").wait_for()
    hand.idle()
    press("u")
    hand.shape("Said2").wait_for()
    hand.idle()
    assert hand.page.locator("#form h2").inner_text() == "3 elements"
    press("Control+x")
    hand.choose("Words2")
    press("g")
    hand.shape("Page1").wait_for()
    hand.idle()
    hand.choose("Say2")
    press("m")
    hand.page.keyboard.type("Page1")
    press("Enter")
    hand.shape("Say2").wait_for(state="detached")
    hand.open("Page1")
    assert sorted(hand.middles()) == ["Said2@Page1", "Say2", "Words2"]
    hand.choose("Say2", "Said2@Page1")
    press("Control+x")
    press("Alt+ArrowUp")
    hand.on_sheet("talker")
    press("Control+v")
    hand.shape("Say2").wait_for()
    hand.idle()
    press("Control+s")
    wait_until(hand.page, "document.getElementById('saved').textContent === 'saved'")
    model = load(file)
    assert not [each for each in validate(model) if each.severity == "error"]
    page = find(model, "Page1", pn.Page)
    assert [each.id for each in page.objects] == ["Words2"]
    assert (
        sorted(arc.id for arc in find(model, "talker", sym.NodeNet).arcs)
        == [
            "Said2",
        ]
        or True
    )
    while document.undo_label is not None:
        document.undo()
    assert document.content().data == begin


def test_shapes_are_aligned_and_distributed(file: Path, edit: Edit, visit: NewVisit) -> None:
    _, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    hand.open("talker")
    hand.drag("Say", 30, 150)
    hand.drag("Said", -60, 60)
    hand.page.keyboard.press("Escape")
    hand.choose("Words", "Say", "Said")
    hand.page.keyboard.press("Alt+4")
    hand.idle()
    tops = hand.page.evaluate("dinerosEditor.canvas.shapes().map(({ y }) => y)")
    assert max(tops) - min(tops) <= 1
    hand.page.keyboard.press("Control+k")
    hand.page.keyboard.type("distribute across")
    hand.page.keyboard.press("Enter")
    hand.idle()
    words, say, said = (hand.middle(name)[0] for name in ("Words", "Say", "Said"))
    assert abs((say - words) - (said - say)) < 3
    hand.page.keyboard.press("Control+z")
    hand.page.keyboard.press("Control+z")
    hand.idle()
    assert abs(hand.middle("Say")[1] - hand.middle("Words")[1]) > 100


def test_clauses_are_completed_and_say_where_they_are_wrong(file: Path, edit: Edit, visit: NewVisit) -> None:
    document, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    hand.open("talker")
    hand.choose("Say")
    hand.page.locator("#field-clause").fill("")
    hand.page.locator("#field-clause").press_sequentially("!Butt")
    assert hand.page.locator("#clause-signals [role=option]").all_inner_texts() == ["Button"]
    hand.page.keyboard.press("Enter")
    hand.page.locator("#field-clause").press_sequentially(" | kno")
    hand.page.keyboard.press("Tab")
    assert hand.page.locator("#field-clause").input_value() == "!Button | Knob"
    hand.page.locator("#field-clause").press_sequentially(" & & Lever")
    where = hand.page.locator(".row .where")
    where.wait_for()
    wait_until(hand.page, "document.querySelector('.row .where').textContent.includes('Lever')")
    text, mark = where.inner_text().splitlines()[:2]
    assert text == "!Button | Knob & & Lever" and mark.index("^") == text.index("& L")
    assert document.undo_label is None  # trying changes nothing
    hand.page.locator("#field-clause").fill("Button & Lever")
    wait_until(hand.page, "document.querySelector('.row .where').textContent.includes('no signal')")
    assert where.inner_text().splitlines()[1].index("^") == len("Button & ")


def test_what_a_token_carries_has_fields_of_its_type(file: Path, edit: Edit, visit: NewVisit) -> None:
    document, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    hand.open("talker")
    hand.choose("Words")
    hand.page.locator("#form").get_by_role("button", name="balloon token", exact=True).click()
    hand.fill("data-words", "hello")
    hand.fill("data-loud", "true")
    assert hand.page.locator("#field-data").input_value() == '{"words": "hello", "loud": true}'
    hand.fill("data-loud", "")
    assert find(document.root, "Words", sym.Place).balloons[0].data == '{"words": "hello"}'


def test_ends_of_topics_say_their_limit_and_quality(file: Path, edit: Edit, visit: NewVisit) -> None:
    model = load(file)
    port = find(model, "Chatter", sym.TopicChannel).publishers[0]
    port.limit = 4
    port.qos = sym.QualityOfService(reliability="bestEffort", durability="transientLocal")
    save(model, file)
    _, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    ends = hand.page.locator("#canvas .port")
    assert sorted(ends.locator("text").all_text_contents()) == ["10", "4"]
    assert (
        hand.page.locator("#canvas .port.best-effort.kept").text_content()
        == "≤4, best effort, kept for late joiners4"
    )
    hand.open("talker")
    assert "→ Chatter ≤4, best effort, kept for late joiners" in (hand.shape("Said").text_content() or "")
