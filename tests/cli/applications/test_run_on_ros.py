"""``dineros run MODEL``: a ROS 2 process per node, without a workspace."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from dineros.metamodel.files import save
from tests.support.programs.on_ros import on_ros
from tests.support.systems.talker import talker

HANDLERS = """
def configure(net):
    if net.id == "talker":
        net.handler("Say")(lambda firing: print("said", flush=True))
"""


def run(folder: Path, handlers: str, options: list[str]) -> subprocess.CompletedProcess[str]:
    """Run the model with these handlers in a folder."""
    save(talker(), folder / "greeting.sym.xmi")
    (folder / "handlers.py").write_text(handlers, encoding="utf-8")
    command = [sys.executable, "-m", "dineros.cli.main", "run", "greeting.sym.xmi", *options]
    with on_ros():
        return subprocess.run(
            [*command, "--reach", "memory", "--timeout", "120"],
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
        )


@pytest.mark.long
def test_a_model_runs_as_one_process_per_node(tmp_path: Path) -> None:
    options = ["--until", "Noted >= 3", "--trace", "traces", "--monitor"]
    options += ["--stale-after", "Button=0.1:true", "--middleware", "ros2"]  # nobody else presses it
    done = run(tmp_path, HANDLERS, options)
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
    assert done.stdout.startswith("the condition holds; marked: Noted 3\nconformance: conforms, ")
    stale, *said = (tmp_path / "traces/talker.log").read_text().splitlines()
    assert stale.endswith("the signal Button is stale: not set for 0.1 s; it becomes true")
    assert said == ["said"] * 3


LISTENER = """
import json, signal
from pathlib import Path
import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
rclpy.init()
signal.signal(signal.SIGINT, signal.SIG_IGN)  # the nodes end first
node = rclpy.create_node("stranger")
heard = []
latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
node.create_subscription(String, "/talker/state", heard.append, latched)
while not heard:
    rclpy.spin_once(node, timeout_sec=0.1)
Path("heard.json").write_text(heard[0].data)
"""


@pytest.mark.long
def test_a_node_that_cannot_start_is_told_of_and_announced(tmp_path: Path) -> None:
    """Three tries, its error in each line, the restarts counted; on ROS its state says that it is down."""
    (tmp_path / "listener.py").write_text(LISTENER, encoding="utf-8")
    broken = "def configure(net):\n    if net.id == 'talker':\n        import nowhere\n"
    options = ["--until", "Noted >= 3", "--with", f"python {tmp_path / 'listener.py'}"]
    done = run(tmp_path, broken, [*options, "--trace", "traces"])
    assert done.returncode == 2, done.stderr
    error = f"{tmp_path}/handlers.py:3: ModuleNotFoundError: No module named 'nowhere'"
    other, *lines = done.stderr.splitlines()
    assert other.startswith("greeting.sym.xmi: runs by the rules of ros2, whose queues ROS 2 has")
    assert lines[:3] == [f"talker ended with exit status 2: {error}"] * 3
    log = tmp_path / "traces/talker.log"
    assert lines[3:] == [
        f"talker could not be started in 3 attempts: {error} (its output is in {log})",
        "node talker did not start",
    ]
    assert "a node could not continue; marked: " in done.stdout
    assert "0 firings, 0 drops, 0 errors, 2 restarts" in done.stdout
    state = json.loads((tmp_path / "heard.json").read_text())
    assert (state["node"], state["state"], state["blocked"]) == ("talker", "crashed", None)
    assert state["reason"] == f"exit status 2: {error}"
