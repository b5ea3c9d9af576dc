"""Nodes of classes whose base class is a node of a library; types and arguments that such libraries use."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.sources.facts import NodeFact
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

ROBOT = """
#include <rclcpp/rclcpp.hpp>
class Robot : public BASE {
 public:
  Robot() : BASENAME("robot"), updater_((declare_parameter<bool>("own", true), this)) {
    out_ = create_publisher<std_msgs::msg::String>("out", 1);
    ask_ = create_client<tools::action::Cut::Impl::SendGoalService>("cut/_action/send_goal");
  }
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr out_;
  rclcpp::ClientBase::SharedPtr ask_;
  diagnostic_updater::Updater updater_;
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  auto node = std::make_shared<Robot>();
  rclcpp::spin(node->get_node_base_interface());
}
"""


def node_of(folder: Path, base: str) -> NodeFact:
    """Return the node of a class with a base class."""
    text = ROBOT.replace("BASENAME", base.rpartition("::")[2]).replace("BASE", base)
    (folder / "robot.cpp").write_text(text)
    (node,) = read_source(folder).nodes
    return node


@pytest.mark.parametrize(
    "base", ["rclcpp::Node", "rclcpp_cascade_lifecycle::CascadeLifecycleNode", "tools::LifecycleNode"]
)
def test_managed_nodes_of_libraries_are_nodes(tmp_path: Path, base: str) -> None:
    node = node_of(tmp_path, base)
    assert (node.name, node.managed) == ("robot", base.endswith("LifecycleNode"))
    assert "out" in [each.name for each in node.entities]


def test_interfaces_of_actions_have_names(tmp_path: Path) -> None:
    (ask,) = [each for each in node_of(tmp_path, "rclcpp::Node").entities if each.kind == "clients"]
    assert ask.type == "tools/action/Cut_SendGoal"


def test_the_last_value_between_commas_counts(tmp_path: Path) -> None:
    (timer,) = [each for each in node_of(tmp_path, "rclcpp::Node").entities if each.kind == "timers"]
    assert timer.details["period"] == 1.0


def test_a_constructor_that_another_one_calls(tmp_path: Path) -> None:
    text = """
#include <rclcpp/rclcpp.hpp>
struct Plain {};
class Robot : public rclcpp::Node {
 public:
  using Tasks = std::unordered_map<int, std::string>;
  Robot(std::shared_ptr<lib::Data> data, const rclcpp::NodeOptions & options, Plain)
  : Node("robot", options) {}
  Robot(std::shared_ptr<lib::Data> data, Tasks tasks, const rclcpp::NodeOptions & options)
  : Robot(data, options, Plain()) { begin(); }
  explicit Robot(const rclcpp::NodeOptions & options)
  : Robot(std::make_shared<lib::Data>(), Tasks(), options) {}
  void begin() { out_ = create_publisher<std_msgs::msg::String>("out", 1); }
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr out_;
};
std::shared_ptr<rclcpp::Node> make_robot(const rclcpp::NodeOptions & options) {
  return std::make_shared<Robot>(options);
}
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  rclcpp::spin(make_robot());
}
"""
    (tmp_path / "robot.cpp").write_text(text)
    (node,) = read_source(tmp_path).nodes
    assert [each.name for each in node.entities if each.kind == "publishers"] == ["out"]
