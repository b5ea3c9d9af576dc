"""Parameters of nodes in C++ whose values are only in launch and parameter files."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

NODE = """
#include <rclcpp/rclcpp.hpp>
namespace robot {
class Mux : public rclcpp::Node {
 public:
  explicit Mux(const rclcpp::NodeOptions & options)
  : Node("mux", rclcpp::NodeOptions().automatically_declare_parameters_from_overrides(true)) {
    BODY
  }
  void open(const std::string & topic) {
    using Words = std_msgs::msg::String;
    subs_.push_back(create_subscription<Words>(topic, 1, [](Words::SharedPtr) {}));
  }
  std::vector<rclcpp::SubscriptionBase::SharedPtr> subs_;
};
}
AFTER
"""
AFTER = {
    "program": "int main(int argc, char ** argv) { rclcpp::init(argc, argv);\n"
    "rclcpp::spin(std::make_shared<robot::Mux>(rclcpp::NodeOptions())); }",
    "component": "RCLCPP_COMPONENTS_REGISTER_NODE(robot::Mux)",
}
STARTED = {
    "program": 'Node(package="robot", executable="mux", name="mux", parameters=[FILE])',
    "component": 'ComposableNodeContainer(name="box", namespace="", package="rclcpp_components",\n'
    '            executable="component_container", composable_node_descriptions=[ComposableNode(\n'
    '            package="robot", plugin="robot::Mux", name="mux", parameters=[FILE])])',
}
CMAKE = {
    "program": "add_executable(mux mux.cpp)",
    "component": 'rclcpp_components_register_node(core PLUGIN "robot::Mux" EXECUTABLE mux_node)',
}
LAUNCH = """
from launch import LaunchDescription
from launch_ros.actions import ComposableNodeContainer, Node
from launch_ros.descriptions import ComposableNode
from launch.substitutions import PathJoinSubstitution
from launch_ros.substitutions import FindPackageShare

FILE = PathJoinSubstitution([FindPackageShare("robot"), "config", "mux.yaml"])

def generate_launch_description():
    return LaunchDescription([STARTED])
"""
VALUES = """
mux:
  ros__parameters:
    out: all_words
    topics:
      left: {topic: left_words, rate: 3}
      right: {topic: right_words, rate: 5}
    locks:
      stop: {topic: stop}
"""
LISTED = """
for (auto prefix : list_parameters({"topics"}, 10).prefixes) {
  rclcpp::Parameter value;
  get_parameter(prefix + ".topic", value);
  open(value.get_value<std::string>());
}
"""


def names(folder: Path, body: str, kind: str, values: str = VALUES) -> list[str]:
    """Return the names of subscriptions of a node that a launch file starts with a parameter file."""
    for path, text in {
        "package.xml": "<package><name>robot</name></package>",
        "CMakeLists.txt": f"project(robot)\n{CMAKE[kind]}\n",
        "mux.cpp": NODE.replace("BODY", body).replace("AFTER", AFTER[kind]),
        "config/mux.yaml": values,
        "launch/mux.launch.py": LAUNCH.replace("STARTED", STARTED[kind]),
    }.items():
        (folder / path).parent.mkdir(exist_ok=True)
        (folder / path).write_text(text)
    (node,) = read_source(folder).nodes
    return sorted(each.name for each in node.entities if each.kind == "subscriptions")


@pytest.mark.parametrize("kind", ["program", "component"])
def test_a_parameter_that_only_a_file_gives(tmp_path: Path, kind: str) -> None:
    assert names(tmp_path, 'open(get_parameter("out").as_string());', kind) == ["all_words"]


@pytest.mark.parametrize("kind", ["program", "component"])
def test_a_file_overrides_the_default_of_the_code(tmp_path: Path, kind: str) -> None:
    body = 'open(declare_parameter("out", std::string("words")));'
    assert names(tmp_path, body, kind) == ["all_words"]


@pytest.mark.parametrize("kind", ["program", "component"])
def test_prefixes_of_listed_parameters(tmp_path: Path, kind: str) -> None:
    assert names(tmp_path, LISTED, kind) == ["left_words", "right_words"]


def test_names_of_listed_parameters(tmp_path: Path) -> None:
    found = names(tmp_path, 'for (auto n : list_parameters({"locks"}, 10).names) { open(n); }', "program")
    assert found == ["locks.stop.topic"]


def test_listed_parameters_without_a_value_are_open(tmp_path: Path) -> None:
    (name,) = names(tmp_path, LISTED, "program", "other:\n  ros__parameters: {a: b}\n")
    assert name.startswith("open: ")


def test_an_alternative_counts_if_no_file_gives_a_value(tmp_path: Path) -> None:
    body = 'std::string t; get_parameter_or("NAME", t, std::string("words")); open(t);'
    assert names(tmp_path, body.replace("NAME", "none"), "program") == ["words"]
    assert names(tmp_path, body.replace("NAME", "out"), "program") == ["all_words"]
