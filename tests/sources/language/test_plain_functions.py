"""Functions that only calculate are followed some times, and others as often as they are called."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from dineros.sources.language.computing.plain import MOST_RESULTS
from dineros.sources.language.machine import Machine
from tests.sources.support import effects, node_of

BEFORE = """
import math
import numpy as np

class Pose:
    def __init__(self, x, y):
        self.x, self.y = x, y
    def position(self):
        return np.array([self.x, self.y])
    def distance_to(self, other):
        if not isinstance(other, Pose):
            raise TypeError("no pose")
        return np.linalg.norm(self.position() - other.position())
    OTHER

def between(one, other):
    return one.distance_to(other) + math.sqrt(2)
"""
BODY = """
def __init__(self):
    super().__init__("robot")
    self.cli = self.create_client(Trigger, "ask")
    self.create_timer(1.0, self.tick)
def tick(self):
CALLS
    LAST
"""
CALLS = "\n".join(f"    between(Pose({i}, self.x), Pose({i}, self.y))" for i in range(4 * MOST_RESULTS))


def _node(
    tmp_path: Path, *, other: str = "", last: str = "pass", calls: str = CALLS, more: str = ""
) -> dict[str, Any]:
    body = BODY.replace("CALLS", calls).replace("LAST", last)
    return node_of(tmp_path, body, before=BEFORE.replace("OTHER", other) + more)


def test_they_are_followed_some_times(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machines: list[Machine] = []
    step = Machine.step

    def noted(machine: Machine) -> None:
        machines.append(machine)
        step(machine)

    monkeypatch.setattr(Machine, "step", noted)
    _node(tmp_path)
    plain = machines[-1].steps
    machines.clear()
    _node(tmp_path, other="def __eq__(self, other):\n        print('equal')")
    assert plain < 0.6 * machines[-1].steps


@pytest.mark.parametrize(
    ("last", "more"),
    [
        (
            "between(Asks(self), Pose(1, 2))",
            "def distance_to(self, _):\n        self.node.cli.call(None)",
        ),
        ("between(Pose(1, 2), Asks(self))", "def position(self):\n        self.node.cli.call(None)"),
        ("between(Pose(1, 2), Asks(self))", "@property\n    def x(self):\n        self.node.cli.call(None)"),
        ("between(Asks(self), Pose(1, 2))", "position = lambda self: self.node.cli.call(None)"),
        (
            "between(Asks(self), Pose(1, 2))",
            "def position(self):\n        return self\n"
            "    def __sub__(self, other):\n        self.node.cli.call(None)",
        ),
    ],
)
def test_others_are_followed_each_time(tmp_path: Path, last: str, more: str) -> None:
    asks = f"\nclass Asks(Pose):\n    def __init__(self, node):\n        self.node = node\n    {more}\n"
    node = _node(tmp_path, last=last, more=asks)
    assert ("call", "self.cli") in [found[:2] for found in effects(node, "tick")]


def test_errors_are_kept(tmp_path: Path) -> None:
    """A callback that is proved to end must not lose an error that a calculation may raise."""
    one = "between(Pose(1, 2), self.other)"
    calls = "\n".join(f"    {each}" for each in [one] * 40 + ["self.cli.call_async(None)", one])
    node = _node(tmp_path, calls=calls)
    assert "raise" in [found[0] for found in effects(node, "tick")]
