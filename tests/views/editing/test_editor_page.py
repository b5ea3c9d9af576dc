"""The editor's page in a real browser, driven by clicks and keys."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import expect

from dineros.metamodel import sym
from dineros.metamodel.elements import find
from dineros.metamodel.files import load, save
from dineros.views.editing.contents import model_json
from tests.support.equality import differences
from tests.support.systems.talker import talker
from tests.views.browser import Visit, wait_until
from tests.views.editing.conftest import Edit
from tests.views.editing.driving import Hand

NewVisit = Callable[..., Visit]

ROOT = Path(__file__).resolve().parents[3]
FEATURES = Path(__file__).resolve().parents[4] / "shared/models/AcomodiaFeatureSym.pnml"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    save(talker(), tmp_path / "talker.sym.xmi")
    return tmp_path / "talker.sym.xmi"


def positions_differ(before: bytes, after: bytes) -> list[tuple[bytes, bytes]]:
    pairs = zip(before.splitlines(), after.splitlines(), strict=True)
    return [pair for pair in pairs if pair[0] != pair[1]]


@pytest.mark.skipif(not FEATURES.exists(), reason="the model is not here")
def test_one_element_moved_and_only_its_position_differs(tmp_path: Path, edit: Edit, visit: NewVisit) -> None:
    file = tmp_path / FEATURES.name
    shutil.copy(FEATURES, file)
    before = file.read_bytes()
    _, handle = edit(file)
    one = visit()
    hand = Hand(one.page, handle.url)
    hand.open("FeatureNode")
    hand.open("ModeSwap")
    assert hand.page.locator("#path [aria-current]").inner_text() == "ModeSwap"
    hand.drag("P2", 40, 30)
    hand.page.keyboard.press("Control+s")
    wait_until(hand.page, "document.getElementById('saved').textContent === 'saved'")
    ((was, now),) = positions_differ(before, file.read_bytes())
    assert was.strip() == b'<graphics><position x="1286" y="511"/></graphics>'
    assert now.strip().startswith(b'<graphics><position x="13') and now != was
    hand.page.keyboard.press("Control+z")
    hand.page.keyboard.press("Control+s")
    hand.idle()
    assert file.read_bytes() == before
    host = urlsplit(handle.url).netloc
    assert {urlsplit(each).netloc for each in one.requested if not each.startswith("data:")} == {host}


@pytest.mark.long
def test_a_model_drawn_from_nothing_is_the_one_that_was_built(
    tmp_path: Path, edit: Edit, visit: NewVisit
) -> None:
    file = tmp_path / "greeting.sym.xmi"
    _, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    hand.fill("middleware", "ros1")
    hand.put("node net", 0.25, 0.3, id="talker")
    hand.put("node net", 0.75, 0.3, id="listener")
    hand.tool("topic channel")
    canvas = hand.page.locator("#canvas").bounding_box()
    assert canvas is not None
    hand.page.mouse.click(canvas["x"] + canvas["width"] / 2, canvas["y"] + canvas["height"] * 0.6)
    hand.dialog(topic="chatter")
    hand.fill("id", "Chatter")

    hand.open("talker")
    hand.button("+ input signal")
    hand.fill("id", "Button")
    hand.put("place", 0.2, 0.4, id="Words", tokens="3")
    hand.put("transition", 0.5, 0.4, id="Say", clause="Button")
    hand.put("place", 0.8, 0.4, id="Said")
    hand.arc("Words", "Say")
    hand.arc("Say", "Said")
    hand.click("Said")
    hand.button("+ publisher port of Chatter")

    hand.page.keyboard.press("Alt+ArrowUp")
    hand.open("listener")
    hand.put("callback page", 0.4, 0.4, id="OnChatter")
    hand.shape("OnChatter").focus()
    hand.page.keyboard.press("Enter")
    hand.page.keyboard.press("Enter")
    assert hand.page.locator("#path [aria-current]").inner_text() == "OnChatter"
    # By keys alone: Enter on a tool puts an element down, 'a' begins an arc.
    for words, id in (("place", "Heard"), ("transition", "Listen"), ("place", "Noted")):
        tool = hand.page.locator("#tools").get_by_role("button", name=words, exact=True)
        tool.focus()
        hand.page.keyboard.press("Enter")
        hand.made(id=id)
    for source, target in (("Heard", "Listen"), ("Listen", "Noted")):
        hand.shape(source).focus()
        hand.page.keyboard.press("Enter")
        hand.page.keyboard.press("a")
        hand.shape(target).focus()
        hand.page.keyboard.press("Enter")
        hand.idle()
        hand.page.keyboard.press("Escape")
    hand.click("Heard")
    hand.button("+ subscriber port of Chatter")
    expect(hand.page.locator("#count")).to_have_text("No problems")
    hand.button("Save")
    drawn, built = load(file), talker()
    for arc in (each for each in drawn.eAllContents() if type(each).__name__ == "Arc"):
        arc.id = f"{arc.source.id}-{arc.target.id}"  # type: ignore[attr-defined]
    assert differences(drawn, built, frozenset({"graphics"})) == []


@pytest.mark.long
def test_two_tabs_agree_and_say_what_is_refused(file: Path, edit: Edit, visit: NewVisit) -> None:
    document, handle = edit(file)
    one, two = Hand(visit().page, handle.url), Hand(visit().page, handle.url)
    one.open("talker")
    one.click("Words")
    one.fill("tokens", "8")
    one.page.keyboard.press("Escape")
    two.open("talker")
    two.page.wait_for_selector("#canvas .djs-shape[aria-label='place Words, 8 tokens']")
    two.click("Said")
    two.page.keyboard.press("Delete")
    one.page.wait_for_selector("#canvas .djs-shape[aria-label*='Said']", state="detached")
    one.page.keyboard.press("Control+z")
    one.idle()
    two.page.wait_for_selector("#canvas .djs-shape[aria-label*='Said']")
    one.click("Say")
    one.fill("clause", "Button & Knob")
    assert (
        "the node net 'talker' has no signal 'Knob'"
        in one.page.locator(".row .said:not(:empty)").inner_text()
    )
    one.fill("clause", "Button &")
    assert "column 9" in one.page.locator("#said").inner_text()
    one.click("Words")
    one.fill("tokens", "-2")
    one.page.wait_for_selector("#canvas .djs-shape.has-error[aria-label*='Words']")
    two.page.wait_for_selector("#canvas .djs-shape.has-error[aria-label*='Words']")
    assert two.page.locator("#count").inner_text().startswith("1 error,")
    assert one.model() == two.model() == json.loads(json.dumps(model_json(document)))


def test_the_page_goes_on_after_the_server_was_killed(file: Path, visit: NewVisit, edit: Edit) -> None:
    document, handle = edit(file)
    visiting = visit()
    visiting.loses_its_server = True
    hand = Hand(visiting.page, handle.url)
    hand.open("talker")
    hand.click("Words")
    hand.fill("tokens", "5")
    handle.stop()
    document._journal.close(remove=False)
    hand.page.wait_for_selector("body[data-connection=lost]")
    hand.page.locator("#field-tokens").fill("6")
    hand.page.locator("#field-tokens").press("Enter")  # nobody hears it yet
    again, _ = edit(file)
    hand.page.wait_for_selector("body[data-connection=live]")
    hand.idle()
    wait_until(hand.page, "dinerosEditor.model.state.undo !== null")
    assert again.recovered == 1
    again.undo()
    assert [each.tokens for each in again.root.eAllContents() if getattr(each, "id", "") == "Words"] == [5]  # type: ignore[attr-defined]


def test_what_somebody_else_wrote_can_be_compared_and_taken(file: Path, edit: Edit, visit: NewVisit) -> None:
    _, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    hand.fill("name", "mine")
    other = talker()
    other.name = "theirs"
    save(other, file)
    banner = hand.page.locator("#banner")
    banner.wait_for()
    with hand.page.expect_popup() as opened:
        banner.get_by_text("Compare").click()
    wait_until(opened.value, "Number(document.body?.dataset.ready) >= 1")
    assert "theirs → mine" in opened.value.locator("h1").inner_text()
    opened.value.close()
    hand.button("Take theirs")
    wait_until(hand.page, "document.getElementById('field-name').value === 'theirs'")
    assert banner.is_hidden()


def test_everything_has_a_role_and_a_name(file: Path, edit: Edit, visit: NewVisit) -> None:
    _, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    hand.open("talker")
    unnamed = hand.page.evaluate(
        """() => [...document.querySelectorAll('button, input, select, a, [role=button], [role=toolbar]')]
            .filter((each) => !each.closest('dialog:not([open])'))
            .filter((each) => !(each.getAttribute('aria-label') || each.textContent.trim()
                || each.labels?.[0]?.textContent.trim()))
            .map((each) => each.outerHTML)"""
    )
    assert unnamed == []
    for theme in ("light", "dark"):
        hand.page.select_option("#theme", theme)
        hand.shape("Words").focus()
        hand.page.keyboard.press("Shift+Tab")
        hand.page.keyboard.press("Tab")
        colours = hand.page.evaluate(
            "[getComputedStyle(document.body).color, getComputedStyle(document.body).backgroundColor]"
        )
        assert colours[0] != colours[1]
        shape = hand.shape("Words").locator(".shape")
        assert shape.evaluate("(each) => getComputedStyle(each).strokeWidth") == "3.5px"


def test_a_guard_is_filled_in_checked_drawn_and_saved(tmp_path: Path, edit: Edit, visit: NewVisit) -> None:
    file = tmp_path / "guarded.sym.xmi"
    shutil.copy(ROOT / "case_study/guarded.sym.xmi", file)
    _, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    hand.open("controller")
    hand.open("RobotControllerL")
    hand.click("TStartPlaceL")
    field, drawn = hand.page.locator("#field-guard"), hand.shape("TStartPlaceL").locator(".clause")
    expect(field).to_have_value("pickSuccess = true")
    expect(drawn).to_have_text("[pickSuccess = true]")

    hand.fill("guard", "pickSucces = true")
    expect(hand.page.locator("#count")).to_have_text("1 error, 0 warnings")
    hint = "no place has a field 'pickSucces'did you mean 'pickSuccess'?"
    expect(hand.page.locator("#form")).to_contain_text(hint)

    hand.fill("guard", "not (pickSuccess = false)")
    expect(hand.page.locator("#count")).to_have_text("No problems")
    expect(drawn).to_have_text("[not (pickSuccess = false)]")
    hand.page.keyboard.press("Control+s")
    wait_until(hand.page, "document.getElementById('saved').textContent === 'saved'")
    saved = load(file)
    assert isinstance(saved, sym.SystemModel)
    assert find(saved, "TStartPlaceL", sym.Transition).guard == "not (pickSuccess = false)"
