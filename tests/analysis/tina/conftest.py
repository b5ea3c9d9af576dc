"""Stand-ins for TINA, called in this process, which is quick enough for many questions."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from subprocess import CompletedProcess

import pytest

from dineros.analysis.tina import trial
from dineros.analysis.tina.programs import Workplace
from tests.analysis.tina.stand_ins import install, main


@pytest.fixture
def in_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the stand-ins run here instead of on their own."""
    install(tmp_path / "bin")
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    monkeypatch.setattr(trial, "_passed", set())

    def run(place: Workplace, name: str, *arguments: str) -> CompletedProcess[str]:
        output = io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.chdir(place.folder):
            main(name, list(arguments))
        return CompletedProcess(name, 0, output.getvalue(), "")

    monkeypatch.setattr(Workplace, "run", run)
