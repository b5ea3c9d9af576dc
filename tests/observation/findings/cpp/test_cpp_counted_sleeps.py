"""Sleeps in C++ loops with a known number of iterations are added up."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.findings.code import code_findings
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

CODE = """
#include <rclcpp/rclcpp.hpp>
using namespace std::chrono_literals;
constexpr int kTimes = 10;
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    sub_ = create_subscription<std_msgs::msg::String>("in", 10,
      [this](std_msgs::msg::String::SharedPtr msg) { work(); });
  }
  void work() {
    rclcpp::Rate rate(2);
    LOOP
  }
  bool is_ready_;
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  rclcpp::spin(std::make_shared<Robot>());
}
"""


@pytest.mark.parametrize(
    ("loop", "seconds"),
    [
        ("for (int i = 0; i < 10; ++i) { rate.sleep(); }", "5"),
        ("for (int i = 0; i < kTimes; i++) rate.sleep();", "5"),
        ("for (int i = 5; i > 0; --i) { std::this_thread::sleep_for(300ms); }", "1.5"),
        ("for (int i = 1; i <= 4; ++i) { for (int j = 0; j < 3; ++j) rate.sleep(); }", "6"),
        ("for (int i = 0; i < 10; ++i) { if (is_ready_) { break; } rate.sleep(); }", None),
        ("for (int i = 0; i < count(); ++i) { rate.sleep(); }", None),
        ("for (int i = 0; i < 10; ++i) { if (is_ready_) { rate.sleep(); } }", None),
        ("for (int i = 0; i < 1; ++i) { rate.sleep(); }", None),
    ],
)
def test_sleeps_of_all_iterations_count(tmp_path: Path, loop: str, seconds: str | None) -> None:
    """One iteration counted, so that five seconds in a callback were not reported."""
    (tmp_path / "robot.cpp").write_text(CODE.replace("LOOP", loop))
    found = [each for each in code_findings([(".", read_source(tmp_path))]) if each.rule == "code-sleeps"]
    assert len(found) == (seconds is not None)
    assert all(f"sleeps {seconds} s in all" in each.message for each in found)
