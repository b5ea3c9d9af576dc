"""A running graph of real processes: what is seen of it, imported and compared, and what may go wrong."""

from __future__ import annotations

import json
import os
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from dineros.cli.main import main
from dineros.metamodel.errors import DinerosError
from dineros.observation.graph.watching import watch
from dineros.observation.systems import ObservedNode, ObservedSystem
from dineros.runtime.ros.process.domains import claimed_domain
from dineros.runtime.ros.process.environment import ros_environment
from dineros.runtime.ros.process.memory import remove_abandoned
from tests.support.systems.foreign import robot, running

HOME = Path(__file__).resolve().parent
PATIENCE = 60.0
"""Seconds, for machines that are slow."""

pytest.importorskip("rclpy")


@pytest.fixture
def environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[dict[str, str]]:
    """The environment of a domain of the test's own, which is this process's, too."""
    with claimed_domain() as domain:
        made = ros_environment(tmp_path / "ros", domain)
        for name, value in made.items():
            monkeypatch.setenv(name, value)
        monkeypatch.chdir(tmp_path)
        yield made
    remove_abandoned()


def run(*arguments: str) -> Result:
    return CliRunner().invoke(main, arguments)


def seen(nodes: int) -> ObservedSystem:
    """Watch until so many nodes are there."""
    end = time.monotonic() + PATIENCE
    while True:
        try:
            system = watch(0.5)
        except DinerosError:
            system = ObservedSystem("nothing")
        if len(system.nodes) >= nodes or time.monotonic() > end:
            return system


@pytest.mark.long
def test_twelve_plain_nodes(environment: dict[str, str], tmp_path: Path) -> None:
    """The robot is seen as its programs say; import names the mismatches, and diff finds nothing after."""
    with running(environment):
        end = time.monotonic() + PATIENCE
        plain, told = list[ObservedNode](), dict[str, bool | None]()
        while (plain != list(robot().nodes) or told["/base"] is None) and time.monotonic() < end:
            system = seen(12)
            plain = [replace(node, use_sim_time=None) for node in system.nodes]
            told = {node.name: node.use_sim_time for node in system.nodes}
        assert plain == list(robot().nodes)
        assert told["/base"] is False

        imported = run("import", "--graph", "--watch", "5", "-o", "robot.sym.xmi")
        assert imported.exit_code == 1, imported.output
        assert "/detector receives nothing on /image from /sensors/camera" in imported.stdout
        assert "/monitor receives nothing on /battery_level from /battery" in imported.stdout
        assert "12 nodes, 11 topics, 3 services, 2 found" in imported.stdout
        assert (tmp_path / "robot.given.toml").exists()

        same = run("diff", "robot.sym.xmi", "--graph", "--watch", "5")
        assert (same.exit_code, same.stdout) == (0, "robot.sym.xmi: 0 found, 12 proved, 0 unknown\n")
        other = run(
            "diff", "robot.sym.xmi", "--graph", "--watch", "5", "--json", "--set", "topic.map.topic=/mab"
        )
        assert other.exit_code == 1
        rules = [finding["rule"] for finding in json.loads(other.stdout)["findings"]]
        assert sorted(rules) == ["port-extra"] * 2 + ["port-missing"] * 2

        arm = run("import", "--graph", "--watch", "5", "--namespace", "/sensors", "-o", "sensors.sym.xmi")
        assert "3 nodes, 3 topics, 1 found" in arm.stdout


@pytest.mark.long
def test_time_state_and_a_node_that_goes(environment: dict[str, str]) -> None:
    program = HOME / "plain.py"
    with (
        running(environment, "managed", program=program),
        running(environment, "simulated", program=program) as simulated,
    ):
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            nodes = {node.name: node for node in seen(2).nodes}
            if nodes["/managed"].lifecycle == "unconfigured" and nodes["/simulated"].use_sim_time is not None:
                break
        assert nodes["/managed"].lifecycle == "unconfigured"
        assert nodes["/managed"].servers == ()
        assert nodes["/simulated"].use_sim_time is True

        # Later than it is seen, which takes 2.5 s at times.
        # One that is killed is there until its lease is over.
        ending = threading.Timer(6.0, simulated.terminate)
        ending.start()
        system = watch(14.0)  # to end takes its time, too, on a busy machine
        ending.join()
        assert system.departed == ("/simulated",)
        (gone,) = (node for node in system.nodes if node.name == "/simulated")
        assert [port.topic for port in gone.publishers] == ["/tick"]


def test_an_empty_graph_is_one_line_and_no_file(environment: dict[str, str], tmp_path: Path) -> None:
    result = run("import", "--graph", "--watch", "0", "-o", "empty.sym.xmi")
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert f"there is no node in ROS domain {os.environ['ROS_DOMAIN_ID']}" in result.stderr
    assert not list(tmp_path.glob("empty*"))


def test_a_crowd_is_seen_whole(environment: dict[str, str]) -> None:
    with running(environment, "20", "50", program=HOME / "crowd.py"):
        system = seen(20)
        assert len(system.nodes) == 20
        assert sum(len(node.publishers) for node in system.nodes) == 50
        assert sum(len(node.subscribers) for node in system.nodes) == 50
