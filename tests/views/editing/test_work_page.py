"""Marks with what fixes them, checks and questions in a real browser."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import expect

from dineros.metamodel.files import save
from dineros.views.traces.reading import build
from tests.support.systems.talker import talker
from tests.views.browser import Visit, wait_until
from tests.views.editing.conftest import Edit
from tests.views.editing.driving import Hand

NewVisit = Callable[..., Visit]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    model = talker()
    model.channels[0].publishers[0].limit = 1  # type: ignore[attr-defined]
    save(model, tmp_path / "talker.sym.xmi")
    return tmp_path / "talker.sym.xmi"


def done(hand: Hand, job: int) -> None:
    wait_until(hand.page, f"document.querySelector('#job-{job}')?.dataset.state === 'done'", 60)


def test_a_mark_is_fixed_by_its_button_and_undone(file: Path, edit: Edit, visit: NewVisit) -> None:
    document, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    page = hand.page
    hand.open("talker")
    hand.click("Words")
    hand.fill("tokens", "-1")
    wait_until(page, "document.querySelector('#form .fix') !== null")
    page.locator("#form").get_by_role("button", name="Fix: 0 tokens").click()
    hand.idle()
    assert page.locator("#field-tokens").input_value() == "0"
    expect(page.locator("#count")).to_have_text("No problems")
    assert document.undo_label == "fix: 0 tokens"
    page.keyboard.press("Escape")
    page.keyboard.press("Control+z")
    wait_until(page, "document.querySelector('#count').textContent.startsWith('1 error,')")
    page.locator("#problems summary").click()
    page.locator("#marks").get_by_role("button", name="Fix: 0 tokens").click()
    wait_until(page, "document.querySelector('#count').textContent === 'No problems'")


@pytest.mark.long
def test_a_check_marks_what_it_finds_until_the_model_changes(file: Path, edit: Edit, visit: NewVisit) -> None:
    _, handle = edit(file)
    one = visit()
    hand = Hand(one.page, handle.url)
    page = hand.page
    page.keyboard.press("c")
    done(hand, 1)
    wait_until(page, "document.querySelector('.has-error [class~=topic], .has-warning [class~=topic]')")
    hand.click("Chatter")
    page.locator("#form").get_by_role("button", name="Play ").first.click()
    wait_until(page, "document.body.dataset.game === 'on'")
    page.get_by_role("button", name="To the end").click()
    wait_until(page, "dinerosEditor.player.game.at === dinerosEditor.player.game.length")
    page.keyboard.press("p")
    wait_until(page, "document.body.dataset.game === 'off'")
    hand.click("Chatter")
    hand.fill("id", "Gossip")
    wait_until(page, "document.querySelector('#job-1').classList.contains('old')")
    assert page.locator("#canvas .has-error, #canvas .has-warning").count() == 0
    assert page.locator("#job-1").get_by_role("button", name="Play ").first.is_disabled()
    assert one.problems == []
    host = urlsplit(handle.url).netloc
    assert {urlsplit(each).netloc for each in one.requested if not each.startswith("data:")} == {host}


@pytest.mark.long
def test_a_question_is_typed_with_names_completed(
    file: Path, tmp_path: Path, edit: Edit, visit: NewVisit
) -> None:
    _, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    page = hand.page
    page.keyboard.press("q")
    page.keyboard.type("no")
    assert page.locator("#question-names [role=option]").all_inner_texts() == ["Noted"]
    page.keyboard.press("Tab")
    page.keyboard.type(" >= 1")
    assert page.locator("#question").input_value() == "Noted >= 1"
    page.keyboard.press("Enter")
    done(hand, 1)
    assert "reachable" in page.locator("#job-1").inner_text()
    play = page.get_by_role("button", name="Play how")
    play.focus()
    page.keyboard.press("Enter")
    wait_until(page, "document.body.dataset.game === 'on'")
    assert page.locator("#game .quiet").first.inner_text() == "Noted >= 1"
    length = int(page.evaluate("dinerosEditor.player.game.length"))
    page.evaluate("document.activeElement.blur()")
    for step in range(1, length + 1):
        page.keyboard.press("ArrowRight")
        wait_until(page, f"dinerosEditor.player.game.at === {step}")
    # Where the last step was is shown.
    assert hand.shape("Noted").get_attribute("aria-label") == "place Noted, 1 token"
    with page.expect_download() as kept:
        page.get_by_role("link", name="Keep as a trace").click()
    kept.value.save_as(tmp_path / "way.jsonl")
    assert len(build([tmp_path / "way.jsonl"]).steps) == length


@pytest.mark.long
def test_generating_is_shown_first_and_a_run_is_played(file: Path, edit: Edit, visit: NewVisit) -> None:
    _, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    page = hand.page
    page.locator("#work summary").first.click()
    page.get_by_role("button", name="Generate…").click()
    page.locator("#dialog [name=workspace]").fill("space")
    page.locator("#dialog").get_by_role("button", name="Show").click()
    done(hand, 1)
    assert not (file.parent / "space").exists()
    page.get_by_role("button", name="Write them").click()
    done(hand, 2)
    assert (file.parent / "space/src/listener/package.xml").is_file()
    page.get_by_role("button", name="Run…").click()
    page.locator("#dialog [name=timeout]").fill("2")
    page.locator("#dialog").get_by_role("button", name="Run", exact=True).click()
    done(hand, 3)
    page.get_by_role("button", name="Play the run").click()
    wait_until(page, "document.body.dataset.game === 'on'")
    assert page.locator("#game .quiet").first.inner_text().startswith("run of ")


@pytest.mark.long
def test_a_run_is_watched_and_checks_follow_pauses(tmp_path: Path, edit: Edit, visit: NewVisit) -> None:
    model = talker()
    model.pages[0].signals[0].initial = True  # type: ignore[attr-defined]
    save(model, tmp_path / "talker.sym.xmi")
    _, handle = edit(tmp_path / "talker.sym.xmi")
    hand = Hand(visit().page, handle.url)
    page = hand.page
    page.locator("#work summary").first.click()
    page.get_by_role("button", name="Run…").click()
    page.locator("#dialog [name=how]").select_option("local")
    page.locator("#dialog").get_by_role("button", name="Run", exact=True).click()
    page.get_by_role("button", name="Watch the run here").click()
    noted = "Object.values(dinerosEditor.player.game?.places ?? {}).at(-1) === 3"
    wait_until(page, noted, 60)  # while it runs
    assert page.locator("#job-1").get_attribute("data-state") == "running"
    page.get_by_role("button", name="Cancel run (local)").click()
    wait_until(page, "document.querySelector('#job-1').dataset.state === 'cancelled'", 60)
    page.get_by_role("button", name="End the game (p)").click()
    page.get_by_role("checkbox", name="whenever I pause").check()
    hand.open("talker")
    hand.click("Words")
    hand.fill("tokens", "2")
    done(hand, 2)
    assert page.locator("#job-2 b").inner_text() == "check"
