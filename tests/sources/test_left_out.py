"""Entities that are easily missed: in loops, after checks of settings, in code that nothing runs."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.sources.reading import read_source
from tests.sources.support import HEAD, facts_of, node_of

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
