"""The case study, drawn from nothing by clicks and keys."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import expect

from dineros.metamodel import sym
from dineros.metamodel.files import load
from tests.support.equality import differences
from tests.views.browser import Visit
from tests.views.editing.conftest import Edit
from tests.views.editing.draughtsman import Draughtsman
from tests.views.editing.driving import Hand

CASE_STUDY = Path(__file__).resolve().parents[3] / "case_study/sorting.sym.xmi"


@pytest.mark.long
def test_the_case_study_drawn_from_nothing(tmp_path: Path, edit: Edit, visit: Callable[..., Visit]) -> None:
    file = tmp_path / "sorting.sym.xmi"
    _, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    wanted = load(CASE_STUDY)
    assert isinstance(wanted, sym.SystemModel)
    Draughtsman(hand).draw(wanted)
    expect(hand.page.locator("#count")).to_have_text("No problems")
    hand.button("Save")
    assert differences(load(file), wanted, frozenset({"graphics"})) == []
