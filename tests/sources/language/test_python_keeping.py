"""Python programs in the cache: the same facts as without it, also after edits and damage."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import random
import re
from pathlib import Path
from typing import Any

import pytest

from dineros.sources.facts import NodeFact
from dineros.sources.keeping.graphs import from_plain, to_plain
from dineros.sources.language import keeping
from dineros.sources.language.keeping import ProgramKeeper
from dineros.sources.reading import Launch, read_source
from tests.sources.support import WORD, edit_a_line

FILES = {
    "setup.py": "",
    "common/__init__.py": "",
    "common/base.py": """
import time
from rclpy.node import Node
from std_msgs.msg import String
from common.names import topic_of
RATE = 10.0
class Base(Node):
    def __init__(self, name):
        super().__init__(name)
        self.busy = False
        self.pub = self.create_publisher(String, topic_of(name), 10)
    def say(self):
        if self.busy:
            return
        self.busy = True
        self.pub.publish(String())
        self.busy = False
""",
    "common/names.py": """
def topic_of(name):
    return name + '/out'
""",
    "first.py": """
import rclpy
from common.base import Base, RATE
class First(Base):
    def __init__(self):
        super().__init__('first')
        self.timer = self.create_timer(1.0 / RATE, self.say)
def main():
    rclpy.init()
    rclpy.spin(First())
if __name__ == '__main__':
    main()
""",
    "second.py": """
import time
import rclpy
from rclpy.node import Node
from std_msgs.msg import String
class Second(Node):
    def __init__(self):
        super().__init__('second')
        topic = self.declare_parameter('topic', 'first/out').value
        self.sub = self.create_subscription(String, topic, self.heard, 5)
    def heard(self, text):
        if text.data == 'stop':
            time.sleep(0.5)
if __name__ == '__main__':
    rclpy.init()
    rclpy.spin(Second())
""",
    "unused.py": """
from rclpy.node import Node
from std_msgs.msg import String
from common.names import topic_of
class Unused(Node):
    def __init__(self):
        super().__init__('unused')
        self.pub = self.create_publisher(String, topic_of('unused'), 10)
""",
}
EDITS = {
    "a constant of another file": ("common/base.py", "RATE = 10.0", "RATE = 20.0"),
    "a method": ("common/base.py", "self.pub.publish(String())", "time.sleep(2.0)"),
    "a function that is imported": ("common/names.py", "/out", "/in"),
    "lines": ("common/base.py", "RATE =", "\n\nRATE ="),
    "a program": ("second.py", "0.5", "0.7"),
}
PROGRAMS = ["first.py", "second.py", "unused.py"]


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    folder = tmp_path / "code"
    for name, text in FILES.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


def facts(folder: Path, cache: Path | None = None, launch: Launch | None = None) -> str:
    """Return all facts, with the branches of callbacks, which the schema of the facts does not show."""
    found = read_source(folder, launch=launch, cache=cache)
    return json.dumps([found.to_json(), found.files, to_plain(found.nodes)])


@pytest.fixture
def ran(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Files of programs that were interpreted and kept since."""
    found: list[str] = []
    save = ProgramKeeper._save

    def noted(self: ProgramKeeper, program: Any, *rest: Any) -> None:
        found.append(program["path"])
        save(self, program, *rest)

    monkeypatch.setattr(ProgramKeeper, "_save", noted)
    return found


def test_what_has_not_changed_is_not_interpreted_again(workspace: Path, ran: list[str]) -> None:
    cache = workspace.parent / "cache"
    first = facts(workspace, cache)
    assert sorted(ran) == PROGRAMS
    assert first == facts(workspace) == facts(workspace, cache)
    assert sorted(ran) == PROGRAMS
    assert oct(cache.stat().st_mode)[-3:] == "700"


@pytest.mark.parametrize("edit", EDITS)
def test_an_edit_counts_at_once(workspace: Path, edit: str, ran: list[str]) -> None:
    cache = workspace.parent / "cache"
    before = facts(workspace, cache)
    ran.clear()
    name, old, new = EDITS[edit]
    text = (workspace / name).read_text()
    assert old in text
    (workspace / name).write_text(text.replace(old, new, 1))
    assert facts(workspace, cache) == facts(workspace) != before
    others = {"second.py": ["second.py"], "common/names.py": ["first.py", "unused.py"]}
    assert sorted(ran) == others.get(name, ["first.py"])


def test_a_new_file_that_an_import_means_counts(workspace: Path) -> None:
    cache = workspace.parent / "cache"
    before = facts(workspace, cache)
    (workspace / "common" / "common").mkdir()
    (workspace / "common" / "common" / "names.py").write_text("def topic_of(name):\n    return '/other'\n")
    assert facts(workspace, cache) == facts(workspace) != before


def test_values_of_a_launch_file_have_entries_of_their_own(workspace: Path, ran: list[str]) -> None:
    cache = workspace.parent / "cache"
    (workspace / "package.xml").write_text("<package><name>both</name></package>")
    (workspace / "setup.py").write_text(
        "setup(name='both', entry_points={'console_scripts': ['first = first:main']})"
    )
    (workspace / "both.launch.py").write_text(
        "from launch import LaunchDescription\n"
        "from launch_ros.actions import Node\n"
        "def generate_launch_description():\n"
        "    return LaunchDescription([Node(package='both', executable='first'),\n"
        "        Node(package='both', executable='second.py', parameters=[{'topic': 'first/late'}])])\n"
    )
    launch = Launch("both.launch.py")
    first = facts(workspace, cache, launch)
    assert "first/late" in first
    ran.clear()
    assert first == facts(workspace, None, launch) == facts(workspace, cache, launch)
    assert ran == []


def test_tables_and_the_reader_are_part_of_the_key(
    workspace: Path, ran: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    cache = workspace.parent / "cache"
    facts(workspace, cache)
    table = workspace.parent / "own.toml"
    table.write_text('[[idiom]]\npath = "lib.Any"\narguments = ["node"]\n')
    read_source(workspace, [table], cache=cache)
    monkeypatch.setattr(keeping, "reader_digest", lambda: "another reader")
    facts(workspace, cache)
    assert sorted(ran) == sorted(3 * PROGRAMS)


def test_random_edits_never_give_stale_facts(workspace: Path) -> None:
    """A cache that is full of earlier states against none, with a fixed seed."""
    cache, random_ = workspace.parent / "cache", random.Random(11)
    words = sorted({word for text in FILES.values() for word in re.findall(WORD, text)})
    files = sorted(name for name, text in FILES.items() if text)
    for _ in range(40):
        edit_a_line(workspace / random_.choice(files), words, random_)
        assert facts(workspace, cache) == facts(workspace)


@pytest.mark.parametrize("damage", ["cut", "other", "empty", "a number", "fewer rows", "types", "deep"])
def test_a_damaged_entry_is_ignored(workspace: Path, damage: str) -> None:
    cache = workspace.parent / "cache"
    right = facts(workspace, cache)
    for entry in sorted(cache.iterdir()):
        content = entry.read_bytes()
        if damage in ("cut", "empty"):
            entry.write_bytes(content[: len(content) // 2 if damage == "cut" else 0])
        elif damage == "other":
            entry.write_bytes(b"\x80\x04cposix\nsystem\n")
        else:
            entry.write_bytes(_forged(content, damage))
    assert facts(workspace, cache) == right


def _forged(content: bytes, how: str) -> bytes:
    """Return an entry with a right hash whose facts have another shape."""
    entry = json.loads(content.partition(b"\n")[2])
    rows = entry["facts"]
    if how == "a number":
        rows[0] = 10**6
    elif how == "fewer rows":
        del rows[-1]
    elif how == "types":
        at = [each.name for each in dataclasses.fields(NodeFact)].index("pool")
        rows[1][1 + at] = True
    else:
        rows[1][1] = json.loads("[" * 90 + "]" * 90)
    text = json.dumps(entry).encode()
    return hashlib.sha256(text).hexdigest().encode() + b"\n" + text


def test_all_objects_come_back_as_they_were(workspace: Path) -> None:
    nodes = read_source(workspace).nodes
    assert any(node.variables for node in nodes)
    plain = to_plain(nodes)
    assert to_plain(from_plain(json.loads(json.dumps(plain)))) == plain
    effect = next(each for node in nodes for callback in node.callbacks for each in callback.effects)
    effect.timeout = float("inf")
    (back,) = {
        each.timeout
        for node in from_plain(json.loads(json.dumps(to_plain(nodes), allow_nan=False)))
        for callback in node.callbacks
        for each in callback.effects
        if each.timeout is not None and each.at == effect.at
    }
    assert back == float("inf")


def test_what_is_not_part_of_facts_is_refused(workspace: Path) -> None:
    nodes = read_source(workspace).nodes
    nodes[0].callbacks[0].effects[0].sends["data"] = ("const", "bytes", b"x")
    with pytest.raises(ValueError, match="a value of type bytes"):
        to_plain(nodes)
