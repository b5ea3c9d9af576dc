"""Timers that are cancelled, reset or made while the node runs: the model ticks on, and says so."""

from __future__ import annotations

from pathlib import Path
from textwrap import dedent

import pytest

from dineros.observation.importing.coded import Coded, coded
from dineros.sources.reading import read_source

PYTHON = """
import rclpy
from rclpy.node import Node
from std_msgs.msg import String

class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.pub = self.create_publisher(String, "out", 1)
        self.timer = self.create_timer(0.5, self.tick)
        self.create_subscription(String, "in", self.heard, 1)
    def tick(self):
        TICK
        self.pub.publish(String())
    def heard(self, message):
        HEARD
        return

def main():
    rclpy.init()
    robot = Robot()
    rclpy.spin(robot)
    robot.timer.cancel()

if __name__ == "__main__":
    main()
"""
CPP = """
#include <rclcpp/rclcpp.hpp>
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    pub_ = create_publisher<std_msgs::msg::String>("out", 1);
    timer_ = create_wall_timer(std::chrono::milliseconds(500), [this]() { tick(); });
    sub_ = create_subscription<std_msgs::msg::String>("in", 1, std::bind(&Robot::heard, this, _1));
    MADE
  }
  void tick() { TICK pub_->publish(std_msgs::msg::String()); }
  void heard() { HEARD }
};
int main() { rclcpp::init(0, nullptr); rclcpp::spin(std::make_shared<Robot>()); }
"""


def read(folder: Path, name: str, text: str, **parts: str) -> Coded:
    for part in ("TICK", "HEARD", "MADE"):
        text = text.replace(part, parts.get(part, "pass" if name.endswith(".py") else ""))
    (folder / name).write_text(dedent(text))
    return coded([(".", read_source(folder))], "robot")


CASES = {
    ("robot.py", "TICK", "self.timer.cancel()"): "is cancelled in tick each time, so that it fires once",
    ("robot.py", "HEARD", "self.timer.reset()"): "is reset in heard",
    ("robot.py", "HEARD", "self.destroy_timer(self.timer)"): "is destroyed in heard",
    ("robot.cpp", "TICK", "timer_->cancel();"): "is cancelled in tick each time, so that it fires once",
    ("robot.cpp", "TICK", "if (done_) { timer_->cancel(); }"): "is cancelled in tick;",
    ("robot.cpp", "HEARD", "timer_->reset();"): "is reset in heard",
    ("robot.cpp", "HEARD", "timer_.reset();"): "is destroyed in heard",
    ("robot.cpp", "MADE", "timer_->cancel();"): "is cancelled in main;",
}


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[0]} {case[2]}")
def test_a_timer_that_may_stop_ticks_at_any_time_and_is_named(
    tmp_path: Path, case: tuple[str, str, str]
) -> None:
    name, part, line = case
    found = read(tmp_path, name, PYTHON if name.endswith(".py") else CPP, **{part: line})
    (said,) = [each for each in found.taken if "timer" in each]
    assert CASES[case] in said and "never stops: that it does is left out" in said
    assert len(found.lacks) == 1
    assert found.given.nodes["/robot"].open_timers


@pytest.mark.parametrize("name", ["robot.py", "robot.cpp"])
def test_other_timers_keep_their_period(tmp_path: Path, name: str) -> None:
    """The main function cancels one when the program ends: that changes nothing."""
    found = read(tmp_path, name, PYTHON if name.endswith(".py") else CPP)
    assert not found.given.nodes["/robot"].open_timers and found.lacks == ()
