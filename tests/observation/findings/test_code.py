"""What code itself shows to be wrong is found at its line, and healthy code is left alone."""

from __future__ import annotations

from pathlib import Path
from textwrap import indent

import pytest

from dineros.observation.findings.code import code_findings
from dineros.sources.reading import read_source

HEAD = """
import rclpy, threading, time
from rclpy.action import ActionClient, ActionServer
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from example_interfaces.action import Fibonacci
from std_srvs.srv import Trigger
class Helper:
    def __init__(self): self.lock = threading.Lock()
    def work(self):
        with self.lock: pass
class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.cli = self.create_client(Trigger, "ask")
        self.nav = ActionClient(self, Fibonacci, "go")
        self.lock, self.again = threading.Lock(), threading.RLock()
        self.helper = Helper()
        self.goal, self.level = None, 0
        self.create_timer(1, self.tick)
        self.create_service(Trigger, "b", self.other)
    def other(self, request, response):
        with self.lock: return response
    def step(self): self.level += 1
    def tick(self):
"""
MAIN = """
def main():
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=THREADS)
    executor.add_node(Robot())
    executor.spin()
if __name__ == "__main__":
    main()
"""
FOUND = {
    "time.sleep(5)": "warning code-sleeps",
    "self.cli.wait_for_service()": "warning code-waits",
    "self.nav.wait_for_server()": "warning code-waits",
    "input('goal? ')": "warning code-waits",
    "rclpy.spin_once(self)": "error code-spins",
    "rclpy.spin_until_future_complete(self, self.cli.call_async(Trigger.Request()))": "error code-spins",
    "while True: pass": "warning code-never-ends",
    "while True:\n    if self.goal == 1: break": "error code-never-ends",
    "while True:\n    for each in range(3):\n        if each: break": "warning code-never-ends",
    "self.nav.send_goal_async(Fibonacci.Goal())": "note code-ignores",
    "self.create_client(Trigger, 'other').call_async(Trigger.Request())": "note code-makes-clients",
    "with self.lock:\n    self.cli.call(Trigger.Request())": "warning code-holds-lock",
    "with self.lock:\n    self.other(1, 2)": "error code-waits-for-itself",
    "with self.lock:\n    if self.level: self.lock.acquire()": "warning code-waits-for-itself",
}
HEALTHY = [
    "time.sleep(0.1)",
    "self.cli.wait_for_service(timeout_sec=1.0)",
    "while True:\n    self.level += 1\n    if self.level > 3: break",
    "while True:\n    if self.full(): break",
    "while True:\n    return",
    "while self.level < 3: self.level += 1",
    "while True:\n    try:\n        next(self.many)\n    except StopIteration:\n        break",
    "self.kept = self.nav.send_goal_async(Fibonacci.Goal())",
    "with self.lock:\n    self.level += 1\nself.cli.call(Trigger.Request())",
    "with self.again:\n    with self.again: self.level += 1",
    "with self.lock:\n    self.helper.work()",
    "with self.lock:\n    self.lock.acquire(timeout=1.0)",
    "with self.lock:\n    self.level += 1\nself.other(1, 2)",
    "threading.Thread(target=lambda: time.sleep(5)).start()",
]


def found(folder: Path, body: str, threads: int = 2) -> list[str]:
    """Return what is found in the callback of a timer."""
    text = HEAD + indent(body, "        ") + MAIN.replace("THREADS", str(threads))
    (folder / "robot.py").write_text(text)
    return [
        f"{each.severity} {each.rule} {each.lines[0]}: {each.message}"
        for each in code_findings([(".", read_source(folder))])
    ]


@pytest.mark.parametrize(("body", "expected"), FOUND.items())
def test_it_is_found_at_its_line(tmp_path: Path, body: str, expected: str) -> None:
    (one,) = found(tmp_path, body)
    line = HEAD.count("\n") + 1
    other = HEAD.split("\n").index("    def other(self, request, response):") + 2
    places = [f" robot.py:{number}: " for number in (*range(line, line + 1 + body.count("\n")), other)]
    assert one.startswith(expected) and any(place in one for place in places)


@pytest.mark.parametrize("body", HEALTHY)
def test_healthy_code_is_left_alone(tmp_path: Path, body: str) -> None:
    assert found(tmp_path, body) == []


def test_a_lock_of_one_thread_hangs_nobody(tmp_path: Path) -> None:
    assert found(tmp_path, "with self.lock:\n    self.cli.call(Trigger.Request())", threads=1) == []


WAITS = """
import rclpy, threading
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger
class Arm(Node):
    def __init__(self):
        super().__init__("arm")
        self.fresh = threading.Event()
        self.rate = self.create_rate(10)
        self.create_subscription(String, "state", self.on_state, 10, callback_group=GROUP)
        self.create_service(Trigger, "move", self.on_move)
        SETUP
    def on_state(self, message): self.fresh.set()
    def on_move(self, request, response):
        self.fresh.clear()
        BODY
        return response
rclpy.init()
executor = MultiThreadedExecutor(num_threads=THREADS)
executor.add_node(Arm())
executor.spin()
"""


@pytest.mark.parametrize(
    ("body", "threads", "group", "setup", "expected"),
    [
        ("self.fresh.wait()", 1, "None", "", "error"),
        ("self.fresh.wait()", 1, "ReentrantCallbackGroup()", "", "error"),
        ("self.fresh.wait(2.0)", 1, "None", "", "warning"),
        ("self.fresh.wait()", 2, "None", "", "error"),
        ("self.fresh.wait()", 2, "MutuallyExclusiveCallbackGroup()", "", None),
        ("self.fresh.wait()", 2, "ReentrantCallbackGroup()", "", None),
        ("self.fresh.wait()", 1, "None", "threading.Thread(target=self.fresh.set).start()", None),
        ("self.fresh.wait()", 2, "somebody.knows()", "", None),
        ("self.rate.sleep()", 1, "None", "", "error"),
        ("self.rate.sleep()", 2, "None", "", None),
    ],
)
def test_waits_for_what_cannot_run_meanwhile(
    tmp_path: Path, body: str, threads: int, group: str, setup: str, expected: str | None
) -> None:
    text = WAITS.replace("GROUP", group).replace("BODY", body).replace("THREADS", str(threads))
    (tmp_path / "arm.py").write_text(text.replace("SETUP", setup or "pass"))
    found = [
        each for each in code_findings([(".", read_source(tmp_path))]) if each.rule == "code-waits-for-itself"
    ]
    assert [each.severity for each in found] == ([expected] if expected else [])
    line = next(number for number, line in enumerate(WAITS.split("\n"), 1) if "BODY" in line)
    assert all(each.lines == (f"arm.py:{line}",) for each in found)


@pytest.mark.parametrize("body", ["self.fresh.wait()", "self.rate.sleep()"])
def test_a_number_of_threads_that_the_code_does_not_tell_may_be_one(tmp_path: Path, body: str) -> None:
    text = WAITS.replace("GROUP", "None").replace("BODY", body).replace("SETUP", "pass")
    (tmp_path / "arm.py").write_text("import sys\n" + text.replace("THREADS", "int(sys.argv[1])"))
    (found,) = [each for each in code_findings([(".", read_source(tmp_path))]) if "waits-for" in each.rule]
    assert (
        found.severity == "warning" and "if the executor has one thread (open: sys.argv[1])" in found.message
    )


def test_what_a_callback_does_at_several_lines_is_one_finding(tmp_path: Path) -> None:
    body = "time.sleep(5)\nself.step()\ntime.sleep(5)\ntime.sleep(2)"
    text = HEAD + indent(body, "        ") + MAIN.replace("THREADS", "2")
    (tmp_path / "robot.py").write_text(text)
    first = text[: text.index("time.sleep(5)")].count("\n") + 1
    assert [each.lines for each in code_findings([(".", read_source(tmp_path))])] == [
        (f"robot.py:{first}", f"robot.py:{first + 2}"),
        (f"robot.py:{first + 3}",),
    ]
