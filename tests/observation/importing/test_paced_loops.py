"""Threads that publish and sleep in a loop: timers, with the period that the code says."""

from __future__ import annotations

from pathlib import Path
from textwrap import dedent, indent

import pytest

from dineros.observation.importing.coded import Coded, coded
from dineros.sources.reading import read_source

PROGRAM = """
import threading
import time

import rclpy
from rclpy.node import Node
from std_msgs.msg import String

class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.pub = self.create_publisher(String, "out", 1)
        self.create_subscription(String, "in", self.heard, 1)
        self.running = True
        STARTS
    def heard(self, message):
        HEARD
    def send(self):
        self.pub.publish(String())
    def work(self):
        while TEST:
LOOP

if __name__ == "__main__":
    rclpy.init()
    rclpy.spin(Robot())
"""
THREAD = "threading.Thread(target=self.work, daemon=True).start()"


def read(
    folder: Path, loop: str, test: str = "rclpy.ok()", starts: str = THREAD, heard: str = "pass"
) -> Coded:
    text = PROGRAM.replace("TEST", test).replace("STARTS", starts).replace("HEARD", heard)
    (folder / "program.py").write_text(text.replace("LOOP", indent(dedent(loop).strip("\n"), " " * 12)))
    return coded([(".", read_source(folder))], "robot")


@pytest.mark.parametrize(
    ("loop", "period", "times"),
    [
        ("self.send()\ntime.sleep(0.5)", 0.5, ""),
        ("time.sleep(0.25)\nself.send()\ntime.sleep(0.25)", 0.5, ""),
        ("if self.running:\n    self.send()\ntime.sleep(0.5)", 0.5, "?"),
        ("try:\n    self.send()\nfinally:\n    time.sleep(0.5)", 0.5, "?"),
        ("if self.running:\n    time.sleep(2)\n    continue\nself.send()\ntime.sleep(0.5)", 0.5, "?"),
        ("self.send()\nif self.running:\n    time.sleep(2)\nelse:\n    time.sleep(1)", 1.0, ""),
    ],
)
def test_a_loop_has_the_period_of_its_sleeps(tmp_path: Path, loop: str, period: float, times: str) -> None:
    """It was at any time, and an assumption of all proofs that the loop ends."""
    found = read(tmp_path, loop)
    (node,) = found.given.nodes.values()
    assert node.timers == {"work": period}
    assert not node.open_timers
    (step,) = node.callbacks["work"].does or ()
    assert (step.verb, step.name, step.times) == ("publish", "/out", times)
    assert not [line for line in found.taken if "loop" in line]


@pytest.mark.parametrize(
    ("loop", "test", "starts"),
    [
        ("self.send()", "rclpy.ok()", THREAD),
        ("self.send()\nif self.running:\n    time.sleep(0.5)", "rclpy.ok()", THREAD),
        ("self.send()\nif self.running:\n    continue\ntime.sleep(0.5)", "rclpy.ok()", THREAD),
        ("for i in range(3):\n    self.send()\ntime.sleep(0.5)", "rclpy.ok()", THREAD),
        ("try:\n    self.send()\n    time.sleep(0.5)\nexcept ValueError:\n    pass", "rclpy.ok()", THREAD),
        ("self.send()\ntime.sleep(0.5)", "rclpy.ok()", f"for i in range(3): {THREAD}"),
        ("self.send()\ntime.sleep(self.get_parameter('x').value)", "rclpy.ok()", THREAD),
    ],
)
def test_other_loops_are_at_any_time(tmp_path: Path, loop: str, test: str, starts: str) -> None:
    (node,) = read(tmp_path, loop, test, starts).given.nodes.values()
    assert node.open_timers == {"main"} and list(node.timers or ()) == ["main"]


def test_a_loop_that_may_end_may_publish(tmp_path: Path) -> None:
    (node,) = read(tmp_path, "self.send()\ntime.sleep(0.5)", "self.running").given.nodes.values()
    assert node.timers == {"work": 0.5}
    (step,) = node.callbacks["work"].does or ()
    assert step.times == "?"


def test_each_thread_has_its_timer(tmp_path: Path) -> None:
    found = read(tmp_path, "self.send()\ntime.sleep(0.5)", starts=f"{THREAD}\n        {THREAD}")
    (node,) = found.given.nodes.values()
    assert node.timers == {"work": 0.5, "work_2": 0.5} and not node.open_timers


def test_a_thread_that_a_callback_starts_may_run_several_times(tmp_path: Path) -> None:
    found = read(tmp_path, "self.send()\ntime.sleep(0.5)", starts="pass", heard=THREAD)
    (node,) = found.given.nodes.values()
    assert node.open_timers == {"main"}
