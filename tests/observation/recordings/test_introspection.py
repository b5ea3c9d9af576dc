"""Service introspection for real: three plain nodes are recorded, imported, narrowed and explained."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from itertools import pairwise
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from dineros.cli.main import main
from dineros.observation.importing.given_reading import read_given
from dineros.observation.recordings import Observed, Recording, RecordingError
from dineros.runtime.ros.process.domains import claimed_domain
from dineros.runtime.ros.process.environment import ros_environment
from dineros.runtime.ros.process.memory import remove_abandoned
from tests.support.systems.foreign import running

HERE = Path(__file__).resolve().parent
TOPICS = {
    **dict.fromkeys(("/image", "/label", "/look"), "std_msgs/msg/String"),
    "/classify/_service_event": "std_srvs/srv/Trigger_Event",
}
GIVEN = """
[topic."/image"]
publishers = ["/camera"]
subscribers = ["/detector"]
[topic."/label"]
publishers = ["/detector"]
[topic."/look"]
publishers = ["/classifier"]
[service."/classify"]
servers = ["/classifier"]
clients = ["/detector"]
[node."/detector"]
threads = 2
groups.images = "exclusive"
callback."/image".group = "images"
"""

pytest.importorskip("rclpy")


def recorded(path: Path, seconds: float) -> Path:
    """Record the nodes from their first message on."""
    with claimed_domain() as domain:
        environment = ros_environment(path / "ros", domain)
        topics = [f"{name}={kind}" for name, kind in TOPICS.items()]
        recorder = subprocess.Popen(
            [sys.executable, "-m", "tests.support.programs.recorder", str(path / "bag"), *topics],
            env={**environment, "PYTHONPATH": os.fspath(HERE.parents[2])},
            stdout=subprocess.PIPE,
            text=True,
        )
        try:
            assert recorder.stdout is not None and recorder.stdout.readline() == "records\n"
            with running(environment, program=HERE / "introspected.py"):
                time.sleep(seconds)
        finally:
            recorder.send_signal(signal.SIGTERM)
            recorder.wait(30)
    remove_abandoned()
    return path / "bag"


def recorded_well(path: Path) -> Path:
    """Record the nodes until each image leads to a label before the next one, as on a machine with time.

    Where a node had to wait for its turn, images have piled up, and which label is whose cannot be seen.
    """
    for seconds in (4, 5, 6, 7, 8, 9, 10, 60):
        bag = recorded(path / str(seconds), seconds)
        with suppress(RecordingError), Recording(bag) as recording:  # one without a message is refused
            told = [each.topic for each in recording.messages(("/image", "/label"))]
            if recording.count > 100 and all(one != other for one, other in pairwise(told)):
                return bag
    raise AssertionError("no node has said enough, or in time")


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(each) for each in arguments])


@pytest.mark.long
def test_three_nodes_that_tell_of_their_calls(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    bag = recorded_well(tmp_path)
    with Recording(bag) as recording:
        observed = Observed(recording)
        assert len(observed.recorded) == 7
        count, least, most = observed.calls["/classify"].answers["response received"]
        assert count >= 10 and 0 < least <= most
    Path("seen.given.toml").write_text(GIVEN)
    assert run("import", "--bag", bag, "-o", "seen.sym.xmi").exit_code == 0
    # Events are told after what they tell of; a thread may have been interrupted in between.
    loosely = ("--bag", bag, "--tolerance", "0.02")
    narrowed = run("narrow", "seen.sym.xmi", *loosely, "--threshold", "0.5", "-o", "narrowed.sym.xmi")
    assert narrowed.exit_code == 0, narrowed.output
    said = read_given(Path("narrowed.given.toml")).nodes
    assert [str(step) for step in said["/detector"].callbacks["/image"].does or ()] == [
        "call /classify",
        "publish /label",
    ]
    assert [str(step) for step in said["/classifier"].callbacks["/classify"].does or ()] == ["publish /look"]
    assert run("conform", "narrowed.sym.xmi", *loosely).exit_code == 0
    assert run("diff", "narrowed.sym.xmi", "--bag", bag).exit_code == 0
    other = run("diff", "narrowed.sym.xmi", "--bag", bag, "--set", "service.classify.service=/classifi")
    assert other.exit_code == 1
    assert "the model has no service /classify (did you mean '/classifi'?) [service-extra]" in other.stdout
