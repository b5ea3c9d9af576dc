"""Attributes that decide what callbacks do, as the facts show them."""

from __future__ import annotations

from pathlib import Path

from tests.sources.support import node_of

_ROBOT = """
class State(enum.Enum):
    IDLE = 1
    AWAY = 2
"""
_BODY = """
def __init__(self):
    super().__init__("robot")
    self.busy = False
    self.state = State.IDLE
    self.last = None
    self.count = 0
    self.pub = self.create_publisher(String, "out", 1)
    self.create_timer(1, self.tick)
    self.create_subscription(String, "in", self.heard, 1)
def tick(self):
    if self.busy or self.state == State.IDLE: return
    if self.last is not None: self.pub.publish(self.last)
    self.busy = True
def heard(self, message):
    self.busy = False
    self.state = State.AWAY
    self.last = message
    self.count = len(message.data)
"""


def test_the_facts_show_values_and_who_sets_and_tests_them(tmp_path: Path) -> None:
    """An attribute that nothing tests is left out."""
    node = node_of(tmp_path, _BODY, before=f"import enum\n{_ROBOT}")
    found = {each["name"]: each for each in node["variables"]}
    assert sorted(found) == ["busy", "last", "state"]
    lines = (tmp_path / "program.py").read_text().splitlines()
    at = {text: f"program.py:{lines.index(f'        {text}') + 1}" for text in ("self.busy = True",)}
    busy = found["busy"]
    assert (busy["first"], busy["values"]) == (False, [False, True])
    assert busy["sets"][0] == {"callback": "tick", "at": at["self.busy = True"], "values": [True]}
    assert [each["callback"] for each in busy["sets"]] == ["tick", "heard"]
    assert [each["callback"] for each in busy["tests"]] == ["tick"]
    assert found["state"]["first"] == "State.1" and "State.2" in found["state"]["values"]
    assert found["last"]["first"] is None and "something" in found["last"]["values"]
    assert "values" not in found["last"]["sets"][0]  # any value


def test_a_node_without_such_attributes_has_no_list_of_them(tmp_path: Path) -> None:
    node = node_of(tmp_path, "def __init__(self):\n    super().__init__('robot')\n    self.busy = False")
    assert "variables" not in node
