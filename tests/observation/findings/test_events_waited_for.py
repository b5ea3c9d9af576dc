"""Callbacks that wait for what another callback sets or gives: events, queues, semaphores."""

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


HANDED_OVER = """
import queue
import threading

class Robot(Node):
    def __init__(self):
        super().__init__('robot')
        self.held = MADE
        self.create_subscription(String, 'in', self.heard, 10)
        self.create_timer(1.0, self.tick)

    def heard(self, message):
        GIVES

    def tick(self):
        TAKES

def main():
    rclpy.init()
    rclpy.spin(Robot())
"""


@pytest.mark.parametrize(
    ("made", "gives", "takes", "hangs"),
    [
        ("queue.Queue()", "self.held.put(message)", "self.held.get()", True),
        ("queue.SimpleQueue()", "self.held.put_nowait(message)", "self.held.get(block=True)", True),
        ("queue.Queue()", "self.held.put(message)", "self.held.get_nowait()", False),
        ("queue.Queue()", "self.held.put(message)", "self.held.get(False)", False),
        ("queue.Queue()", "self.held.put(message)", "self.held.get(timeout=0.1)", False),
        ("queue.Queue()", "self.held.put(message)", "return self.held.empty() or self.held.get()", False),
        ("threading.Semaphore(0)", "self.held.release()", "self.held.acquire()", True),
        ("threading.Semaphore(0)", "self.held.release()", "self.held.acquire(False)", False),
        ("threading.Semaphore()", "self.held.release()", "self.held.acquire()", False),
    ],
)
def test_queues_and_semaphores_are_waited_for(
    tmp_path: Path, made: str, gives: str, takes: str, hangs: bool
) -> None:
    """One thread: nothing can give while the timer's callback waits. The proofs were "8 proved"."""
    text = HANDED_OVER.replace("MADE", made).replace("GIVES", gives).replace("TAKES", takes)
    _, shown = run("check", "-q", "--source", files(tmp_path, robot=text))
    assert ("[code-waits-for-itself]" in shown) == hangs, shown
