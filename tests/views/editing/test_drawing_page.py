"""Whole models drawn from nothing: that of the page *Draw a model*, as it says, and the case study."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Browser, expect

from dineros.metamodel import sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.files import load
from tests.support.equality import differences
from tests.support.systems.talker import talker
from tests.views.browser import Visit
from tests.views.editing.conftest import Edit
from tests.views.editing.draughtsman import Draughtsman
from tests.views.editing.driving import Hand

ROOT = Path(__file__).resolve().parents[3]


@pytest.mark.long
def test_the_page_draws_the_talker_and_the_listener(tmp_path: Path, browser: Browser) -> None:
    pytest.importorskip("mkdocs", reason="the extra [docs] is not installed")
    specification = importlib.util.spec_from_file_location("drawing", ROOT / "docs/hooks/editor_pictures.py")
    assert specification is not None and specification.loader is not None
    hook = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(hook)
    file = tmp_path / "greeting.sym.xmi"
    pictures = hook.drawn(file, browser)
    page = (ROOT / "docs/drawing.md").read_text(encoding="utf-8")
    assert set(re.findall(r"\((pictures/drawing-[a-z-]+\.png)#", page)) == set(pictures)
    assert set(pictures) == {hook.path(step, theme) for step in hook.STEPS for theme in ("light", "dark")}
    assert len(set(pictures.values())) == len(pictures)
    assert all(each.startswith(hook.blank()[:8]) for each in pictures.values())

    drawn, built = load(file), talker()
    built.middleware = sym.Middleware.ros2
    assert differences(drawn, built, frozenset({"graphics"})) == []
    assert validate(drawn) == []
    command = [sys.executable, "-P", "-m", "dineros.cli.main", "check", file.name]
    said = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False).stdout
    assert f"$ dineros check greeting.sym.xmi\n{said}```" in page


@pytest.mark.long
def test_the_case_study_drawn_from_nothing(tmp_path: Path, edit: Edit, visit: Callable[..., Visit]) -> None:
    file = tmp_path / "sorting.sym.xmi"
    _, handle = edit(file)
    hand = Hand(visit().page, handle.url)
    wanted = load(ROOT / "case_study/sorting.sym.xmi")
    assert isinstance(wanted, sym.SystemModel)
    Draughtsman(hand).draw(wanted)
    expect(hand.page.locator("#count")).to_have_text("No problems")
    hand.button("Save")
    assert differences(load(file), wanted, frozenset({"graphics"})) == []
