"""The page about the architecture names places that are there, and its picture shows every floor."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import pytest

from tests.packaging.test_imports import FOLDERS, ROOMS

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/architecture.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def hook() -> ModuleType:
    """Import the hook that draws the house."""
    pytest.importorskip("mkdocs", reason="the extra [docs] is not installed")
    specification = importlib.util.spec_from_file_location("house", ROOT / "docs/hooks/house.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def test_all_places_are_there() -> None:
    named = re.findall(r"`([\w/]+(?:/|\.\w+))`", PAGE)
    assert len(named) > 20
    assert [name for name in named if not (ROOT / name).exists() and name != "types.d.ts"] == []


def test_what_is_named_beside_a_place_is_in_it() -> None:
    named = re.findall(r"`([\w/]+\.(?:py|js))` \(`(\w+)`\)", PAGE)
    assert len(named) > 7
    for file, name in named:
        made = rf"^ *(class|def|function) {name}\b|^ *{name} = "
        assert re.search(made, (ROOT / file).read_text(encoding="utf-8"), re.MULTILINE), (file, name)


@pytest.mark.long
def test_the_picture_shows_every_floor_once(hook: ModuleType) -> None:
    drawn = hook.to_dot()
    for room in ROOMS:
        (label,) = re.findall(rf'"{room}" \[label=<(.*)>\]', drawn)
        rows = re.findall(r">(\w+)</td></tr>", label)
        folders = [name for name in FOLDERS.get(room, ()) if (ROOT / room / name).is_dir()]
        assert set(folders) <= set(rows)
        assert len(rows) == len(set(rows))


@pytest.mark.long
def test_a_missing_graphviz_leaves_a_note(hook: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    assert "Graphviz" in hook.picture()
