"""Nodes and callback groups in C++ that only an executor gets that never spins."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.findings.code import code_findings
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

CODE = """
#include <rclcpp/rclcpp.hpp>
using namespace std::chrono_literals;
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    group_ = create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive, false);
    rclcpp::SubscriptionOptions options;
    options.callback_group = group_;
    sub_ = create_subscription<std_msgs::msg::String>("in", 10, [this](std_msgs::msg::String::SharedPtr) {
      stop();
    }, options);
    START
  }
  void stop() {}
  rclcpp::CallbackGroup::SharedPtr group_;
  rclcpp::Subscription<std_msgs::msg::String>::SharedPtr sub_;
  rclcpp::TimerBase::SharedPtr timer_;
  rclcpp::executors::SingleThreadedExecutor executor_;
  std::thread thread_;
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  MAIN
}
"""
SPIN = "rclcpp::spin(std::make_shared<Robot>());"
GETS = "executor_.add_callback_group(group_, get_node_base_interface());"
TWO = """
  auto node = std::make_shared<Robot>();
  rclcpp::executors::SingleThreadedExecutor first, second;
  first.add_node(node);
  second.add_callback_group(node->group_, node->get_node_base_interface());
"""


def never_run(folder: Path, start: str, main: str) -> list[str]:
    """Return the severities of callbacks that never run."""
    (folder / "robot.cpp").write_text(CODE.replace("START", start).replace("MAIN", main))
    found = code_findings([(".", read_source(folder))])
    return [each.severity for each in found if each.rule == "code-never-runs"]


@pytest.mark.parametrize(
    ("start", "main"),
    [
        (GETS, SPIN),
        (f"this->{GETS}", SPIN),
        ("", TWO + "first.spin();"),
        (GETS, "rclcpp::executors::SingleThreadedExecutor e; e.add_node(std::make_shared<Robot>());"),
    ],
)
def test_an_executor_that_never_spins_is_an_error(tmp_path: Path, start: str, main: str) -> None:
    """Before, such callbacks were taken to run: "0 found, 8 proved"."""
    assert never_run(tmp_path, start, main) == ["error"]


@pytest.mark.parametrize(
    ("start", "main"),
    [
        (f"{GETS} thread_ = std::thread([this] {{ executor_.spin(); }});", SPIN),
        (
            f"{GETS} thread_ = std::thread(&rclcpp::executors::SingleThreadedExecutor::spin, &executor_);",
            SPIN,
        ),
        (f"{GETS} thread_ = std::thread(std::bind(&rclcpp::Executor::spin, &executor_));", SPIN),
        (f"{GETS} timer_ = create_wall_timer(10ms, [this] {{ executor_.spin_some(); }});", SPIN),
        ("", TWO + "std::thread other([&second] { second.spin(); }); first.spin();"),
        ("", TWO + "std::thread other([&] { run(second); }); first.spin();"),
    ],
)
def test_executors_that_spin_or_may_spin_are_quiet(tmp_path: Path, start: str, main: str) -> None:
    """Also an executor that unknown code receives."""
    assert not never_run(tmp_path, start, main)


def test_a_callback_may_spin_an_executor_that_has_only_its_groups(tmp_path: Path) -> None:
    """It was reported that rclcpp throws, as if the node were in that executor."""
    start = f"{GETS} timer_ = create_wall_timer(10ms, [this] {{ executor_.spin_some(); }});"
    (tmp_path / "robot.cpp").write_text(CODE.replace("START", start).replace("MAIN", SPIN))
    assert not code_findings([(".", read_source(tmp_path))])
