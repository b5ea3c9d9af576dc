"""Entities that are easily missed: in loops, after checks of settings, in code that nothing runs."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.sources.reading import read_source
from tests.sources.support import HEAD, facts_of, node_of, one

NODE = f"{HEAD}\nrclpy.init()\nrclpy.spin(Node('robot'))\n"


def test_a_loop_goes_through_what_is_not_known_too(tmp_path: Path) -> None:
    """One key is known and left out; others come from parameters."""
    node = node_of(
        tmp_path,
        """
        def __init__(self):
            super().__init__("robot")
            self.names = {"all": "all"}
            for each in self._parameters:
                self.names[each] = each
            for name in self.names:
                if name == "all":
                    continue
                self.create_service(Trigger, name + "/land", self.land)
        def land(self, request, response): return response
        """,
    )
    assert len(node["services"]) == 1


def test_a_program_that_ends_without_a_setting_is_read_as_if_it_had_one(tmp_path: Path) -> None:
    node = node_of(
        tmp_path,
        """
        def __init__(self):
            super().__init__("robot")
            self.declare_parameter("path", "")
            if not self.get_parameter("path").value:
                print("no path")
                sys.exit(1)
            self.pub = self.create_publisher(String, "out", 1)
        """,
    )
    assert [each["name"] for each in node["publishers"]] == ["out"]


def test_calls_in_code_that_nothing_runs_are_named(tmp_path: Path) -> None:
    facts = facts_of(
        tmp_path,
        """
        def main():
            rclpy.init()
            rclpy.spin(Node("robot"))

        if __name__ == "__main__":
            main()
        """,
        plugin="""
        class Plugin:
            def init(self, node):
                node.create_publisher(String, "out", 1)
                node.create_subscription(
                    String, "in", print, 1)
        """,
        test_plugin="""
        def test_it(node):
            node.create_client(Trigger, "x")
        """,
    )
    assert facts.unread == [
        "plugin.py:4: 2 calls of create_publisher, create_subscription (also line 5) in code that no node "
        "is known to run; the model lacks them"
    ]


@pytest.mark.parametrize(("node", "count"), [("", 1), (NODE, 0)])
def test_a_folder_with_tests_only_says_that_they_are_not_read(tmp_path: Path, node: str, count: int) -> None:
    """Without the line, it looks like a folder without ROS; next to nodes, tests are no part of the robot."""
    (tmp_path / "test").mkdir()
    for name in ("publisher_py", "replier_py"):
        (tmp_path / "test" / f"{name}.py").write_text(
            "def main():\n    import rclpy\n    rclpy.create_node('a')\n"
        )
    (tmp_path / "test" / "numbers.py").write_text("print(1)\n")
    (tmp_path / "program.py").write_text(node)
    found = [line for line in read_source(tmp_path).unread if "test" in line]
    words = "test/publisher_py.py: a test that uses ROS, and 1 other file; tests are not read"
    assert found == [words] * count


@pytest.mark.parametrize(
    ("call", "expected"),
    [
        ("drivers.attach(self)", ["drivers.attach"]),
        ("drivers.Driver(node=self)", ["drivers.Driver"]),
        ("drivers.scale(2.0)", []),
        ("drivers.name_of(self.pub)", []),
        ("weakref.ref(self)", []),
        ("tf2_ros.TransformBroadcaster(self)", []),
        ("get_topic_names_and_types(node=self)", []),
    ],
)
def test_functions_outside_of_the_folder_that_get_a_node(
    tmp_path: Path, call: str, expected: list[str]
) -> None:
    text = f"""
import weakref
import drivers
import tf2_ros
from ros2topic.api import get_topic_names_and_types
class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.pub = self.create_publisher(String, "out", 10)
        {call}
rclpy.init()
rclpy.spin(Robot())
"""
    (node,) = facts_of(tmp_path, text).nodes
    assert [path for _, path in node.lent_to] == expected


STRANGE_BASE = """
import message_filters
import rclpy
from rclpy.action import ActionClient
from sensor_msgs.msg import Image
from simple_node import Node
from test_msgs.action import Fibonacci


class Fused(Node):
    def __init__(self):
        super().__init__("fused")
        both = [message_filters.Subscriber(self, Image, name) for name in ("/left", "/right")]
        self.sync = message_filters.ApproximateTimeSynchronizer(both, 10, 0.5)
        self.sync.registerCallback(self.seen)

    def seen(self, left, right):
        pass


class Goer(Node):
    def __init__(self):
        super().__init__("goer")
        self.client = ActionClient(self, Fibonacci, "count")


class Spun(Node):
    def __init__(self):
        super().__init__("spun")


class Other(Node):
    def __init__(self):
        super().__init__("not a node, as far as this code says")


def main():
    rclpy.init()
    Fused().join_spin()
    Goer().join_spin()
    Other()
    rclpy.spin(Spun())
"""


def test_objects_of_unknown_classes_are_nodes_where_a_node_is_needed(tmp_path: Path) -> None:
    fused, goer, spun = facts_of(tmp_path, STRANGE_BASE).nodes
    assert [fused.cls, goer.cls, spun.cls] == ["Fused", "Goer", "Spun"]
    assert [each.name for each in fused.of("subscriptions")] == ["/left", "/right"]
    assert [each.name for each in goer.of("action_clients")] == ["count"]
    assert fused.base == "simple_node.Node" and fused.name == "open: in the base class"
    # The base class may spin the first one; the second has no callbacks.
    assert [fused.threads, goer.threads, spun.threads] == ["open", "not spun", 1]


def test_code_outside_of_the_folder_may_spin_a_node(tmp_path: Path) -> None:
    text = """
import rclpy
from foreign import runner
from rclpy.node import Node
from std_msgs.msg import String


class Ear(Node):
    def __init__(self):
        super().__init__("ear")
        self.create_subscription(String, "chatter", self.hear, 10)

    def hear(self, message):
        pass


def main():
    rclpy.init()
    runner(Ear())
"""
    node = one(facts_of(tmp_path, text))
    assert (node.threads, node.executor) == ("open", "open: code that is not in the folder may spin it")
    kept = one(facts_of(tmp_path, text.replace("runner(Ear())", "Ear()")))
    assert kept.threads == "not spun"
