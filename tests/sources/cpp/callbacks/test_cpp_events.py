"""Callbacks of events and of parameters in C++, which make ports on demand or use them."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.sources.facts import NodeFact
from dineros.sources.reading import read_source

PROGRAM = """
#include <rclcpp/rclcpp.hpp>
using Text = std_msgs::msg::String;
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
BODY
  }
  void on_text(Text::SharedPtr) { out_->publish(Text()); }
  void on_pair(sensor_msgs::msg::Image::ConstSharedPtr, sensor_msgs::msg::CameraInfo::ConstSharedPtr) {
    out_->publish(Text());
  }
  rcl_interfaces::msg::SetParametersResult on_parameters(const std::vector<rclcpp::Parameter> &) {
    out_->publish(Text());
    return rcl_interfaces::msg::SetParametersResult();
  }
  rclcpp::Publisher<Text>::SharedPtr out_;
  rclcpp::Subscription<Text>::SharedPtr in_;
  image_transport::SubscriberFilter image_;
  message_filters::Subscriber<sensor_msgs::msg::CameraInfo> info_;
  using Sync = message_filters::TimeSynchronizer<sensor_msgs::msg::Image, sensor_msgs::msg::CameraInfo>;
  std::shared_ptr<Sync> sync_;
  rclcpp::node_interfaces::OnSetParametersCallbackHandle::SharedPtr handle_;
};
int main() { rclcpp::init(0, nullptr); rclcpp::spin(std::make_shared<Robot>()); }
"""
MATCHED = """
    rclcpp::PublisherOptions options;
    options.event_callbacks.matched_callback = [this](rclcpp::MatchedInfo & s) {
      if (s.current_count == 0) {
        in_.reset();
      } else if (!in_) {
        DEMAND
      }
    };
    out_ = create_publisher<Text>("out", 10, options);
"""
SYNC = """
    sync_ = std::make_shared<Sync>(image_, info_, 5);
    sync_->registerCallback(std::bind(&Robot::on_pair, this, std::placeholders::_1, std::placeholders::_2));
"""
LATER = """
    sync_ = std::make_shared<Sync>(5);
    sync_->registerCallback(std::bind(&Robot::on_pair, this, std::placeholders::_1, std::placeholders::_2));
    sync_->connectInput(image_, info_);
"""
SUBSCRIBE = """
        auto base = this->get_node_base_interface();
        std::string topic = base->resolve_topic_or_service_name("left/image_rect", false);
        image_.subscribe(this, topic, "raw");
        info_.subscribe(this, image_transport::getCameraInfoTopic(topic));
"""


def robot(folder: Path, body: str) -> NodeFact:
    (folder / "robot.cpp").write_text(PROGRAM.replace("BODY", body))
    (node,) = read_source(folder).nodes
    return node


def published(node: NodeFact, name: str) -> list[str]:
    """Return what the callbacks of a name publish on."""
    found = [each for each in node.callbacks if each.name == name]
    return [effect.entity.name for each in found for effect in each.effects if effect.entity is not None]


def test_a_subscription_on_demand_is_read(tmp_path: Path) -> None:
    demand = 'in_ = create_subscription<Text>("in", 5, [this](Text::SharedPtr text) { on_text(text); });'
    node = robot(tmp_path, MATCHED.replace("DEMAND", demand))
    (entity,) = node.of("subscriptions")
    assert (entity.name, entity.details["depth"], "conditional" in entity.details) == ("in", 5, True)
    assert [effect.do for effect in entity.callbacks["callback"].effects] == ["publish"]


@pytest.mark.parametrize("sync", [SYNC, LATER])
def test_filters_that_subscribe_on_demand_have_the_callback_of_their_synchronizer(
    tmp_path: Path, sync: str
) -> None:
    """The topic of a camera's parameters is that of its images, with another last part."""
    node = robot(tmp_path, sync + MATCHED.replace("DEMAND", SUBSCRIBE))
    found = {each.name: each.callbacks["callback"].name for each in node.of("subscriptions")}
    assert found == {"left/image_rect": "on_pair", "left/camera_info": "on_pair"}
    assert set(published(node, "on_pair")) == {"out"}


def test_what_a_disabled_branch_sets_is_known_in_it_after_an_early_end(tmp_path: Path) -> None:
    """A constructor that throws if its parameters are wrong goes on to code that the default disables."""
    body = f"""
    if (!get_parameter("name", name_)) {{ throw std::runtime_error("no name"); }}
    if (declare_parameter("paired", false)) {{ {SYNC} {SUBSCRIBE} }}
    """
    node = robot(tmp_path, body)
    assert {each.callbacks["callback"].name for each in node.of("subscriptions")} == {"on_pair"}


@pytest.mark.parametrize(
    "method",
    ["add_on_set_parameters_callback", "add_pre_set_parameters_callback", "add_post_set_parameters_callback"],
)
def test_what_a_callback_of_parameters_does_is_read(tmp_path: Path, method: str) -> None:
    made = 'out_ = create_publisher<Text>("out", 10);'
    told = f"handle_ = {method}(std::bind(&Robot::on_parameters, this, std::placeholders::_1));"
    node = robot(tmp_path, f"{made}\n{told}")
    assert published(node, "on_parameters") == ["out"]
    assert [each.kind for each in node.callbacks if each.name == "on_parameters"] == ["parameters"]


def test_a_quality_that_depends_on_the_running_graph_is_open(tmp_path: Path) -> None:
    body = """
    auto infos = get_publishers_info_by_topic("in");
    rclcpp::QoS qos = infos.size() ? infos[0].qos_profile() : rclcpp::SensorDataQoS();
    auto other = infos[0].qos_profile();
    if (infos.empty()) { other = rclcpp::SensorDataQoS(); }
    out_ = create_publisher<Text>("out", qos);
    in_ = create_subscription<Text>("in", other, [this](Text::SharedPtr text) { on_text(text); });
    """
    node = robot(tmp_path, body)
    for entity in (*node.of("publishers"), *node.of("subscriptions")):
        assert str(entity.details["reliability"]).startswith("open: "), entity.name
