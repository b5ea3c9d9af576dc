"""Ports for numbered parameters: ``odom0``, ``odom1``, ... until one has no value; and names from streams."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.sources.reading import Launch, read_source

PROGRAM = """
#include <rclcpp/rclcpp.hpp>
using Text = std_msgs::msg::String;
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    size_t number = 0;
    bool more = false;
    do {
      std::stringstream stream;
      stream << "odom" << number++;
      std::string name = stream.str();
      std::string topic;
      declare_parameter(name, rclcpp::PARAMETER_STRING);
      rclcpp::Parameter parameter;
      if (get_parameter(name, parameter)) {
        more = true;
        topic = parameter.as_string();
      } else {
        more = false;
      }
      if (more) {
        int depth = declare_parameter(name + "_queue_size", 10);
        inputs_.push_back(create_subscription<Text>(topic, depth, [this](Text::SharedPtr) {}));
      }
    } while (more);
  }
  std::vector<rclcpp::SubscriptionBase::SharedPtr> inputs_;
};
int main() { rclcpp::init(0, nullptr); rclcpp::spin(std::make_shared<Robot>()); }
"""
LAUNCH = """
from launch import LaunchDescription
from launch_ros.actions import Node
def generate_launch_description():
    return LaunchDescription([Node(package="robots", executable="robot", parameters=[VALUES])])
"""


def package(folder: Path, **launched: dict[str, object]) -> Path:
    """Write the program, and a launch file for each set of parameters."""
    (folder / "robot.cpp").write_text(PROGRAM)
    (folder / "CMakeLists.txt").write_text("project(robots)\nadd_executable(robot robot.cpp)\n")
    (folder / "package.xml").write_text("<package><name>robots</name></package>")
    for name, values in launched.items():
        (folder / f"{name}.launch.py").write_text(LAUNCH.replace("VALUES", repr(values)))
    return folder


def heard(folder: Path, launch: str | None = None) -> list[tuple[str, object]]:
    (node,) = read_source(folder, launch=Launch(launch) if launch is not None else None).nodes
    return [(each.name, each.details["depth"]) for each in node.of("subscriptions") if each.is_enabled]


VALUES = {"odom0": "wheels", "odom0_queue_size": 2, "odom1": "visual", "odom3": "ignored"}


def test_the_values_of_a_launch_file_give_the_ports(tmp_path: Path) -> None:
    """The loop ends at the first number without a value."""
    source = package(tmp_path, robot=VALUES)
    assert heard(source, "robot.launch.py") == [("wheels", 2), ("visual", 10)]


def test_without_a_value_there_is_no_port(tmp_path: Path) -> None:
    assert heard(package(tmp_path, robot={"rate": 5}), "robot.launch.py") == []


def test_values_of_all_launch_files_hold_without_one(tmp_path: Path) -> None:
    assert heard(package(tmp_path, robot=VALUES)) == [("wheels", 2), ("visual", 10)]


def test_the_name_is_open_if_launch_files_differ(tmp_path: Path) -> None:
    source = package(tmp_path, one={"odom0": "wheels"}, two={"odom0": "laser"})
    assert heard(source) == [("open: parameter odom{number++}", 10)]
    assert heard(source, "two.launch.py") == [("laser", 10)]


@pytest.mark.parametrize(
    ("body", "name"),
    [
        ('std::stringstream s; s << "a_" << 3 << "_b"; std::string name = s.str();', "a_3_b"),
        ('std::ostringstream s("lost"); s.str(""); s << "a"; s << "b"; auto name = s.str();', "ab"),
        ('int i = 1; int j = i++; int k = ++i; auto name = "a" + std::to_string(10 * j + k);', "a13"),
        ('int i = 5; i--; auto name = "a" + std::to_string(i);', "a4"),
    ],
)
def test_names_from_streams_and_counters(tmp_path: Path, body: str, name: str) -> None:
    start, end = PROGRAM.index("    size_t number"), PROGRAM.index("  }\n  std::vector")
    made = "    inputs_.push_back(create_subscription<Text>(name, 1, [this](Text::SharedPtr) {}));\n"
    (tmp_path / "robot.cpp").write_text(PROGRAM[:start] + body + made + PROGRAM[end:])
    assert heard(tmp_path) == [(name, 1)]


@pytest.mark.parametrize(
    ("kind", "is_open"), [("static int", True), ("static const int", False), ("static constexpr int", False)]
)
def test_a_static_variable_has_the_value_of_the_last_run(tmp_path: Path, kind: str, is_open: bool) -> None:
    start, end = PROGRAM.index("    size_t number"), PROGRAM.index("  }\n  std::vector")
    made = "    inputs_.push_back(create_subscription<Text>(name, 1, [this](Text::SharedPtr) {}));\n"
    body = f'{kind} runs = 0; auto name = "a" + std::to_string(runs);'
    (tmp_path / "robot.cpp").write_text(PROGRAM[:start] + body + made + PROGRAM[end:])
    ((name, _),) = heard(tmp_path)
    assert (name == "a0") is not is_open
