"""Callback groups in C++ that do not go with their node: without an executor, their callbacks never run."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.analysis.witnesses.findings import Finding
from dineros.observation.findings.code import code_findings
from dineros.observation.importing.coded import coded
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

ROBOT = """
#include <rclcpp/rclcpp.hpp>
using std_msgs::msg::String;
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    group_ = create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive, JOINS);
    rclcpp::SubscriptionOptions options;
    options.callback_group = group_;
    sub_ = create_subscription<String>("in", 10, [this](String::SharedPtr m) { pub_->publish(*m); }, options);
    pub_ = create_publisher<String>("out", 10);
    START
  }
  rclcpp::CallbackGroup::SharedPtr group_;
  rclcpp::Publisher<String>::SharedPtr pub_;
  rclcpp::Subscription<String>::SharedPtr sub_;
  rclcpp::executors::SingleThreadedExecutor own_;
  std::thread thread_;
};
int main() {
  rclcpp::init();
  auto node = std::make_shared<Robot>();
  rclcpp::executors::SingleThreadedExecutor e;
  e.add_node(node);
  MAIN
  e.spin();
}
"""
ADD = """own_.add_callback_group(group_, get_node_base_interface());
    thread_ = std::thread([this]() { own_.spin(); });"""


def _found(folder: Path, joins: str, start: str = "", main: str = "") -> tuple[list[Finding], list[str]]:
    code = ROBOT.replace("JOINS", joins).replace("    START", start).replace("  MAIN", main)
    (folder / "robot.cpp").write_text(code)
    read = [(str(folder), read_source(folder))]
    lacks = [each for each in coded(read, "robot").lacks if "gets callback group" in each]
    return code_findings(read), lacks


def test_a_group_that_no_executor_gets_is_an_error_at_its_line(tmp_path: Path) -> None:
    (found,), lacks = _found(tmp_path, "false")
    assert (found.rule, found.severity) == ("code-never-runs", "error")
    assert "no executor gets it: the callbacks of in (line 10) never run" in found.message
    assert found.lines[0].endswith("robot.cpp:7")
    assert len(lacks) == 1


@pytest.mark.parametrize(
    ("joins", "start", "main"),
    [
        ("true", "", ""),
        ("false", ADD, ""),
        ("false", "", "e.add_callback_group(node->group_, node->get_node_base_interface());"),
        ("false", "start(own_); own_.add_callback_group(pick(), get_node_base_interface());", ""),
        ("false", "", "node->for_each_callback_group([&e](auto group) { e.add(group); });"),
        ("joins_", "", ""),
        ("false", "waits_.add_subscription(sub_);  // an rclcpp::WaitSet", ""),
    ],
)
def test_groups_with_an_executor_are_quiet(tmp_path: Path, joins: str, start: str, main: str) -> None:
    assert _found(tmp_path, joins, start, main) == ([], [])


def test_code_that_is_not_followed_may_give_it_to_an_executor(tmp_path: Path) -> None:
    (tmp_path / "other.cpp").write_text("void f(E & e, G g) { e.add_callback_group(g, nullptr); }")
    (found,), lacks = _found(tmp_path, "false")
    assert (found.rule, found.severity) == ("code-never-runs", "warning")
    assert "no code is found that gives it to an executor" in found.message
    assert len(lacks) == 1


def test_a_group_without_callbacks_is_quiet(tmp_path: Path) -> None:
    code = ROBOT.replace("JOINS", "false").replace("options.callback_group = group_;", "")
    (tmp_path / "robot.cpp").write_text(code)
    assert code_findings([(str(tmp_path), read_source(tmp_path))]) == []
