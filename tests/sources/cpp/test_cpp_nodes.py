"""Nodes in C++: what their code says, and what it leaves open."""

from pathlib import Path
from textwrap import dedent

import pytest

from dineros.sources.facts import Facts
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

ROBOT = """
#include <rclcpp/rclcpp.hpp>
using namespace std::chrono_literals;
class Robot : public rclcpp::Node {
 public:
  explicit Robot(const rclcpp::NodeOptions & options) : Node("robot", options), rate_(4) {
    declare_parameter("topic", "scan");
    group_ = create_callback_group(rclcpp::CallbackGroupType::Reentrant);
    pub_ = create_publisher<std_msgs::msg::String>(
      get_parameter("topic").as_string() + "/out", rclcpp::QoS(7).transient_local());
    client_ = create_client<std_srvs::srv::Trigger>("reset");
    timer_ = create_wall_timer(
      std::chrono::milliseconds(1000 / rate_), std::bind(&Robot::tick, this), group_);
    sub_ = create_subscription<std_msgs::msg::String>("in", rclcpp::SensorDataQoS(),
      [this](std_msgs::msg::String::SharedPtr msg) { if (msg) { pub_->publish(*msg); } });
  }
 private:
  void tick() { help(); auto answer = client_->async_send_request(request_); answer.wait(); }
  void help() { rclcpp::sleep_for(2s); }
  int rate_;
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  rclcpp::executors::MultiThreadedExecutor executor(rclcpp::ExecutorOptions(), 3);
  auto node = std::make_shared<Robot>(rclcpp::NodeOptions());
  executor.add_node(node);
  executor.spin();
}
"""


def _read(folder: Path, text: str) -> Facts:
    (folder / "robot.cpp").write_text(dedent(text))
    return read_source(folder)


def test_a_node_has_its_ports_timers_and_threads(tmp_path: Path) -> None:
    (node,) = [each.to_json() for each in _read(tmp_path, ROBOT).nodes]
    assert (node["name"], node["threads"]) == ("robot", 3)
    (pub,), (sub,), (timer,) = node["publishers"], node["subscriptions"], node["timers"]
    assert (pub["name"], pub["type"], pub["depth"]) == ("scan/out", "std_msgs/msg/String", 7)
    assert (pub["durability"], sub["reliability"]) == ("transient_local", "best_effort")
    assert (timer["period"], timer["callback"], timer["group"]) == (0.25, "tick", "group_")


def test_effects_are_found_through_helpers(tmp_path: Path) -> None:
    (node,) = [each.to_json() for each in _read(tmp_path, ROBOT).nodes]
    effects = {each["name"]: each["effects"] for each in node["callbacks"]}
    assert [each["do"] for each in effects["tick"]] == ["sleep", "call"]
    assert effects["tick"][1]["how"] == "blocks, without time-out"
    assert [(each["do"], each["when"]) for each in effects["lambda"]] == [("publish", "conditional")]


def test_a_name_that_is_not_known_is_open(tmp_path: Path) -> None:
    text = ROBOT.replace('get_parameter("topic").as_string()', "from_elsewhere()")
    (node,) = [each.to_json() for each in _read(tmp_path, text).nodes]
    assert "{" in node["publishers"][0]["name"] or node["publishers"][0]["name"].startswith("open")


def test_a_managed_node_makes_its_ports_in_transitions(tmp_path: Path) -> None:
    text = """
    class Managed : public rclcpp_lifecycle::LifecycleNode {
     public:
      Managed() : LifecycleNode("managed") {}
      CallbackReturn on_configure(const rclcpp_lifecycle::State &) {
        pub_ = create_publisher<std_msgs::msg::String>("out", 10);
        return CallbackReturn::SUCCESS;
      }
      CallbackReturn on_activate(const rclcpp_lifecycle::State &) { pub_->publish(message_); }
    };
    """
    (node,) = _read(tmp_path, text).nodes
    assert node.managed and [each.name for each in node.of("publishers")] == ["out"]
    assert [each.do for fact in node.callbacks for each in fact.effects] == ["publish"]


def test_each_turn_of_a_loop_makes_a_port(tmp_path: Path) -> None:
    loop = """
      std::vector<std::string> names{"a", "b"};
      for (auto & name : names) { all_.push_back(create_client<std_srvs::srv::Trigger>(name)); }
    """
    first = 'declare_parameter("topic", "scan");'
    (node,) = _read(tmp_path, ROBOT.replace(first, first + loop)).nodes
    assert [each.name for each in node.of("clients")] == ["a", "b", "reset"]


@pytest.mark.parametrize("text", ["(" * 100_000, "int main() { " + "-" * 5000 + "1; }"])
def test_hostile_code_ends(tmp_path: Path, text: str) -> None:
    assert _read(tmp_path, text).nodes == []
