"""Callbacks in C++ that wait for a condition variable that no code notifies."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.findings.code import code_findings
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

ROBOT = """
#include <rclcpp/rclcpp.hpp>
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    timer_ = create_wall_timer(std::chrono::seconds(1), [this]() { tick(); });
  }
  void tick() {
    std::unique_lock<std::mutex> lock(mutex_);
    TICK
  }
  void other() { OTHER }
  std::mutex mutex_;
  std::condition_variable cv_;
  bool ready_ = false;
  rclcpp::TimerBase::SharedPtr timer_;
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  rclcpp::spin(std::make_shared<Robot>());
}
"""


@pytest.mark.parametrize(
    ("tick", "other", "hangs"),
    [
        ("cv_.wait(lock);", "", True),
        ("while (!ready_) { cv_.wait(lock); }", "ready_ = true;", True),
        ("cv_.wait(lock, [this] { return ready_; });", "ready_ = true;", False),
        ("cv_.wait_for(lock, std::chrono::seconds(1));", "", False),
        ("cv_.wait(lock);", "cv_.notify_one();", False),
        ("cv_.wait(lock);", "vendor::use(cv_);", False),
        ("cv_.wait(lock);", "auto & other = this->cv_; other.notify_all();", False),
    ],
)
def test_a_condition_variable_that_no_code_notifies(
    tmp_path: Path, tick: str, other: str, hangs: bool
) -> None:
    """This was a proof under an assumption."""
    (tmp_path / "robot.cpp").write_text(ROBOT.replace("TICK", tick).replace("OTHER", other))
    found = [each.message for each in code_findings([("", read_source(tmp_path))])]
    assert any("no code sets" in each for each in found) == hangs, found
