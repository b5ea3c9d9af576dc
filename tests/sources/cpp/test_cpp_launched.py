"""Nodes in C++ that launch files start: programs, components, containers."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.sources.facts import Facts
from dineros.sources.reading import Launch, read_source

pytest.importorskip("tree_sitter_cpp")

DRIVER = """
#include <rclcpp/rclcpp.hpp>
namespace robot {
class Driver : public rclcpp::Node {
 public:
  explicit Driver(const rclcpp::NodeOptions & options) : Node("driver", options) {
    pub_ = create_publisher<std_msgs::msg::String>(declare_parameter("topic", "words"), 1);
  }
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr pub_;
};
}
RCLCPP_COMPONENTS_REGISTER_NODE(robot::Driver)
"""
MAIN = """
#include <rclcpp/rclcpp.hpp>
#include <std_msgs/msg/string.hpp>
using std_msgs::msg::String;
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  auto node = std::make_shared<rclcpp::Node>("alone");
  auto sub = node->create_subscription<String>("words", 1, [](String::SharedPtr) {});
  rclcpp::spin(node);
}
"""
CMAKE = """
project(robot)
add_executable(listen src/main.cpp)
rclcpp_components_register_node(core PLUGIN "robot::Driver" EXECUTABLE drive)
"""
LAUNCH = """
from launch import LaunchDescription
from launch_ros.actions import ComposableNodeContainer, Node
from launch_ros.descriptions import ComposableNode

def driver(name, topic):
    return ComposableNode(package="robot", plugin="robot::Driver", name=name,
                          parameters=[{"topic": topic}])

def generate_launch_description():
    return LaunchDescription([
        ComposableNodeContainer(name="box", namespace="", package="rclcpp_components",
            executable="CONTAINER", composable_node_descriptions=[
                driver("left", "words"),
                driver("right", "signs"),
            ]),
        Node(package="robot", executable="listen", name="ear"),
        Node(package="vendor", executable="camera"),
    ])
"""


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """Return a package with a component and a program."""
    (tmp_path / "src").mkdir()
    (tmp_path / "launch").mkdir()
    (tmp_path / "package.xml").write_text('<package format="3"><name>robot</name></package>')
    (tmp_path / "CMakeLists.txt").write_text(CMAKE)
    (tmp_path / "src" / "driver.cpp").write_text(DRIVER)
    (tmp_path / "src" / "main.cpp").write_text(MAIN)
    return tmp_path


def launched(package: Path, container: str) -> Facts:
    (package / "launch" / "robot.launch.py").write_text(LAUNCH.replace("CONTAINER", container))
    return read_source(package, launch=Launch("robot.launch.py"))


def test_components_share_the_executor_of_their_container(package: Path) -> None:
    facts = launched(package, "component_container_mt")
    nodes = {node.name: node for node in facts.nodes}
    assert set(nodes) == {"left", "right", "ear"}
    left, right = nodes["left"], nodes["right"]
    assert (left.executor, left.threads) == ("MultiThreadedExecutor", "processors")
    assert left.pool and (left.program, left.pool) == (right.program, right.pool)
    assert [node.of("publishers")[0].name for node in (left, right)] == ["words", "signs"]
    assert nodes["ear"].threads == 1 and nodes["ear"].pool == 0
    assert [line for line in facts.unread if "vendor" in line] == [
        "launch/robot.launch.py:18: vendor/camera is not in this folder"
    ]


def test_an_isolated_container_gives_each_its_own_executor(package: Path) -> None:
    nodes = {node.name: node for node in launched(package, "component_container_isolated").nodes}
    assert (nodes["left"].threads, nodes["left"].pool, nodes["right"].pool) == (1, 0, 0)


def test_the_executors_of_an_isolated_container_may_have_several_threads(package: Path) -> None:
    flag = 'component_container_isolated", arguments=["--use_multi_threaded_executor"'
    (package / "launch" / "robot.launch.py").write_text(LAUNCH.replace('CONTAINER"', f"{flag}]"))
    nodes = read_source(package, launch=Launch("robot.launch.py")).nodes
    found = {node.name: (node.executor, node.threads, node.pool) for node in nodes}
    assert found["left"] == found["right"] == ("MultiThreadedExecutor", "processors", 0)


def test_without_a_launch_file_the_program_of_the_component_counts(package: Path) -> None:
    driver = next(node for node in read_source(package).nodes if node.name == "driver")
    assert (driver.program, driver.executor, driver.threads) == ("robot/drive", "SingleThreadedExecutor", 1)
    launched(package, "component_container_mt")
    driver = next(node for node in read_source(package).nodes if node.name == "driver")
    assert driver.threads == "processors", "the launch files of the package agree"


def test_entries_of_a_helper_have_the_lines_of_its_calls(package: Path) -> None:
    facts = launched(package, "component_container")
    (launch,) = facts.launch
    assert [each["at"] for each in launch["nodes"] if each.get("plugin")] == [
        "launch/robot.launch.py:14",
        "launch/robot.launch.py:15",
    ]


def test_facts_name_the_language(package: Path) -> None:
    assert read_source(package).to_json()["language"] == "cpp"
