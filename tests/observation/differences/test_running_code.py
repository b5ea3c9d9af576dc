"""Programs that run are seen as their code is read: names, types, quality of service, services."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from dineros.cli.main import main
from dineros.metamodel.errors import DinerosError
from dineros.observation.graph.watching import watch
from dineros.observation.importing.coded import coded
from dineros.observation.systems import Endpoint, ObservedNode, TopicEndpoint
from dineros.runtime.ros.process.domains import claimed_domain
from dineros.runtime.ros.process.environment import ros_environment
from dineros.runtime.ros.process.memory import remove_abandoned
from dineros.sources.reading import read_source
from tests.support.systems.foreign import FOREIGN, running

pytest.importorskip("rclpy")

PATIENCE = 60.0
"""Seconds, for machines that are slow."""

START = """
import sys, time, rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import (
    DurabilityPolicy, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
)
from geometry_msgs.msg import PoseStamped, Twist
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Empty, String
from std_srvs.srv import SetBool, Trigger
from common import LATCHED, Base as Common
"""
COMMON = """
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
class Base(Node):
    def __init__(self, name, **more):
        super().__init__(name, **more)
        self.state = self.create_publisher(String, "~/state", LATCHED)
"""
PROGRAMS = {
    "lidar": """
class Lidar(Node):
    def __init__(self):
        super().__init__("lidar", namespace="sensors")
        self.scans = self.create_publisher(LaserScan, "/scan", qos_profile_sensor_data)
        self.create_timer(0.05, lambda: self.scans.publish(LaserScan()))
def main():
    rclpy.init(args=sys.argv); rclpy.spin(Lidar())
""",
    "localisation": """
class Localisation(Common):
    def __init__(self):
        super().__init__("localisation")
        group = MutuallyExclusiveCallbackGroup()
        quality = QoSProfile(depth=5)
        quality.reliability = ReliabilityPolicy.BEST_EFFORT
        self.create_subscription(LaserScan, "scan", self.on_scan, quality, callback_group=group)
        self.pub = self.create_publisher(PoseStamped, "pose", LATCHED)
        self.done = self.create_publisher(Empty, f"{self.get_name()}/updated", 10)
        self.create_timer(0.1, self.on_timer)
    def on_scan(self, message): self.done.publish(Empty())
    def on_timer(self): self.pub.publish(PoseStamped())
def main():
    rclpy.init(args=sys.argv)
    executor = MultiThreadedExecutor(num_threads=2)
    executor.add_node(Localisation())
    executor.spin()
""",
    "base": """
class Wheels:
    def __init__(self, node, side):
        self.speed = node.create_publisher(String, f"wheels/{side}/speed", 5)
class Chassis(Common):
    def __init__(self):
        super().__init__("base", namespace="/robot")
        self.declare_parameter("command", "cmd_vel")
        for name, kind in (("battery", Trigger), ("dock", SetBool)):
            self.create_service(kind, name, self.answer)
        self.wheels = [Wheels(self, side) for side in ("left", "right")]
        self.create_subscription(Twist, self.get_parameter("command").value, self.on_command, 10)
    def answer(self, request, response): return response
    def on_command(self, message): pass
def main():
    rclpy.init(args=sys.argv); rclpy.spin(Chassis())
""",
    "mission": """
class Mission(Node):
    def __init__(self):
        super().__init__("mission")
        self.battery = self.create_client(Trigger, "/robot/battery")
        self.dock = self.create_client(SetBool, "/robot/dock", callback_group=ReentrantCallbackGroup())
        self.create_subscription(PoseStamped, "pose", lambda message: None, LATCHED)
        self.command = self.create_publisher(Twist, "/robot/cmd_vel", 10)
        self.status = self.create_publisher(String, "mission/status", 10)
        self.create_timer(0.5, self.tick)
    def tick(self):
        self.status.publish(String())
def main():
    rclpy.init(args=sys.argv)
    executor = MultiThreadedExecutor(num_threads=4)
    executor.add_node(Mission())
    executor.spin()
""",
    "log": """
def main():
    rclpy.init(args=sys.argv)
    node = rclpy.create_node("log")
    best = qos_profile_sensor_data if "--fixed" in sys.argv else 10
    node.create_subscription(LaserScan, "scan", print, best)
    node.create_subscription(String, "mission/status", print, 10)
    rclpy.spin(node)
""",
}


@pytest.fixture
def environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[dict[str, str]]:
    """The environment of a domain of the test's own, which is this process's, too."""
    with claimed_domain() as domain:
        made = ros_environment(tmp_path / "ros", domain)
        for name, value in made.items():
            monkeypatch.setenv(name, value)
        yield made
    remove_abandoned()


def plain(node: ObservedNode) -> ObservedNode:
    """Return a node without what only code or only a graph says: lines, depths, simulated time."""

    def ends(found: tuple[Endpoint, ...]) -> tuple[Endpoint, ...]:
        return tuple(sorted({Endpoint(each.name, each.type) for each in found}, key=str))

    def topics(found: tuple[TopicEndpoint, ...]) -> tuple[TopicEndpoint, ...]:
        kept = {TopicEndpoint(each.topic, each.type, each.quality) for each in found}
        return tuple(sorted(kept, key=str))

    return replace(
        node,
        publishers=topics(node.publishers),
        subscribers=topics(node.subscribers),
        servers=ends(node.servers),
        clients=ends(node.clients),
        action_servers=ends(node.action_servers),
        action_clients=ends(node.action_clients),
        use_sim_time=None,
        lifecycle=None,
    )


def agree(folder: Path) -> None:
    """Watch what runs until it is what the code of a folder says, for a while at most."""
    read = [plain(node) for node in coded([(".", read_source(folder))], "code").apart.nodes]
    end = time.monotonic() + PATIENCE
    seen: list[ObservedNode] = []
    while seen != read and time.monotonic() < end:
        try:
            seen = [plain(node) for node in watch(0.5).nodes]
        except DinerosError:
            continue
    for one, other in zip(seen, read, strict=True):
        assert one == other


@pytest.mark.long
def test_the_robot_of_the_examples(environment: dict[str, str], tmp_path: Path) -> None:
    with running(environment):
        agree(FOREIGN)
        model = tmp_path / "robot.sym.xmi"
        command = ["import", "--source", str(FOREIGN), "--graph", "-o", str(model)]
        text = CliRunner().invoke(main, command).output
    rules = {line.rpartition("[")[2].rstrip("]\n") for line in text.splitlines() if line.startswith("error")}
    assert rules == {"quality-not-matched"}, text  # the faults of the robot itself, and no difference


@pytest.mark.long
def test_a_fleet_of_programs(environment: dict[str, str], tmp_path: Path) -> None:
    folder = tmp_path / "programs"
    folder.mkdir()
    (folder / "common.py").write_text(COMMON)
    for name, text in PROGRAMS.items():
        (folder / f"{name}.py").write_text(f"{START}{text}\nif __name__ == '__main__':\n    main()\n")
    with ExitStack() as stack:
        for name in PROGRAMS:
            stack.enter_context(running(environment, program=folder / f"{name}.py"))
        agree(folder)
