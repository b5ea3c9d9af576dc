"""Shell completion."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.shell_completion import ShellComplete

from dineros.cli.main import main
from tests.cli.conftest import Run


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_asks_dineros(run: Run, shell: str) -> None:
    result = run("completion", shell)
    assert (result.exit_code, result.stderr) == (0, "")
    assert f"_DINEROS_COMPLETE={shell}_complete" in result.stdout


def completed(words: list[str], incomplete: str) -> list[tuple[str, str]]:
    """Return type and value of what is offered."""
    items = ShellComplete(main, {}, "dineros", "_DINEROS_COMPLETE").get_completions(words, incomplete)
    return [(item.type, item.value) for item in items]


def test_commands_and_options() -> None:
    assert completed([], "va") == [("plain", "validate")]
    assert ("plain", "--set") in completed(["validate"], "--s")
    assert completed(["completion"], "f") == [("plain", "fish")]


def test_model_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("a.xmi", "b.PNML", "c.txt", ".hidden.xmi"):
        Path(name).touch()
    Path("models").mkdir()
    Path("models/d.net").touch()
    assert completed(["validate"], "") == [("plain", "a.xmi"), ("plain", "b.PNML"), ("plain", "models/")]
    assert completed(["validate"], "a") == [("plain", "a.xmi")]
    assert completed(["convert", "a.xmi", "-o"], "b") == [("plain", "b.PNML")]
    assert completed(["validate"], "models/") == [("plain", "models/d.net")]
    assert completed(["validate"], f"{tmp_path}/models/") == [("plain", f"{tmp_path}/models/d.net")]


@pytest.mark.parametrize("incomplete", ["mo", "c", "nothing", "no/such/folder"])
def test_where_no_model_fits_the_shell_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, incomplete: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("models").mkdir()
    Path("c.txt").touch()
    assert completed(["validate"], incomplete) == [("file", incomplete)]


def test_bash_completes(run: Run, tmp_path: Path) -> None:
    program = tmp_path / "dineros"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m dineros.cli.main "$@"\n', encoding="utf-8")
    program.chmod(0o755)
    script = run("completion", "bash").stdout
    asking = 'COMP_WORDS=(dineros val); COMP_CWORD=1; _dineros_completion dineros; echo "${COMPREPLY[@]}"'
    result = subprocess.run(
        ["bash", "--norc", "-c", f"{script}\n{asking}"],
        env={**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert result.stdout == "validate\n"
