"""Methods of objects in lists and maps of C++ have effects, whatever gives the object."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.sources.reading import read_source

PROGRAM = """
#include <map>
#include "rclcpp/rclcpp.hpp"
using Text = std_msgs::msg::String;
struct Worker { virtual ~Worker() = default; virtual void work() = 0; };
struct Left : public Worker {
  explicit Left(rclcpp::Node * node) { out_ = node->create_publisher<Text>("left", 1); }
  void work() override { out_->publish(Text()); }
  rclcpp::Publisher<Text>::SharedPtr out_;
};
struct Right : public Worker {
  explicit Right(rclcpp::Node * node) { out_ = node->create_publisher<Text>("right", 1); }
  void work() override { out_->publish(Text()); }
  rclcpp::Publisher<Text>::SharedPtr out_;
};
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    bool is_left = declare_parameter("is_left", true);
    FILL
    timer_ = create_wall_timer(std::chrono::seconds(1), [this]() { tick(); });
  }
 private:
  void tick() { USE }
  std::unique_ptr<Worker> made(bool is_left) {
    if (is_left) { return std::make_unique<Left>(this); }
    return std::make_unique<Right>(this);
  }
  HELD
  rclcpp::TimerBase::SharedPtr timer_;
};
int main(int argc, char ** argv) { rclcpp::init(argc, argv); rclcpp::spin(std::make_shared<Robot>()); }
"""
PAIRS = """
  workers_.insert(std::pair<int, std::unique_ptr<Worker>>(1, made(is_left)));
  if (!is_left) {
    workers_.insert(std::pair<int, std::unique_ptr<Worker>>(2, std::make_unique<Right>(this)));
  }
"""
MAP = "std::multimap<int, std::unique_ptr<Worker>> workers_;"
ITEMS = """
  if (is_left) { workers_.push_back(std::make_unique<Left>(this)); }
  workers_.push_back(std::make_unique<Right>(this));
"""
LIST = "std::vector<std::unique_ptr<Worker>> workers_;"


@pytest.mark.parametrize(
    ("fill", "held", "use"),
    [
        (
            PAIRS,
            MAP,
            "auto range = workers_.equal_range(1);"
            "for (auto it = range.first; it != range.second; it++) { it->second->work(); }",
        ),
        (PAIRS, MAP, "auto it = workers_.lower_bound(1); if (it != workers_.end()) { it->second->work(); }"),
        (PAIRS, MAP, "for (auto it = workers_.begin(); it != workers_.end(); ++it) { it->second->work(); }"),
        (ITEMS, LIST, "for (size_t i = 0; i < workers_.size(); i++) { workers_[i]->work(); }"),
        (ITEMS, LIST, "(*workers_.rbegin())->work();"),
        (ITEMS, LIST, "workers_.at(index())->work();"),
    ],
)
def test_each_object_that_a_list_may_hold_is_used(tmp_path: Path, fill: str, held: str, use: str) -> None:
    text = PROGRAM.replace("FILL", fill).replace("HELD", held).replace("USE", use)
    (tmp_path / "robot.cpp").write_text(text)
    (node,) = read_source(tmp_path).nodes
    (timer,) = node.of("timers")
    effects = timer.callbacks["callback"].effects
    assert {each.entity.name for each in effects if each.entity is not None} == {"left", "right"}


def test_diagnostics_are_published_at_once(tmp_path: Path) -> None:
    held = "std::unique_ptr<diagnostic_updater::Updater> updater_;"
    fill = "updater_ = std::make_unique<diagnostic_updater::Updater>(this);"
    text = PROGRAM.replace("FILL", fill).replace("HELD", held).replace("USE", "updater_->force_update();")
    (tmp_path / "robot.cpp").write_text(text)
    (node,) = read_source(tmp_path).nodes
    (timer,) = [each for each in node.of("timers") if "via" not in each.details]
    (effect,) = timer.callbacks["callback"].effects
    assert effect.do == "publish"
    assert effect.entity is not None
    assert effect.entity.name == "/diagnostics"


def test_a_camera_publishes_two_topics(tmp_path: Path) -> None:
    held = "image_transport::CameraPublisher camera_;"
    fill = 'camera_ = image_transport::create_camera_publisher(this, "left/image_raw");'
    text = PROGRAM.replace("FILL", fill).replace("HELD", held).replace("USE", "camera_.publish(image, info);")
    (tmp_path / "robot.cpp").write_text(text)
    (node,) = read_source(tmp_path).nodes
    (timer,) = node.of("timers")
    effects = timer.callbacks["callback"].effects
    assert [each.name for each in node.of("publishers")] == ["left/image_raw", "left/camera_info"]
    published = [each.entity.name for each in effects if each.do == "publish" and each.entity is not None]
    assert published == ["left/image_raw", "left/camera_info"]
