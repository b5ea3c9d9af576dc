"""Loops whose next turn does other things than the first one: with what an earlier turn has assigned."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sources.support import effects, node_of

INIT = """
def __init__(self):
    super().__init__("robot")
    self.cli = self.create_client(Trigger, "ask")
    self.create_timer(1.0, self.tick)
def ask(self):
    self.cli.call(Trigger.Request())
def nothing(self):
    pass
def tick(self):
"""


@pytest.mark.parametrize(
    "does",
    [
        "run = None\nfor each in self.get_node_names():\n    if run:\n        run()\n    run = self.ask",
        "run = self.nothing\nfor each in self.get_node_names():\n    run()\n    run = self.ask",
        "last = None\nwhile self.count_publishers('x'):\n    if last is not None:\n        self.ask()\n"
        "    last = 1",
        "todo = []\nfor each in self.get_node_names():\n    for run in todo:\n        run()\n"
        "    todo.append(self.ask)",
        "known = {}\nfor each in self.get_node_names():\n    if each in known:\n        known[each]()\n"
        "    known[each] = self.ask",
        "self.run = None\nfor each in self.get_node_names():\n    if self.run:\n        self.run()\n"
        "    self.run = self.ask",
        "run = None\nfor each in self.get_node_names():\n    for other in self.get_topic_names():\n"
        "        if run:\n            run()\n        run = self.ask",
    ],
)
def test_what_a_turn_leaves_for_the_next(tmp_path: Path, does: str) -> None:
    """The body was read as in the first turn only."""
    lines = "\n".join(f"    {line}" for line in does.splitlines())
    assert ("call", "self.cli", "in a loop") in effects(node_of(tmp_path, INIT + lines), "tick")


def test_a_loop_that_keeps_nothing(tmp_path: Path) -> None:
    does = "    run = None\n    for each in self.get_node_names():\n        if run:\n            self.ask()\n"
    assert effects(node_of(tmp_path, INIT + does), "tick") == []
