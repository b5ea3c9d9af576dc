"""Stand-ins for TINA, called in this process, which is quick enough for many questions."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path

import pytest

from dineros.analysis.tina import trial
from dineros.analysis.tina.programs import Printed, Workplace
from tests.analysis.tina.stand_ins import install, main


@pytest.fixture
def in_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the stand-ins run here instead of on their own."""
    install(tmp_path / "bin")
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    monkeypatch.setattr(trial, "_passed", set())

    def run(place: Workplace, name: str, *arguments: str) -> Printed:
        output = io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.chdir(place.folder):
            main(name, list(arguments))
        return Printed(output.getvalue(), "")

    monkeypatch.setattr(Workplace, "run", run)
