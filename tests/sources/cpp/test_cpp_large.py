"""Routines in C++: values that they give back by reference, and which of them a large program skips."""

from pathlib import Path

import pytest

from dineros.sources.cpp.following import routines
from dineros.sources.facts import NodeFact, is_open
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

CODE = """
#include <rclcpp/rclcpp.hpp>
template<class T>
void fill(rclcpp::Node * node, const std::string & name, T & value) {
  node->declare_parameter(name, value);
  value = node->get_parameter(name).as_string();
}
class Grid {
 public:
  void resize(int size) { size_ = size; rate_ = rate_ * size; cells(size_); }
  void cells(int size) { if (size > 1) { cells(size - 1); } }
  void suffix(std::string & text) { text = text + "_grid"; }
  int rate() { return rate_; }
  int size_ = 1;
  double rate_ = 2.0;
};
class Base : public rclcpp::Node {
 public:
  Base() : Node("robot") {
    std::string topic = "out";
    fill(this, "topic", topic);
    out_ = create_publisher<std_msgs::msg::String>(topic, 1);
    std::string map = "map";
    grid_.suffix(map);
    map_ = create_publisher<std_msgs::msg::String>(map, 1);
    grid_.resize(4);
    in_ = create_subscription<std_msgs::msg::String>(
      "in", 1, std::bind(&Base::onText, this, std::placeholders::_1));
    timer_ = create_wall_timer(
      std::chrono::duration<double>(1.0 / grid_.rate_), [this]() { grid_.resize(2); tell(); });
  }
  virtual void onText(const std_msgs::msg::String & text) = 0;
  void tell() { out_->publish(text_); }
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr out_, map_;
  rclcpp::Subscription<std_msgs::msg::String>::SharedPtr in_;
  rclcpp::TimerBase::SharedPtr timer_;
  Grid grid_;
};
class Robot : public Base {
 public:
  void onText(const std_msgs::msg::String & text) override { map_->publish(text); }
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  rclcpp::spin(std::make_shared<Robot>());
}
"""


def _node(folder: Path) -> NodeFact:
    (folder / "robot.cpp").write_text(CODE, encoding="utf-8")
    (node,) = read_source(folder).nodes
    return node


def test_routines_give_values_back_by_reference(tmp_path: Path) -> None:
    node = _node(tmp_path)
    assert [each.name for each in node.of("publishers")] == ["out", "map_grid"]
    (timer,) = node.of("timers")
    assert timer.details["period"] == 1 / 8


def test_a_callback_is_that_of_the_class_that_overrides_it(tmp_path: Path) -> None:
    (heard,) = _node(tmp_path).of("subscriptions")
    assert [each.what for each in heard.callbacks["callback"].effects] == ["map_"]


def test_a_large_program_skips_what_has_nothing_to_do_with_ros_and_forgets_what_it_may_change(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(routines, "_LARGE", 0)
    node = _node(tmp_path)
    out, map_ = node.of("publishers")
    (timer,) = node.of("timers")
    assert out.name == "out", "what reads parameters is followed"
    assert is_open(map_.name), "a routine that is skipped may have changed its reference"
    assert is_open(timer.details["period"]), "a routine that is skipped may have changed the member"
    assert [each.do for each in timer.callbacks["callback"].effects] == ["publish"], "publishing is followed"
