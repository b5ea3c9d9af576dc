"""A few inputs of every kind, always the same; `python -m tests.fuzz` tries thousands."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.fuzz.targets import KINDS
from tests.runtime.bridges.broker import MOSQUITTO
from tests.support.system_packages import require

ROOT = Path(__file__).resolve().parents[2]
INPUTS = 60
PATIENCE = 600.0


@pytest.mark.parametrize("name", KINDS)
def test_a_kind(name: str) -> None:
    """In a process of its own: budgets of memory are of the whole process."""
    if name == "MQTT" and MOSQUITTO is None:
        require("mosquitto")
    inputs = max(2, INPUTS * min(KINDS[name].share, 100) // 100)
    options = ["--inputs", str(inputs), "--seed", "0", "--kind", name, "--jobs", "1"]
    run = subprocess.run(
        [sys.executable, "-m", "tests.fuzz", *options],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert run.returncode == 0, run.stdout + run.stderr
