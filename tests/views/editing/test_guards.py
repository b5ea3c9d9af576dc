"""Guards in the editor's page: filled in, refused with a reason, drawn and saved."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

from playwright.sync_api import expect

from dineros.metamodel import sym
from dineros.metamodel.elements import find
from dineros.metamodel.files import load
from tests.views.browser import Visit, wait_until
from tests.views.editing.conftest import Edit
from tests.views.editing.driving import Hand

ROOT = Path(__file__).resolve().parents[3]


def test_a_guard_is_filled_in_checked_drawn_and_saved(
    tmp_path: Path, edit: Edit, visit: Callable[..., Visit]
) -> None:
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
