"""Tests skip what needs a missing system package by the package's name, unless CI is set."""

import re
from pathlib import Path

import pytest

from tests.support.programs.system_packages import missing, needs, require

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def bare(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CI", raising=False)


@pytest.mark.usefixtures("bare")
def test_missing_packages_are_named() -> None:
    assert missing("graphviz", "spin") == ["graphviz", "spin"]
    mark = needs("graphviz", "spin").mark
    assert mark.args == (True,)
    assert mark.kwargs["reason"] == "without graphviz, spin"
    with pytest.raises(pytest.skip.Exception, match="without chromium"):
        require("chromium")


@pytest.mark.usefixtures("bare")
def test_in_ci_nothing_is_skipped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CI", "1")
    assert needs("graphviz").mark.args == (False,)
    with pytest.raises(pytest.fail.Exception, match="CI is set: chromium must be there"):
        require("chromium")


def test_what_is_there_is_not_missing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "dot").touch(mode=0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert missing("graphviz") == []


def test_no_test_asks_in_another_way() -> None:
    """A skip that reads otherwise would not say which package is missing, or would hide it in CI."""
    for file in (ROOT / "tests").rglob("test_*.py"):
        assert not re.search(r"skipif\(\s*(not )?shutil\.which", file.read_text(encoding="utf-8")), file
