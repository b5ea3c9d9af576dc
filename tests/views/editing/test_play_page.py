"""The token game in a real browser: by clicks, by keys alone, and witnesses from files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from dineros.metamodel import sym
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.elements import find
from dineros.metamodel.files import load, save
from dineros.views.traces.reading import build
from tests.support.systems.talker import talker
from tests.views.browser import Visit, wait_until
from tests.views.editing.conftest import Edit
from tests.views.editing.driving import Hand

NewVisit = Callable[..., Visit]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    save(talker(), tmp_path / "talker.sym.xmi")
    return tmp_path / "talker.sym.xmi"


def at(hand: Hand, step: int) -> None:
    wait_until(hand.page, f"dinerosEditor.player.game?.at === {step}")


def test_a_game_by_clicks_is_kept_and_played_again(
    file: Path, tmp_path: Path, edit: Edit, visit: NewVisit
) -> None:
    _, handle = edit(file)
    one = visit()
    hand = Hand(one.page, handle.url)
    page = hand.page
    hand.button("Play")
    page.get_by_role("switch", name="Button: false").click()
    at(hand, 1)
    assert page.get_by_role("switch", name="Button: true").get_attribute("aria-checked") == "true"
    hand.open("talker")
    assert "is-enabled" in (hand.shape("Say").get_attribute("class") or "")
    hand.click("Say")
    at(hand, 2)
    assert hand.shape("Words").get_attribute("aria-label") == "place Words, 2 tokens"
    assert "is-fired" in (hand.shape("Say").get_attribute("class") or "")
    hand.click("Said")  # the publisher's queue takes it
    at(hand, 3)
    page.keyboard.press("Alt+ArrowUp")
    hand.idle()
    assert "publisher Said: 1 of 10" in (hand.shape("Chatter").text_content() or "")
    hand.drag("talker", 30, 30)
    assert "a game is on" in page.locator("#said").inner_text()
    with page.expect_download() as kept:
        page.get_by_role("link", name="Keep as a trace").click()
    kept.value.save_as(tmp_path / "game.jsonl")
    assert len(build([tmp_path / "game.jsonl"], load(file)).steps) == 3
    hand.button("End the game (p)")
    assert hand.shape("Words").count() == 0 and page.locator("#game").is_hidden()
    page.keyboard.press("p")
    at(hand, 0)
    page.locator("#game input[type=file]").set_input_files(tmp_path / "game.jsonl")
    wait_until(page, "dinerosEditor.player.game.length === 3")
    for step in (1, 2, 3):
        page.get_by_role("button", name="One step forward (→)").click()
        at(hand, step)
    page.get_by_role("button", name="signal Button becomes true").click()
    at(hand, 1)
    assert one.problems == []


@pytest.mark.long
def test_a_game_by_keys_alone_and_at_random(file: Path, edit: Edit, visit: NewVisit) -> None:
    document, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    page = hand.page
    page.keyboard.press("p")
    at(hand, 0)
    page.get_by_role("switch", name="Button: false").focus()
    page.keyboard.press("Enter")
    at(hand, 1)
    assert page.evaluate("document.activeElement.textContent") == "Button: true"  # the focus stays
    hand.open("talker")
    hand.shape("Say").focus()
    page.keyboard.press("Enter")
    at(hand, 2)
    assert page.evaluate("document.activeElement.dataset.element") == document.handles.of(
        next(each for each in document.root.eAllContents() if getattr(each, "id", None) == "Say")
    )
    page.keyboard.press("ArrowLeft")
    at(hand, 1)
    page.keyboard.press("ArrowRight")
    at(hand, 2)
    page.get_by_role("combobox", name="Steps a second").select_option("200")
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("r")
    wait_until(page, "dinerosEditor.player.game.at > 20")
    page.keyboard.press("r")
    wait_until(page, "dinerosEditor.player.running === null")
    hand.idle()
    # Somebody else changes the model: the game says that it is of an earlier one.
    other = Hand(visit().page, handle.url)
    other.open("talker")
    other.click("Words")
    other.fill("tokens", "5")
    wait_until(page, "document.body.dataset.game === 'stale'")
    page.get_by_role("button", name="Begin again").click()
    at(hand, 0)
    assert hand.shape("Words").get_attribute("aria-label") == "place Words, 5 tokens"


def test_a_signal_with_values_is_chosen_from_a_list(
    file: Path, tmp_path: Path, edit: Edit, visit: NewVisit
) -> None:
    model = load(file)
    assert isinstance(model, sym.SystemModel)
    node = find(model, "talker", sym.NodeNet)
    values = [sym.SignalValue(name=each) for each in ("mute", "low", "loud")]
    node.signals.append(sym.InputSignal(id="Mode", values=values))
    set_clause(find(model, "Say", sym.Transition), "Button & Mode <> 'mute'")
    save(model, file)
    _, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    page = hand.page
    hand.button("Play")
    page.get_by_role("switch", name="Button: false").click()
    at(hand, 1)
    hand.open("talker")
    assert "is-enabled" not in (hand.shape("Say").get_attribute("class") or "")
    mode = page.get_by_label("Mode:")
    assert mode.input_value() == "mute"
    mode.select_option("loud")
    at(hand, 2)
    assert page.get_by_label("Mode:").input_value() == "loud"
    assert "is-enabled" in (hand.shape("Say").get_attribute("class") or "")
    page.screenshot(path=tmp_path / "play.png")
    with page.expect_download() as kept:
        page.get_by_role("link", name="Keep as a trace").click()
    kept.value.save_as(tmp_path / "game.jsonl")
    built = build([tmp_path / "game.jsonl"], load(file))
    assert [step.text for step in built.steps] == ["signal Button becomes true", "signal Mode becomes loud"]
    (lane,) = (lane for lane in built.lanes.all if lane.id == "Mode")
    assert (lane.values, built.steps[1].marks) == (["mute", "low", "loud"], [[lane.index, "v", 2]])
