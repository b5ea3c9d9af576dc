"""Python: a second spin of the main function never begins, unless code ends the first."""

from __future__ import annotations

from pathlib import Path
from textwrap import indent

import pytest

from dineros.observation.findings.code import code_findings
from dineros.sources.reading import read_source

HEAD = """
import rclpy, signal, sys, threading
from contextlib import suppress
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String
class One(Node):
    def __init__(self):
        super().__init__("one")
        self.create_subscription(String, "in", self.got, 10)
    def got(self, msg): pass
class Two(Node):
    def __init__(self):
        super().__init__("two")
        self.create_subscription(String, "out", self.got, 10)
    def got(self, msg): pass
def run(node): rclpy.spin(node)
def main():
    rclpy.init()
    one, two = One(), Two()
    executor = SingleThreadedExecutor()
"""
NEVER = {
    "functions": "rclpy.spin(one)\nrclpy.spin(two)\nrclpy.shutdown()",
    "executor": "executor.add_node(two)\nrclpy.spin(one)\nexecutor.spin()",
    "executor first": "executor.add_node(one)\nexecutor.spin()\nrclpy.spin(two)",
    "both in a try": "try:\n    rclpy.spin(one)\n    rclpy.spin(two)\nexcept Exception:\n    pass",
    "interrupt": "try:\n    rclpy.spin(one)\nexcept KeyboardInterrupt:\n    pass\nrclpy.spin(two)",
    "finally": "try:\n    rclpy.spin(one)\nfinally:\n    rclpy.shutdown()\nrclpy.init()\nrclpy.spin(two)",
    "helper": "run(one)\nrclpy.spin(two)",
}
MAY = {
    "one spin": "executor.add_node(one)\nexecutor.add_node(two)\nexecutor.spin()",
    "in a thread before": "threading.Thread(target=rclpy.spin, args=(two,)).start()\nrclpy.spin(one)\n"
    "rclpy.spin(two)",
    "thread": "threading.Thread(target=run, args=(one,)).start()\nrclpy.spin(two)",
    "caught": "try:\n    rclpy.spin(one)\nexcept SystemExit:\n    pass\nrclpy.spin(two)",
    "suppressed": "with suppress(SystemExit):\n    rclpy.spin(one)\nrclpy.spin(two)",
    "interrupted and begun again": "try:\n    rclpy.spin(one)\nexcept KeyboardInterrupt:\n    pass\n"
    "rclpy.init()\nrclpy.spin(two)",
    "branches": "if len(sys.argv) > 1:\n    rclpy.spin(one)\nelse:\n    rclpy.spin(two)",
    "perhaps": "if len(sys.argv) > 1:\n    rclpy.spin(one)\nrclpy.spin(two)",
    "once before": "rclpy.spin_once(one)\nrclpy.spin(two)",
    "until before": "rclpy.spin_until_future_complete(one, rclpy.Future())\nrclpy.spin(two)",
    "signal": "signal.signal(signal.SIGUSR1, lambda *_: executor.wake())\nrclpy.spin(one)\nrclpy.spin(two)",
    "a lambda shuts down": "signal_ = lambda: executor.shutdown()\nrclpy.spin(one)\nrclpy.spin(two)",
}


def never_runs(folder: Path, body: str, head: str = HEAD) -> list[str]:
    (folder / "n.py").write_text(head + indent(body, "    ") + '\nif __name__ == "__main__": main()\n')
    return [
        each.message for each in code_findings([("", read_source(folder))]) if each.rule == "code-never-runs"
    ]


@pytest.mark.parametrize("body", NEVER.values(), ids=NEVER)
def test_node_of_a_second_spin_never_runs(tmp_path: Path, body: str) -> None:
    found = never_runs(tmp_path, body)
    assert len(found) == 1 and "two" in found[0]


@pytest.mark.parametrize("body", MAY.values(), ids=MAY)
def test_node_may_run(tmp_path: Path, body: str) -> None:
    assert not never_runs(tmp_path, body)


MOTOR = """
class Motor:
    def shutdown(self): print("off")
"""


@pytest.mark.parametrize(
    ("call", "ends"), [("self.motor.shutdown()", False), ("self.other.shutdown()", True)]
)
def test_another_method_of_that_name_ends_no_spin(tmp_path: Path, call: str, ends: bool) -> None:
    head = HEAD.replace("class One", f"{MOTOR}class One", 1).replace("pass", call, 1)
    head = head.replace('super().__init__("one")', 'super().__init__("one"); self.motor = Motor()', 1)
    assert bool(never_runs(tmp_path, "rclpy.spin(one)\nrclpy.spin(two)", head)) is not ends


def test_a_callback_that_shuts_down_ends_the_first_spin(tmp_path: Path) -> None:
    body = "rclpy.spin(one)\nrclpy.init()\nrclpy.spin(two)"
    assert never_runs(tmp_path, body)
    assert not never_runs(tmp_path, body, HEAD.replace("pass", "rclpy.shutdown()", 1))
