"""Programs in C++ whose timer asks a service in an unusual way."""

from __future__ import annotations

from pathlib import Path

from dineros.sources.facts import Effect
from dineros.sources.reading import read_source

_PROGRAM = """
#include <rclcpp/rclcpp.hpp>
#include <std_srvs/srv/trigger.hpp>
using namespace std::chrono_literals;
using Trigger = std_srvs::srv::Trigger;
BEFORE
class Robot : public rclcpp::Node BASES {
 public:
  Robot() : Node("robot") {
    client_ = create_client<Trigger>("battery");
    INIT
    timer_ = create_wall_timer(1s, [this]() { tick(); });
  }
  void ask() {
    auto future = client_->async_send_request(std::make_shared<Trigger::Request>());
    future.get();
  }
  void tick() { TICK }
  MEMBERS
  rclcpp::Client<Trigger>::SharedPtr client_;
  rclcpp::TimerBase::SharedPtr timer_;
};
AFTER
int main(int argc, char ** argv) { rclcpp::init(argc, argv); rclcpp::spin(std::make_shared<Robot>()); }
"""


def asked_by_timer(folder: Path, parts: dict[str, str]) -> list[Effect]:
    """Return the requests of a timer's callback that wait for the response; nothing may be left unread."""
    text = _PROGRAM
    for name in ("before", "bases", "init", "tick", "members", "after"):
        text = text.replace(name.upper(), parts.get(name, ""))
    (folder / "robot.cpp").write_text(text, encoding="utf-8")
    facts = read_source(folder)
    assert facts.unread == []
    (node,) = facts.nodes
    (timer,) = node.of("timers")
    effects = timer.callbacks["callback"].effects
    return [each for each in effects if each.do == "call" and each.how == "blocks, without time-out"]
