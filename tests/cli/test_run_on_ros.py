"""``dineros run MODEL``: a ROS 2 process per node, without a workspace."""

from __future__ import annotations

import fcntl
import os
import subprocess
import sys
from pathlib import Path

import pytest

from dineros.generators.building import missing_tools
from dineros.metamodel.files import save
from tests.support.talker import talker

CACHE = Path(__file__).resolve().parents[2] / "build/tests/cache"
HANDLERS = """
def configure(net):
    if net.id == "talker":
        net.handler("Say")(lambda firing: print("said", flush=True))
"""


def test_a_model_runs_as_one_process_per_node(tmp_path: Path) -> None:
    if missing_tools():
        if os.environ.get("CI"):
            pytest.fail(f"CI is set: {missing_tools()} must be there")
        pytest.skip(f"without {', '.join(missing_tools())}")
    save(talker(), tmp_path / "greeting.sym.xmi")
    (tmp_path / "handlers.py").write_text(HANDLERS, encoding="utf-8")
    command = [sys.executable, "-m", "dineros.cli.main", "run", "greeting.sym.xmi", "--until", "Noted >= 3"]
    options = ["--trace", "traces", "--domain", "63", "--reach", "memory", "--timeout", "120", "--monitor"]
    options += ["--stale-after", "Button=0.1:true"]  # nobody else presses it
    CACHE.mkdir(parents=True, exist_ok=True)
    with (CACHE / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        done = subprocess.run(
            [*command, *options],
            cwd=tmp_path,
            env={**os.environ, "XDG_CACHE_HOME": str(CACHE)},
            capture_output=True,
            text=True,
            check=False,
        )
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
    assert done.stdout.startswith("the condition holds; marked: Noted 3\nconformance: conforms, ")
    stale, *said = (tmp_path / "traces/talker.log").read_text().splitlines()
    assert stale.endswith("the signal Button is stale: not heard for 0.1 s; it becomes true")
    assert said == ["said"] * 3
