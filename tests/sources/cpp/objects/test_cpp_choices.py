"""Values that are one of several: choices among choices, and members that code computes again and again."""

from pathlib import Path

import pytest

from dineros.sources.cpp.values import Const, Either, one_of
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

CODE = """
#include <rclcpp/rclcpp.hpp>
class Filter {
 public:
  virtual double next(double old) = 0;
};
class Slow : public Filter {
 public:
  double next(double old) override { return flag_ ? old * gain_ + old * (1 - gain_) : gain_; }
  bool flag_;
  double gain_ = 0.5;
};
class Quick : public Filter {
 public:
  double next(double old) override { return flag_ ? old + 2.0 : old * 0.25; }
  bool flag_;
};
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    if (declare_parameter("slow", get_clock()->now().nanoseconds() > 0)) {
      filter_ = std::make_unique<Slow>();
    } else {
      filter_ = std::make_unique<Quick>();
    }
    out_ = create_publisher<std_msgs::msg::String>("out", 1);
    timer_ = create_wall_timer(std::chrono::seconds(1), [this]() { tick(); });
  }
  void tick() {
    STEPS
    out_->publish(std_msgs::msg::String());
  }
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr out_;
  rclcpp::TimerBase::SharedPtr timer_;
  std::unique_ptr<Filter> filter_;
  double level_ = 0.0;
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  rclcpp::spin(std::make_shared<Robot>());
}
"""


def test_choices_contain_no_choices() -> None:
    inner = Either((Const("a"), Const("b")))
    assert Either((inner, Const("b"), Either((inner, Const("c"))))).options == tuple(map(Const, "abc"))
    assert one_of([inner, inner]) == inner
    assert one_of([Const("a"), Const("a")]) == Const("a")


@pytest.mark.parametrize("steps", [2, 40])
def test_a_member_that_is_computed_again_and_again(tmp_path: Path, steps: int) -> None:
    (tmp_path / "robot.cpp").write_text(CODE.replace("STEPS", "level_ = filter_->next(level_);\n" * steps))
    (node,) = read_source(tmp_path).nodes
    (tick,) = [each for each in node.callbacks if each.kind == "timer"]
    assert [(each.do, each.what) for each in tick.effects] == [("publish", "out_")]
