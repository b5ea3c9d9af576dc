"""``dineros warm-up``: what is compiled is there for later processes, and is not compiled again."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.analysis import warm_up
from tests.cli.conftest import Run


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(warm_up, "kept_in", lambda: tmp_path)
    return tmp_path


@pytest.mark.long
def test_it_compiles_once(run: Run, kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(warm_up, "PARTS", {"walks": warm_up.PARTS["walks"]})
    first = run("warm-up", "--processes", "1")
    assert (first.exit_code, first.stderr) == (0, "")
    assert first.stdout.startswith("compiled the engines in ")
    assert list(kept.glob("dineros-kernels-*/*/walks.walk-*.nbc"))
    again = run("warm-up")
    assert (again.exit_code, again.stdout) == (0, "the engines are already compiled\n")


def test_a_package_that_was_copied_is_not_warm(
    run: Run, kept: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Numba keeps kernels by the path of their module."""
    monkeypatch.setattr(warm_up, "PARTS", {})
    assert run("warm-up", "--processes", "1").exit_code == 0
    assert warm_up.is_warm()
    monkeypatch.setattr(warm_up, "ROOM", tmp_path / "copy")
    assert not warm_up.is_warm()


def test_a_process_that_fails_is_told_and_tried_again(
    run: Run, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(warm_up, "PARTS", {"no such part": warm_up.PARTS["walks"]})
    result = run("warm-up")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr == "dineros: the engines cannot be compiled: KeyError: 'no such part'\n"
    assert not warm_up.is_warm()


def test_nowhere_to_keep_it_is_told(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(warm_up, "kept_in", lambda: None)
    result = run("warm-up")
    assert result.exit_code == 2
    assert result.stderr.startswith("dineros: compiled engines cannot be kept (")
