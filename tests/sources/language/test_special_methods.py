"""What Python calls without a name: methods of operators, loops and subscripts, and ``__getattr__``."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sources.support import effects, facts_of, node_of, one

REMOTE = """
class Remote:
    def __init__(self, node):
        self.cli = node.create_client(Trigger, "ask")
    def ask(self, *others):
        self.cli.call(Trigger.Request())
        return 1
    def walk(self):
        yield self.ask()
    def __iter__(self):
        return self
    def __str__(self):
        return f"{self.ask()}"
    __getitem__ = __setitem__ = __delitem__ = __contains__ = __add__ = __lt__ = __eq__ = __next__ = ask
    __len__ = __iadd__ = ask

class Lines:
    def __init__(self, remote):
        self.remote = remote
    def __iter__(self):
        yield self.remote.ask()
"""
INIT = """
def __init__(self):
    super().__init__("robot")
    self.remote = Remote(self)
    self.lines = Lines(self.remote)
    self.create_timer(1.0, self.tick)
def tick(self):
    DOES
"""


@pytest.mark.parametrize(
    ("does", "when"),
    [
        ("self.remote[1]", "always"),
        ("self.remote[1] = 2", "always"),
        ("del self.remote[1]", "always"),
        ("return 1 in self.remote", "always"),
        ("return self.remote + 1", "always"),
        ("return self.remote < 1", "always"),
        ("return self.remote == 1", "always"),
        ("return len(self.remote)", "always"),
        ("return str(self.remote)", "always"),
        ("print(f'{self.remote}')", "always"),
        ("return next(self.remote)", "always"),
        ("for each in self.remote: break", "in a loop"),
        ("for each in self.lines: pass", "always"),
        ("return [each for each in self.lines]", "always"),
        ("return list(self.lines)", "always"),
        ("return sorted([1, 2], key=self.remote.ask)", "in a loop"),
        ("return list(filter(self.remote.ask, [1, 2]))", "in a loop"),
        ("remote = self.remote\n    remote += 1", "always"),
        ("return self.remote is None", ""),
        ("return self.remote", ""),
    ],
)
def test_special_methods_are_called(tmp_path: Path, does: str, when: str) -> None:
    """What they do was missing, and the callback was proved to end."""
    node = node_of(tmp_path, INIT.replace("DOES", does), before=REMOTE)
    assert effects(node, "tick") == [("call", "self.cli", when)] * bool(when)


def test_attributes_that_a_proxy_gives(tmp_path: Path) -> None:
    before = """
class Proxy:
    def __init__(self, node):
        self._node = node
    def __getattr__(self, name):
        return getattr(self._node, name)
"""
    body = """
def __init__(self):
    super().__init__("robot")
    self.proxy = Proxy(self)
    self.pub = self.proxy.create_publisher(String, "out", 10)
    self.proxy.create_timer(1.0, self.tick)
def tick(self):
    self.pub.publish(String())
"""
    node = node_of(tmp_path, body, before=before)
    assert [each["name"] for each in node["publishers"]] == ["out"]
    assert effects(node, "tick") == [("publish", "self.pub", "always")]


def test_a_property_of_the_base_class(tmp_path: Path) -> None:
    text = """
class Base(Node):
    @property
    def topic(self):
        return "base"
class Robot(Base):
    def __init__(self):
        super().__init__("robot")
        self.create_publisher(String, self.topic, 10)
    @property
    def topic(self):
        return super().topic + "/out"
if __name__ == "__main__":
    rclpy.init()
    rclpy.spin(Robot())
"""
    node = one(facts_of(tmp_path, text)).to_json()
    assert [each["name"] for each in node["publishers"]] == ["base/out"]


@pytest.mark.parametrize("fields", ["['name', 'run']", "'name, run'"])
def test_functions_in_named_tuples(tmp_path: Path, fields: str) -> None:
    """Their effects belonged to an event that may come at any time."""
    body = INIT.replace("self.lines =", "self.step = Step('a', run=self.remote.ask)\n    self.lines =")
    before = f"from collections import namedtuple\nStep = namedtuple('Step', {fields})\n{REMOTE}"
    node = node_of(tmp_path, body.replace("DOES", "self.step.run()"), before=before)
    assert effects(node, "tick") == [("call", "self.cli", "always")]
    assert [each["kind"] for each in node["callbacks"]] == ["timer"]
