"""Callbacks that wait for an event which the done callback of a request sets."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.programs.coded import files, run

PROGRAM = """
import threading

class Robot(Node):
    def __init__(self):
        super().__init__('robot')
        self.done = threading.Event()
        self.other = self.create_client(Trigger, 'other'GROUP)
        self.create_timer(1.0, self.tick)

    def tick(self):
        self.other.call_async(Trigger.Request()).add_done_callback(self.finish)
        self.done.wait()
        self.done.clear()

    def finish(self, future):
        self.done.set()

def main():
    rclpy.init()
    executor = MultiThreadedExecutor(4)
    executor.add_node(Robot())
    executor.spin()
"""


@pytest.mark.parametrize(
    ("group", "hangs"), [("", True), (", callback_group=MutuallyExclusiveCallbackGroup()", False)]
)
def test_a_done_callback_starts_in_the_group_of_its_client(tmp_path: Path, group: str, hangs: bool) -> None:
    """The client takes no response while a callback of its group waits."""
    _, text = run("check", "-q", "--source", files(tmp_path, robot=PROGRAM.replace("GROUP", group)))
    assert ("[code-waits-for-itself]" in text) == hangs, text
