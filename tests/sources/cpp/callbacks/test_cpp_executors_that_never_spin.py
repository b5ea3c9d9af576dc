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
  WORKER thread_;
};
class Free : public rclcpp::Node {
 public:
  Free() : Node("free") { timer_ = create_wall_timer(1s, [] {}); }
  rclcpp::TimerBase::SharedPtr timer_;
};
class Other : public rclcpp::Node {
 public:
  Other() : Node("other") { timer_ = create_wall_timer(1s, [] {}); }
  rclcpp::TimerBase::SharedPtr timer_;
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


def never_run(folder: Path, start: str, main: str, worker: str = "std::thread") -> list[str]:
    """Return the severities of callbacks that never run."""
    text = CODE.replace("START", start).replace("MAIN", main).replace("WORKER", worker)
    (folder / "robot.cpp").write_text(text)
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
    (tmp_path / "robot.cpp").write_text(
        CODE.replace("START", start).replace("MAIN", SPIN).replace("WORKER", "int")
    )
    assert not code_findings([(".", read_source(tmp_path))])


AWAY = " start(executor_);"
"""Unknown code runs the group of the other class."""
PAIR = """
  auto a = std::make_shared<Free>();
  auto b = std::make_shared<Other>();
  rclcpp::executors::SingleThreadedExecutor first, second;
  first.add_node(a);
  second.add_node(b);
"""


@pytest.mark.parametrize(
    ("main", "found"),
    [
        (PAIR + "first.spin(); second.spin(); rclcpp::shutdown();", ["error"]),
        ("rclcpp::spin(std::make_shared<Free>()); rclcpp::spin(std::make_shared<Other>());", ["error"]),
        (PAIR + "if (argc > 1) { first.spin(); } else { second.spin(); }", []),
        (PAIR + "if (argc > 1) { first.spin(); } second.spin();", []),
        (PAIR + "std::thread other([&] { first.spin(); }); second.spin();", []),
        (PAIR + "std::thread other([&] { wait(); first.cancel(); }); first.spin(); second.spin();", []),
        (PAIR + "while (rclcpp::ok()) { first.spin_some(); second.spin_some(); }", []),
        (PAIR + "first.spin_some(); second.spin();", []),
        (PAIR + "first.add_node(b); first.spin(); second.spin();", []),
    ],
)
def test_a_second_spin_of_the_main_function_never_begins(tmp_path: Path, main: str, found: list[str]) -> None:
    """Unless code ends the first one. Before, the callbacks of the second were taken to run."""
    assert never_run(tmp_path, GETS + AWAY, main, "int") == found


def test_a_shutdown_in_a_callback_ends_the_first_spin(tmp_path: Path) -> None:
    timer = "auto t = a->create_wall_timer(1s, [] { rclcpp::shutdown(); });"
    main = PAIR + timer + "first.spin(); second.spin(); rclcpp::shutdown();"
    assert not never_run(tmp_path, GETS + AWAY, main, "int")
