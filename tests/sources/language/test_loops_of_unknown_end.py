"""Loops in Python that sleep until something happens that is not known: proofs are under an assumption."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.findings.code import code_findings
from dineros.observation.importing.coded import coded
from dineros.sources.reading import read_source
from tests.sources.support import node_of

ROBOT = """
import time
import rclpy
import arm_driver
from rclpy.node import Node
from std_srvs.srv import Trigger

class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.arm = arm_driver.Arm()
        self.items = []
        self.create_service(Trigger, "move", self.on_move)
    def check(self):
        return self.arm.arrived()
    def moves(self):
        state = self.arm.state()
        return state == "moving"
    def on_move(self, request, response):
        LOOP
        return response

def main():
    rclpy.init()
    rclpy.spin(Robot())
main()
"""
SLEEP = "time.sleep(0.1)"


def lacking(folder: Path, loop: str) -> list[str]:
    (folder / "robot.py").write_text(ROBOT.replace("LOOP", "\n        ".join(loop.split("; "))))
    assert code_findings([(str(folder), read_source(folder))]) == []
    return ends(folder)


def ends(folder: Path) -> list[str]:
    found = coded([(str(folder), read_source(folder))], "robot")
    return [each for each in found.lacks if "end of the loop" in each]


@pytest.mark.parametrize(
    "loop",
    [
        f"while not self.check(): {SLEEP}",
        f"while not self.arm.arrived(): {SLEEP}",
        f"while rclpy.ok() and self.moves(): {SLEEP}",
        f"while True:;     if self.arm.arrived(): break;     {SLEEP}",
        f"done = False; while not done:;     {SLEEP};     done = self.arm.arrived()",
        f"done = False; while not done:;     {SLEEP};     done = not self.arm.moves()",
    ],
)
def test_loops_of_unknown_end_are_told(tmp_path: Path, loop: str) -> None:
    (line,) = lacking(tmp_path, loop)
    assert "waits for the end of the loop while " in line
    assert line.endswith("(what ends it is not known); in the model it continues at once")


@pytest.mark.parametrize(
    "loop",
    [
        f"end = time.time() + 2; while time.time() < end: {SLEEP}",
        f"i = 0; while not self.arm.arrived() and i < 9:;     i += 1;     {SLEEP}",
        f"i = 0; while not self.arm.arrived() and i < 9:;     i = i + 1;     {SLEEP}",
        f"start = time.time(); while not self.arm.arrived():;"
        f"     if time.time() - start > 1: break;     {SLEEP}",
        "x = time.time(); while not self.arm.arrived():;"
        f"     d = time.time() - x;     if d > 1: break;     {SLEEP}",
        f"work = self.arm.jobs(); while work:;     work.pop();     {SLEEP}",
        f"left = self.arm.jobs(); while left:;     left = left[1:];     {SLEEP}",
        "while not self.arm.arrived(): self.arm.step()",
        "for each in self.arm.jobs(): each.run()",
        f"while self.arm.more():;     for each in range(3): {SLEEP}",
    ],
)
def test_loops_with_progress_are_quiet(tmp_path: Path, loop: str) -> None:
    assert lacking(tmp_path, loop) == []


def test_main_may_wait_for_anything(tmp_path: Path) -> None:
    text = ROBOT.replace("LOOP", "pass").replace(
        "    rclpy.spin(Robot())",
        f"    robot = Robot()\n    while not robot.check(): {SLEEP}\n    rclpy.spin(robot)",
    )
    (tmp_path / "robot.py").write_text(text)
    assert ends(tmp_path) == []


def test_a_loop_that_sets_what_its_test_asks_for(tmp_path: Path) -> None:
    """It was reported as a loop without end: the variable was None before."""
    body = """
    def __init__(self):
        super().__init__("robot")
        self.create_timer(1.0, self.tick)
    def tick(self):
        line = None
        while line is None:
            line = self.get_clock().now()
    """
    (tick,) = [each for each in node_of(tmp_path, body)["callbacks"] if each["name"] == "tick"]
    assert [(each["do"], each.get("how", "")) for each in tick["effects"]] == [("loop", "")]
