"""Attributes that a class has until a callback gives an object its own."""

from __future__ import annotations

from pathlib import Path

from tests.sources.support import effects, node_of

BODY = """
def _first(self):
    self.cli.call(Trigger.Request())
run = _first
enabled = True
def __init__(self):
    super().__init__("robot")
    self.cli = self.create_client(Trigger, "ask")
    self.create_timer(1.0, self.tick)
    self.create_subscription(String, "stop", self.stop, 1)
def nothing(self):
    pass
def tick(self):
    self.run()
def stop(self, message):
    self.run = self.nothing
"""


def test_both_may_be_called(tmp_path: Path) -> None:
    """The function of the class was lost."""
    assert effects(node_of(tmp_path, BODY), "tick") == [("call", "self.cli", "conditional")]


def test_in_some_branch(tmp_path: Path) -> None:
    body = BODY.replace(
        "    self.run()", "    if self.stopped():\n        self.run = self.nothing\n    self.run()"
    )
    assert effects(node_of(tmp_path, body), "tick") == [("call", "self.cli", "conditional")]


def test_the_constructor_replaces_it(tmp_path: Path) -> None:
    body = BODY.replace("    self.create_timer", "    self.run = self.nothing\n    self.create_timer")
    assert effects(node_of(tmp_path, body), "tick") == []
