"""Some nodes of a model run; the others are elsewhere."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from dineros.metamodel.files import save
from tests.cli.conftest import Run
from tests.support.programs.commands import is_one_line_of_wrong_use
from tests.support.programs.on_ros import on_ros
from tests.support.systems.talker import talker


@pytest.mark.parametrize("way", ["--local", "--simulate"])
@pytest.mark.parametrize(
    ("options", "places"),
    [
        (["--only", "talker"], {"Words"}),
        (["--only", "/talker"], {"Words"}),
        (["--without", "listener"], {"Words"}),
        (["--without", "talker"], set()),
        (["--only", "talker", "--only", "/listener"], {"Words"}),
    ],
)
def test_only_their_parts_of_the_marking_are_there(
    run: Run, model: Path, way: str, options: list[str], places: set[str]
) -> None:
    result = run("run", model, way, "--timeout", 0.5, "--json", *options)
    assert result.exit_code == 0, result.output
    said = json.loads(result.stdout)
    assert (set(said["marking"]), said["missing"]) == (places, [])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--only", "talkr"], "did you mean 'talker'"),
        (["--without", "nobody"], "there is no node 'nobody'"),
        (["--without", "talker", "--without", "listener"], "no node remains to be run"),
        (["--only", "talker", "--monitor"], "--monitor needs all nodes"),
        (["--only", "listener", "--until", "Words = 0"], "Words"),
    ],
)
def test_wrong_use(run: Run, model: Path, options: list[str], words: str) -> None:
    assert is_one_line_of_wrong_use(run("run", model, "--simulate", *options), words)


LISTENER = """
import rclpy
from std_msgs.msg import String
rclpy.init()
node = rclpy.create_node("listener")
heard = []
node.create_subscription(String, "chatter", heard.append, 10)
while len(heard) < 3:
    rclpy.spin_once(node, timeout_sec=0.2)
open("heard", "w").write(str(len(heard)))
"""


@pytest.mark.long
def test_a_generated_node_runs_beside_one_that_exists(tmp_path: Path) -> None:
    model = talker()
    (channel,) = model.channels
    channel.type = "std_msgs/msg/String"
    save(model, tmp_path / "greeting.sym.xmi")
    (tmp_path / "listener.py").write_text(LISTENER)
    (tmp_path / "handlers.py").write_text("def configure(net):\n    net.signal('Button').set(True)\n")
    command = [sys.executable, "-m", "dineros.cli.main", "run", "greeting.sym.xmi", "--only", "talker"]
    command += ["--with", "python listener.py", "--reach", "memory", "--timeout", "20", "--json"]
    with on_ros():
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "heard").read_text() == "3"
