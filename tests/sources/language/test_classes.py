"""Several bases of a class, bases outside of the folder that are called by name, methods by their names."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sources.support import effects, facts_of, node_of, one

MAIN = """
if __name__ == "__main__":
    rclpy.init()
    rclpy.spin(Robot())
"""


def published(folder: Path, text: str) -> list[str]:
    """Return the topics of the only node, in the order of their names."""
    return sorted(each["name"] for each in one(facts_of(folder, text + MAIN)).to_json()["publishers"])


def test_look_up_in_a_diamond(tmp_path: Path) -> None:
    """The class that overrides stands before the base that both have."""
    text = """
class Base(Node):
    def topic(self):
        return "base"
class Left(Base):
    pass
class Right(Base):
    def topic(self):
        return "right"
class Robot(Left, Right):
    def __init__(self):
        super().__init__("robot")
        self.create_publisher(String, self.topic(), 10)
"""
    assert published(tmp_path, text) == ["right"]


def test_super_goes_through_a_diamond(tmp_path: Path) -> None:
    text = """
class Base(Node):
    def make(self):
        self.create_publisher(String, "base", 10)
class Left(Base):
    def make(self):
        super().make()
        self.create_publisher(String, "left", 10)
class Right(Base):
    def make(self):
        super().make()
        self.create_publisher(String, "right", 10)
class Robot(Left, Right):
    def __init__(self):
        super().__init__("robot")
        self.make()
"""
    assert published(tmp_path, text) == ["base", "left", "right"]


@pytest.mark.parametrize("bases", ["Node", "Mixin, Node", "Node, Mixin"])
def test_a_base_outside_of_the_folder_is_begun_by_its_name(tmp_path: Path, bases: str) -> None:
    text = f"""
class Mixin:
    pass
class Robot({bases}):
    def __init__(self):
        Node.__init__(self, "lift", namespace="left")
        self.create_timer(0.5, self.tick)
    def tick(self):
        pass
"""
    found = one(facts_of(tmp_path, text + MAIN))
    assert (found.name, found.namespace) == ("lift", "left")


def test_a_method_of_a_base_outside_of_the_folder_is_called_by_its_name(tmp_path: Path) -> None:
    body = """
def __init__(self):
    super().__init__("robot")
    self.pub = Node.create_publisher(self, String, "out", 10)
    Node.create_timer(self, 0.5, self.tick)
def tick(self):
    self.pub.publish(String())
"""
    node = node_of(tmp_path, body)
    assert [each["name"] for each in node["publishers"]] == ["out"]
    assert effects(node, "tick") == [("publish", "self.pub", "always")]


CHOSEN = """
def __init__(self):
    super().__init__("robot")
    self.pub = self.create_publisher(String, "out", 10)
    self.create_subscription(String, "in", self.heard, 10)
def do_go(self):
    self.pub.publish(String())
def do_stop(self):
    pass
def heard(self, message):
    CALL
"""


@pytest.mark.parametrize(
    ("call", "when"),
    [
        ('getattr(self, "do_" + message.data)()', "conditional"),
        ('getattr(self, f"do_{message.data}", self.do_stop)()', "conditional"),
        (
            'method = getattr(self, f"do_{message.data}", None)\n    if method:\n        method()',
            "conditional",
        ),
    ],
)
def test_methods_that_a_name_may_mean(tmp_path: Path, call: str, when: str) -> None:
    """This was proved to do nothing."""
    node = node_of(tmp_path, CHOSEN.replace("CALL", call))
    assert effects(node, "heard") == [("publish", "self.pub", when)]


def test_a_name_that_may_mean_any_method(tmp_path: Path) -> None:
    found = one(
        facts_of(
            tmp_path,
            "class Robot(Node):\n"
            + "".join(
                f"    {line}\n"
                for line in CHOSEN.replace("CALL", "getattr(self, message.data)()").splitlines()
            )
            + MAIN,
        )
    )
    (heard,) = [each for each in found.callbacks if each.name == "heard"]
    assert heard.is_open
