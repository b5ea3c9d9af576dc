"""A spin by a function of rclpy takes a node out of its executor: the program is wrong if that still runs."""

from __future__ import annotations

from pathlib import Path
from textwrap import indent

import pytest

from dineros.observation.findings.code import code_findings
from dineros.sources.reading import read_source

HEAD = """
import sys, threading
import rclpy
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import Trigger
class Helper:
    def __init__(self, node): self.node = node
    def ask(self):
        future = self.node.create_client(Trigger, "far").call_async(Trigger.Request())
        rclpy.spin_until_future_complete(self.node, future)
class Robot(Node):
    def __init__(self, executor=None):
        super().__init__("robot")
        self.cli = self.create_client(Trigger, "far")
        self.create_service(Trigger, "near", self.near)
        if executor is not None:
            executor.add_node(self)
            rclpy.spin_until_future_complete(self, self.cli.call_async(Trigger.Request()))
    def near(self, request, response): return response
    def ask(self): rclpy.spin_until_future_complete(self, self.cli.call_async(Trigger.Request()))
class Early(Robot):
    def __init__(self):
        super().__init__()
        threading.Thread(target=self.ask).start()
def main():
    rclpy.init()
    executor = MultiThreadedExecutor(4)
"""
ASK = "node.cli.call_async(Trigger.Request())"
READY = "node = Robot()\nexecutor.add_node(node)\n"
TAKEN = {
    "main": f"{READY}rclpy.spin_until_future_complete(node, {ASK})\nexecutor.spin()",
    "once": f"{READY}rclpy.spin_once(node)\nexecutor.spin()",
    "loop": f"{READY}future = {ASK}\nwhile not future.done(): rclpy.spin_once(node)\nexecutor.spin()",
    "returns": f"{READY}try:\n    rclpy.spin(node)\nexcept SystemExit:\n    pass\nexecutor.spin()",
    "helper": f"{READY}Helper(node).ask()\nexecutor.spin()",
    "method": f"{READY}node.ask()\nexecutor.spin()",
    "init": "node = Robot(executor)\nexecutor.spin()",
    "other executor": f"{READY}rclpy.spin_until_future_complete(node, {ASK}, MultiThreadedExecutor())\n"
    "executor.spin()",
    "thread": f"{READY}threading.Thread(target=node.ask).start()\nexecutor.spin()",
    "helper's thread": f"{READY}threading.Thread(target=Helper(node).ask).start()\nexecutor.spin()",
    "executor in a thread": f"{READY}threading.Thread(target=executor.spin).start()\nnode.ask()",
    "executor in a function of a thread": f"{READY}threading.Thread(target=lambda: executor.spin()).start()\n"
    "node.ask()",
    "two threads": f"{READY}threading.Thread(target=node.ask).start()\n"
    "threading.Thread(target=lambda: executor.spin()).start()",
    "created": "node = rclpy.create_node('robot')\nexecutor.add_node(node)\nHelper(node).ask()\n"
    "node.create_service(Trigger, 'near', lambda q, r: r)\nexecutor.spin()",
}
PERHAPS = {
    "branch": f"{READY}if len(sys.argv) > 1: node.ask()\nexecutor.spin()",
    "a race": "node = Early()\nexecutor.add_node(node)\nexecutor.spin()",
}
HEALTHY = {
    "before": f"node = Robot()\nrclpy.spin_until_future_complete(node, {ASK})\n"
    "executor.add_node(node)\nexecutor.spin()",
    "again": f"{READY}node.ask()\nexecutor.add_node(node)\nexecutor.spin()",
    "again after a helper": f"{READY}Helper(node).ask()\nexecutor.add_node(node)\nexecutor.spin()",
    "same": f"{READY}executor.spin_until_future_complete({ASK})\nexecutor.spin()",
    "given": f"{READY}rclpy.spin_until_future_complete(node, {ASK}, executor)\nexecutor.spin()",
    "given by name": f"{READY}rclpy.spin_once(node, executor=executor)\nexecutor.spin()",
    "removed": f"{READY}executor.remove_node(node)\nnode.ask()\nexecutor.add_node(node)\nexecutor.spin()",
    "another node": f"{READY}other = Robot()\nother.ask()\nexecutor.spin()",
    "one of two": f"{READY}if len(sys.argv) > 1: rclpy.spin(node)\nelse: executor.spin()",
    "afterwards": f"{READY}executor.spin()\nnode.ask()",
    "never": f"{READY}node.ask()",
    "spin": f"{READY}rclpy.spin(node)",
    "spin in a thread": f"{READY}threading.Thread(target=rclpy.spin, args=(node,)).start()\nexecutor.spin()",
    "global": f"node = Robot()\nrclpy.spin_until_future_complete(node, {ASK})\nrclpy.spin(node)",
}


def _found(folder: Path, body: str) -> list[str]:
    text = f"{HEAD}{indent(body, '    ')}\nif __name__ == '__main__':\n    main()\n"
    (folder / "robot.py").write_text(text, encoding="utf-8")
    found = code_findings([("", read_source(folder))])
    return [f"{each.severity} {each.rule}" for each in found if each.rule == "code-spins"]


@pytest.mark.parametrize("name", TAKEN)
def test_a_node_that_is_taken_away_is_an_error(name: str, tmp_path: Path) -> None:
    assert _found(tmp_path, TAKEN[name]) == ["error code-spins"]


@pytest.mark.parametrize("name", PERHAPS)
def test_a_node_that_may_be_taken_away_is_a_warning(name: str, tmp_path: Path) -> None:
    assert _found(tmp_path, PERHAPS[name]) == ["warning code-spins"]


@pytest.mark.parametrize("name", HEALTHY)
def test_a_node_that_is_in_its_executor_when_it_runs_is_healthy(name: str, tmp_path: Path) -> None:
    assert _found(tmp_path, HEALTHY[name]) == []
