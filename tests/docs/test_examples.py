"""Every example in the README and the guide runs, and prints what the page shows."""

from __future__ import annotations

import shutil
from contextlib import nullcontext
from pathlib import Path

import pytest

from tests.support.markdown import blocks, commands, run_page
from tests.support.programs.on_ros import on_ros
from tests.support.programs.system_packages import require_for

ROOT = Path(__file__).resolve().parents[2]
PAGES = [
    ROOT / "README.md",
    *sorted((ROOT / "docs").glob("*.md")),
    *sorted((ROOT / "examples").glob("*/README.md")),
]


ON_ROS = ("quick_start.md",)
"""Pages whose nodes are processes on ROS 2."""


COLD = (PAGES[0], *(ROOT / "docs" / name for name in ON_ROS))
"""Pages whose commands start as a reader's do; those of the others are forks, which saves their imports."""


@pytest.mark.long
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_examples_of_a_page_run(page: Path, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    warm = None if page in COLD else request.getfixturevalue("warm")
    with on_ros() if page.name in ON_ROS else nullcontext():
        check_page(page, tmp_path, warm)


def check_page(page: Path, tmp_path: Path, warm: Path | None) -> None:
    """Run a page in a folder where there are the models and examples of the repository."""
    require_for(page.read_text(encoding="utf-8"))
    (tmp_path / "case_study").mkdir()
    for suffix in ("*.xmi", "*.pnml"):
        for model in (ROOT / "case_study").glob(suffix):
            shutil.copy(model, tmp_path / "case_study")
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    for block, command, shown, printed in run_page(page.read_text(encoding="utf-8"), tmp_path, warm):
        assert printed == shown, f"{page.name}:{block.line}: {command}"


def test_blocks_and_commands_are_found() -> None:
    page = 'Text\n\n```python title="a.py"\nx = 1\n```\n\n```console\n$ one\nout\n$ two\n```\n'
    python, console = blocks(page)
    assert (python.language, python.title, python.text, python.line) == ("python", "a.py", "x = 1\n", 4)
    assert commands(console.text) == [("one", "out\n"), ("two", "")]


def test_a_page_that_lies_is_noticed(tmp_path: Path) -> None:
    page = "```python\nprint(1)\n```\n```text\n2\n```\n\n```console\n$ echo yes\nno\n```\n"
    assert [(shown, printed) for _, _, shown, printed in run_page(page, tmp_path)] == [
        ("2\n", "1\n"),
        ("no\n", "yes\n"),
    ]
