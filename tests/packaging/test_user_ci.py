"""What is offered for the CI of those who have models: a workflow and hooks, run here as shell.

What is run is taken from their files, with the environment and the arguments that it gets there.
"""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml  # type: ignore[import-untyped]

from dineros.generators import Options, generate
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.files import save

ROOT = Path(__file__).resolve().parents[2]
HOOKS = {each["id"]: each for each in yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())}
WORKFLOW = yaml.safe_load((ROOT / ".github/workflows/check-models.yml").read_text())
STEPS: dict[str, dict[str, Any]] = {
    step["name"]: step for step in WORKFLOW["jobs"]["models"]["steps"] if "run" in step
}
MODEL = "models/lamp, ours.sym.xmi"
"""A name that a careless script takes apart."""


def lamp(*, capacity: int = 1, forgotten: bool = False) -> sym.SystemModel:
    """Return a lamp that blinks forever; `forgotten`: it has a part that never happens."""
    on, off = sym.Place(id="On", tokens=1, capacity=capacity), sym.Place(id="Off")
    dim, light = sym.Transition(id="Dim"), sym.Transition(id="Light")
    lamp = sym.NodeNet(id="lamp", objects=[on, off, dim, light])
    flow(on, dim, off, light, on)
    if forgotten:
        never, flash = sym.Place(id="Never", page=lamp), sym.Transition(id="Flash", page=lamp)
        flow(never, flash, off)
    return sym.SystemModel(id="room", pages=[lamp])


@pytest.fixture
def desk(tmp_path: Path) -> Path:
    """A repository with a model and its workspace."""
    (tmp_path / "models").mkdir()
    model = lamp()
    save(model, tmp_path / MODEL)
    generate(model, tmp_path / "ws", Options(source=MODEL))
    return tmp_path


def run(script: list[str], folder: Path, **variables: str) -> int:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PATH": path, "DINEROS_QUIET_COMPILATION": "1", **variables}
    done = subprocess.run(script, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert "Traceback" not in done.stderr, done.stderr
    return done.returncode


def step(name: str, folder: Path) -> int:
    """Run a step of the workflow as its runner does (GitHub: "shell: bash")."""
    inputs = {"MODEL": MODEL, "WORKSPACE": "ws", "RECORDING": "bag", "CHECK": "--timeout 300 --no-cache"}
    script = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", STEPS[name]["run"]]
    return run(script, folder, **inputs)


def hook(id: str, folder: Path, *arguments: str) -> int:
    """Run a hook as pre-commit does: its entry's words, then arguments or the names of files."""
    return run([*shlex.split(HOOKS[id]["entry"]), *arguments], folder)


@pytest.mark.long
def test_all_is_well(desk: Path) -> None:
    assert [step(name, desk) for name in ("Validate", "Check", "Generated code")] == [0, 0, 0]
    assert "<testsuite" in (desk / "findings.xml").read_text()
    assert hook("dineros-validate", desk, MODEL, MODEL) == 0
    assert hook("dineros-check", desk, MODEL) == 0
    assert hook("dineros-generate", desk, MODEL, "-o", "ws") == 0


@pytest.mark.long
def test_a_changed_model_leaves_its_workspace_stale_and_has_a_dead_part(desk: Path) -> None:
    save(lamp(forgotten=True), desk / MODEL)
    assert [step(name, desk) for name in ("Validate", "Check", "Generated code")] == [0, 1, 1]
    assert "Flash" in (desk / "findings.xml").read_text()
    assert hook("dineros-check", desk, MODEL) == 1
    assert hook("dineros-generate", desk, MODEL, "-o", "ws") == 1


def test_a_model_that_keeps_no_constraint_is_found_among_others(desk: Path) -> None:
    save(lamp(capacity=0), desk / "models/broken.sym.xmi")
    assert hook("dineros-validate", desk, "models/broken.sym.xmi", MODEL) == 1
    (desk / MODEL).write_text("<no model")
    assert step("Validate", desk) == 2


def test_a_recording_is_compared_where_there_is_one() -> None:
    assert STEPS["Recording"]["if"] == "inputs.recording != ''"
    assert shlex.split(STEPS["Recording"]["run"]) == ["dineros", "diff", "$MODEL", "--bag", "$RECORDING"]
    assert HOOKS["dineros-diff"]["entry"] == "dineros diff"


def test_no_input_is_put_into_a_script() -> None:
    assert not [step for step in STEPS.values() if "${{" in step["run"]]
    given = set(WORKFLOW["jobs"]["models"]["env"])
    assert {name.upper() for name in WORKFLOW[True]["workflow_call"]["inputs"]} == given  # YAML's `on`


@pytest.mark.long
def test_source_code_is_checked_without_a_model(tmp_path: Path) -> None:
    code = (
        "import rclpy, time\nfrom rclpy.node import Node\nclass Talker(Node):\n"
        "    def __init__(self):\n        super().__init__('talker')\n"
        "        self.create_timer(1.0, self.tick)\n"
        "    def tick(self):\n        time.sleep({})\nrclpy.init()\nrclpy.spin(Talker())\n"
    )
    (tmp_path / "src").mkdir()
    for seconds, status in ((0.1, 0), (3.0, 1)):
        (tmp_path / "src" / "talker.py").write_text(code.format(seconds))
        assert hook("dineros-source", tmp_path, "src") == status
