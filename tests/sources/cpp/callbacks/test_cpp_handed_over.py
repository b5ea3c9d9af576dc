"""Code in C++ that only other packages call: functions that they receive, and methods that they override."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.sources.reading import read_source

PROGRAM = """
#include <rclcpp/rclcpp.hpp>
#include <driver/driver.hpp>
using Text = std_msgs::msg::String;
class Robot : public rclcpp::Node BASES {
 public:
  Robot() : Node("robot") INITIALISERS {
    out_ = create_publisher<Text>("out", 10);
    other_ = create_publisher<Text>("other", 10);
    BODY
  }
 private:
  void on_button(const Button &) { out_->publish(Text()); }
  static int on_scan(Handle * handle, Scan scan, void * user) {
    Robot * robot = static_cast<Robot *>(user);
    robot->out_->publish(Text());
    return 0;
  }
  static void on_image(void * user, Image &) {
    auto robot = reinterpret_cast<Robot *>(user);
    robot->out_->publish(Text());
  }
  MEMBERS
  driver::Driver driver_;
  Handle handle_;
  rclcpp::Publisher<Text>::SharedPtr out_, other_;
};
AFTER
int main() { rclcpp::init(0, nullptr); rclcpp::spin(std::make_shared<Robot>()); }
"""


def published(folder: Path, **parts: str) -> set[str]:
    """Return the topics on which the callbacks of the node publish."""
    text = PROGRAM
    for name in ("BASES", "INITIALISERS", "BODY", "MEMBERS", "AFTER"):
        text = text.replace(name, parts.get(name.lower(), ""))
    (folder / "robot.cpp").write_text(text)
    (node,) = read_source(folder).nodes
    effects = [effect for each in node.callbacks for effect in each.effects if effect.do == "publish"]
    return {effect.entity.name for effect in effects if effect.entity is not None}


@pytest.mark.parametrize(
    "parts",
    [
        {
            "initialisers": ", slot_(&Robot::on_button, *this)",
            "members": "ecl::Slot<const Button &> slot_;",
        },
        {"body": "driver_set_callback(&handle_, on_scan, this);"},
        {"body": "driver_set_callback(&handle_, &Robot::on_scan, this);"},
        {"body": "driver_.registerHandler(this, Robot::on_image);"},
    ],
)
def test_a_function_that_unknown_code_receives_with_its_object_is_read(
    tmp_path: Path, parts: dict[str, str]
) -> None:
    assert published(tmp_path, **parts) == {"out"}


def test_a_function_without_its_object_is_not_read(tmp_path: Path) -> None:
    assert published(tmp_path, body="driver_set_callback(&handle_, on_scan, nullptr);") == set()


METHOD = "void run() override { work(); } void work() { out_->publish(Text()); }"


@pytest.mark.parametrize(
    ("bases", "members", "after"),
    [
        (", public driver::Thread", METHOD, ""),
        (", public driver::Thread", "void run() override;", "void Robot::run() { out_->publish(Text()); }"),
        (", public driver::Handler<Scan>", "void on_scan_of_driver(Scan s) { out_->publish(Text()); }", ""),
    ],
)
def test_a_method_that_only_a_base_class_of_another_package_can_call_is_read(
    tmp_path: Path, bases: str, members: str, after: str
) -> None:
    assert published(tmp_path, bases=bases, members=members, after=after) == {"out"}


def test_without_such_a_base_class_dead_code_is_not_read(tmp_path: Path) -> None:
    assert published(tmp_path, members="void run() { out_->publish(Text()); }") == set()


def test_a_subclass_of_a_thread_of_the_standard_library_runs(tmp_path: Path) -> None:
    after = """
class Worker : public std::thread {
 public:
  explicit Worker(Robot * robot) : std::thread([this] { this->run(); }), robot_(robot) {}
  void run() { robot_->work(); }
  Robot * robot_;
};
void Robot::start() { worker_ = new Worker(this); }
"""
    members = "void start(); void work() { out_->publish(Text()); } Worker * worker_;"
    assert published(tmp_path, body="start();", members=members, after=after) == {"out"}


@pytest.mark.parametrize("method", ["try_publish(Text())", "tryPublish(Text())", "unlockAndPublish()"])
def test_a_publisher_of_real_time_code_publishes_for_the_one_that_it_gets(
    tmp_path: Path, method: str
) -> None:
    body = f"""
    fast_ = std::make_shared<realtime_tools::RealtimePublisher<Text>>(out_);
    timer_ = create_wall_timer(std::chrono::seconds(1), [this]() {{ fast_->{method}; }});
"""
    members = (
        "std::shared_ptr<realtime_tools::RealtimePublisher<Text>> fast_; rclcpp::TimerBase::SharedPtr timer_;"
    )
    assert published(tmp_path, body=body, members=members) == {"out"}
