"""A few inputs of every kind, always the same; `python -m tests.fuzz` tries thousands."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.fuzz.__main__ import watch
from tests.fuzz.targets import KINDS
from tests.runtime.bridges.broker import MOSQUITTO
from tests.support.programs.system_packages import require

ROOT = Path(__file__).resolve().parents[2]
INPUTS = 30
PATIENCE = 600.0


def inputs_of(name: str) -> int:
    """Return how many inputs of a kind are tried."""
    return max(2, INPUTS * min(KINDS[name].share, 100) // 100)


@pytest.mark.long
@pytest.mark.parametrize("name", KINDS)
def test_a_kind(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """In a process of its own: budgets of memory are of the whole process."""
    if name == "MQTT" and MOSQUITTO is None:
        require("mosquitto")
    monkeypatch.chdir(ROOT)
    told: list[str] = []
    row = watch(name, inputs_of(name), 0, told.append)
    assert (row["faults"], row["inputs"], told) == (0, inputs_of(name), [])


@pytest.mark.long
def test_the_command() -> None:
    options = ["--inputs", "2", "--seed", "0", "--kind", "limit", "--jobs", "1"]
    run = subprocess.run(
        [sys.executable, "-m", "tests.fuzz", *options],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert run.returncode == 0, run.stdout + run.stderr
