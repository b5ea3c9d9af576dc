"""The guide's pages about rules: every rule stands on one, and the examples are those of the repository."""

from __future__ import annotations

import ast
import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

from dineros.transformations.language import creation, functions, patterns
from dineros.transformations.pictures.describing import documentation_of
from dineros.transformations.rules.catalogue import FAMILIES, name_of
from tests.support.markdown import blocks

DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.fixture(scope="module")
def hook() -> ModuleType:
    """Import the hook that makes the pages."""
    pytest.importorskip("mkdocs", reason="the extra [docs] is not installed")
    specification = importlib.util.spec_from_file_location("rule_pages", DOCS / "hooks/rule_pages.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


@pytest.mark.long
def test_every_rule_has_a_section_with_picture_and_text(hook: ModuleType) -> None:
    pages = hook.pages()
    for family in FAMILIES:
        page = pages[f"rules/{family.name}.md"]
        assert page.count("\n## ") == len(family.rules)
        for rule in family.rules:
            name = name_of(rule)
            assert f"\n## {name}\n\n{documentation_of(rule)}\n\n" in page
            assert f"](pictures/{name}.svg)" in page
            assert pages[f"rules/pictures/{name}.svg"].rstrip().endswith("</svg>")
        assert page.count("\nLHS\n") == page.count("\nRHS: the same, and\n") == len(family.rules)


def test_a_missing_graphviz_leaves_a_note(hook: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    assert "Graphviz" in hook.picture(FAMILIES[0].rules[0])


def test_every_rule_page_is_in_the_navigation() -> None:
    navigation = (DOCS.parent / "mkdocs.yml").read_text(encoding="utf-8")
    for family in FAMILIES:
        assert f": rules/{family.name}.md\n" in navigation


def test_the_guide_shows_the_watchdog_of_the_examples() -> None:
    page = (DOCS / "transformations.md").read_text(encoding="utf-8")
    (shown,) = [block.text for block in blocks(page) if block.title == "watchdog_rules.py"]
    assert shown == (DOCS.parent / "examples/watchdog_rules.py").read_text(encoding="utf-8")


def test_the_reference_names_every_word_of_the_language() -> None:
    page = (DOCS / "rule_language.md").read_text(encoding="utf-8")
    words = {
        name
        for name, value in vars(functions).items()
        if name.islower()
        and getattr(value, "__module__", "") == functions.__name__
        and not name.startswith("_")
    }
    words |= {"Node", "Index", "Made", "Absent"} & set(vars(patterns))
    words |= {"New", "Copy", "ForAll", "Fragment", "image"} & set(vars(creation))
    assert len(words) == 18
    assert [word for word in sorted(words) if f"`{word}" not in page and f"`{word}(" not in page] == []


def test_the_reference_writes_expressions_that_can_be_read() -> None:
    page = (DOCS / "rule_language.md").read_text(encoding="utf-8")
    for line in page.splitlines():
        if line.startswith("| `"):
            code = line.split("`")[1].replace("=...", "=x").replace("(...)", "()").replace("[...]", "[x]")
            ast.parse(code)
