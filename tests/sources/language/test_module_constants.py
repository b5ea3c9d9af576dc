"""Variables of modules, and values that the code computes from constants."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sources.support import facts_of

PROGRAM = """
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
BEFORE
rclpy.init()
node = Node("robot")
def change():
    CHANGES
node.create_timer(1.0, lambda: change(), callback_group=MutuallyExclusiveCallbackGroup() if TEST else None)
rclpy.spin(node)
"""


def group(folder: Path, before: str, test: str, changes: str = "pass") -> str:
    """Return the callback group of the only timer."""
    text = PROGRAM.replace("BEFORE", before).replace("TEST", test).replace("CHANGES", changes)
    (node,) = facts_of(folder, text).nodes
    (timer,) = node.of("timers")
    return str(timer.details.get("group", "default"))


@pytest.mark.parametrize(
    ("before", "test"),
    [
        ("own = False", "own"),
        ("threads, own = int('2'), 'x' == 'own'", "own"),
        ("own: bool = False", "own"),
        ("given = ['robot', '2', 'x']\nrest = given[1:]", "rest[1] == 'own'"),
        ("given = ['robot', '2', 'x']", "len(given) > 3"),
        ("given = ['robot', '2', 'x']", "len(given[:-1]) != 2"),
        ("text = 'own group'", "text[:2] == 'own'"),
        ("kinds = {'own': True, 'x': False}\nkind = 'x'", "kinds[kind]"),
    ],
)
def test_a_variable_that_one_statement_sets_is_constant(tmp_path: Path, before: str, test: str) -> None:
    assert group(tmp_path, before, test) == "default"


@pytest.mark.parametrize(
    ("before", "changes"),
    [
        ("own = False\nif rclpy.ok(): own = True", "pass"),
        ("for own in (False, True): pass", "pass"),
        ("own = rclpy.ok()", "pass"),
        ("own = False", "global own; own = True"),
    ],
)
def test_other_variables_are_open(tmp_path: Path, before: str, changes: str) -> None:
    assert group(tmp_path, before, "own", changes).startswith("open")


def test_a_branch_that_never_runs_lacks_nothing(tmp_path: Path) -> None:
    before = """
case = "b"
if case == "a":
    other = Node("other")
    other.create_publisher(String, "out", 10)
"""
    text = PROGRAM.replace("BEFORE", before).replace("TEST", "case == 'a'").replace("CHANGES", "pass")
    assert facts_of(tmp_path, text).unread == []
