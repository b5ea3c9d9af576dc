"""A whole-number field to which all publications assign one value decides about branches."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.importing.coded import coded
from dineros.sources.reading import read_source
from tests.observation.importing.flows.test_received import HEAD, LAMP, TAIL, fired, model_of, switch

LAMP_CPP = """
#include <rclcpp/rclcpp.hpp>
class Lamp : public rclcpp::Node {
public:
  Lamp() : Node("lamp") {
    a_ = create_publisher<std_msgs::msg::Empty>("lit", 1);
    b_ = create_publisher<std_msgs::msg::Empty>("alarm", 1);
    sub_ = create_subscription<std_msgs::msg::Int8>("switch", 1,
      std::bind(&Lamp::on_switch, this, std::placeholders::_1));
  }
  void on_switch(const std_msgs::msg::Int8::SharedPtr msg) {
    if (msg->data == ASKED) { a_->publish(std_msgs::msg::Empty()); }
    else { b_->publish(std_msgs::msg::Empty()); }
  }
};
class Switch : public rclcpp::Node {
public:
  Switch() : Node("switch") {
    pub_ = create_publisher<std_msgs::msg::Int8>("switch", 1);
    timer_ = create_wall_timer(std::chrono::seconds(1), std::bind(&Switch::tick, this));
  }
  void tick() {
    std_msgs::msg::Int8 message;
    message.data = 1;
    pub_->publish(message);
  }
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  rclcpp::executors::SingleThreadedExecutor executor;
  auto lamp = std::make_shared<Lamp>();
  auto other = std::make_shared<Switch>();
  executor.add_node(lamp);
  executor.add_node(other);
  executor.spin();
}
"""


@pytest.mark.parametrize("language", ["python", "cpp"])
@pytest.mark.parametrize(("asked", "expected"), [("1", {"lit"}), ("2", {"alarm"})])
def test_the_other_branch_is_never_taken(
    tmp_path: Path, language: str, asked: str, expected: set[str]
) -> None:
    """Both branches were possible: the only flow was compared with itself."""
    if language == "cpp":
        (tmp_path / "lamp.cpp").write_text(LAMP_CPP.replace("ASKED", asked))
    else:
        for name, text in (
            ("lamp", LAMP.replace("if msg.data:", f"if msg.data == {asked}:")),
            ("switch", switch("        message.data = 1")),
        ):
            (tmp_path / f"{name}.py").write_text((HEAD + text + TAIL).replace("Bool", "Int8"))
    assert fired(tmp_path, model_of(coded([("", read_source(tmp_path))], "code"))) == expected
