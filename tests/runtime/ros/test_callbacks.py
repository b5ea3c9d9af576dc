"""Nodes written by hand, on real rclpy: they block or lose where the guide says so; fixed they do not."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import pytest

from dineros.runtime.ros.process.domains import claimed_domain
from dineros.runtime.ros.process.environment import ros_environment
from dineros.runtime.ros.process.memory import remove_abandoned

ROOT = Path(__file__).resolve().parents[3]
PROGRAMS = ROOT / "examples/callbacks"
PATIENCE = 60.0
"""Seconds, for machines that are slow; on a good day this takes two."""

BLOCK = {
    "same_group": 1,
    "one_thread": 1,
    "reentrant": 2,
    "awaiting": 1,
    "answer_one_thread": 1,
    "calling_each_other": 1,
}
"""How many calls each program has begun when nothing moves any more."""
RUN = ["own_group", "awaiting_own_group", "answer_two_threads", "calling_each_other_fixed"]
LOSES, KEEPS = "fast_sensor", "fast_sensor_fixed"
ENOUGH = 12
"""Answers that each of those that run gets, and scans that each mapper works on."""


@dataclass
class Logs:
    """What the programs have said so far."""

    folder: Path

    def text(self, program: str) -> str:
        log = self.folder / f"{program}.log"
        return log.read_text(errors="replace") if log.exists() else ""

    def count(self, program: str, word: str) -> int:
        return self.text(program).splitlines().count(word)

    def scans(self, program: str) -> list[int]:
        return [int(number) for number in re.findall(r"^scan (\d+)$", self.text(program), re.MULTILINE)]

    def wait(self, condition: Callable[[], bool], what: str) -> None:
        end = time.monotonic() + PATIENCE
        while not condition():
            if time.monotonic() > end:
                pytest.fail(f"{what}\n" + "\n".join(map(self.text, (*BLOCK, *RUN, LOSES, KEEPS))))
            time.sleep(0.02)


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Logs]:
    """Run all programs at once; those that run are the clock of those that block."""
    folder = tmp_path_factory.mktemp("callbacks")
    with claimed_domain() as domain:
        environment = ros_environment(folder / "ros", domain, "memory", os.environ)
        environment["RCUTILS_CONSOLE_OUTPUT_FORMAT"] = "{message}"
        runner = Path(__file__).with_name("forking.py")
        programs = [*BLOCK, *RUN, LOSES, KEEPS]
        process = subprocess.Popen(
            [sys.executable, runner, PROGRAMS, folder, *programs], env=environment, stdin=subprocess.PIPE
        )
        yield Logs(folder)
        assert process.stdin is not None
        process.stdin.close()
        assert process.wait(PATIENCE) == 0
    remove_abandoned()  # what those that were killed could not remove


@pytest.mark.long
def test_they_block_until_fixed(logs: Logs) -> None:
    """Each call that a program waits for was served, and no answer comes while the others get many."""

    def blocks(program: str, waiting: int) -> bool:
        asked, served = logs.count(program, "asks"), logs.count(program, "served")
        return asked == served == logs.count(program, "answered") + waiting

    def wait_for_others() -> None:
        goals = {program: logs.count(program, "answered") + ENOUGH for program in RUN}
        logs.wait(
            lambda: all(logs.count(program, "answered") >= goal for program, goal in goals.items()),
            "not all run that should",
        )

    wait_for_others()  # an answer that is just under way is none that never comes
    logs.wait(lambda: all(blocks(*each) for each in BLOCK.items()), "not all block that should")
    wait_for_others()
    before = {program: logs.count(program, "answered") for program in BLOCK}
    wait_for_others()
    assert all(blocks(*each) for each in BLOCK.items())
    assert before == {program: logs.count(program, "answered") for program in BLOCK}


def test_the_fast_sensor_loses_until_fixed(logs: Logs) -> None:
    logs.wait(lambda: all(len(logs.scans(name)) > ENOUGH for name in (LOSES, KEEPS)), "no scans")
    kept = logs.scans(KEEPS)
    assert kept == list(range(1, len(kept) + 1))
    assert any(after - before > 1 for before, after in pairwise(logs.scans(LOSES)))


SPINNING = """
import rclpy
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future

rclpy.init()
node, executor, done = Node("robot"), MultiThreadedExecutor(num_threads=2), Future()
executor.add_node(node)
done.set_result(None)
rclpy.spin_until_future_complete(node, done, executor)
print(node in executor.get_nodes())
rclpy.spin_until_future_complete(node, done)
print(node in executor.get_nodes(), node in rclpy.get_global_executor().get_nodes())
"""


@pytest.mark.long
def test_a_node_that_another_executor_spins_is_in_none_afterwards(tmp_path: Path) -> None:
    """The guide's page of patterns says so, and models it."""
    pytest.importorskip("rclpy")
    with claimed_domain() as domain:
        environment = ros_environment(tmp_path, domain, "memory", os.environ)
        run = subprocess.run(
            [sys.executable, "-c", SPINNING],
            env=environment,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
    assert (run.returncode, run.stdout.split()) == (0, ["True", "False", "False"]), run.stderr
