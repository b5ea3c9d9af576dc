"""A callback of a response that waits for another response holds its group in rclcpp, and none in rclpy."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.metamodel import sym
from dineros.metamodel.elements import elements
from tests.support.programs.coded import files, model_of, run

HEAD = """
#include <rclcpp/rclcpp.hpp>
#include <std_srvs/srv/trigger.hpp>
using Trigger = std_srvs::srv::Trigger;
"""
CPP = {
    "Server": """
class Server : public rclcpp::Node {
 public:
  Server() : Node("server") {
    one_ = create_service<Trigger>("one", std::bind(&Server::serve, this, _1, _2));
    two_ = create_service<Trigger>("two", std::bind(&Server::serve, this, _1, _2));
  }
  void serve(const Trigger::Request::SharedPtr, Trigger::Response::SharedPtr) {}
  rclcpp::Service<Trigger>::SharedPtr one_, two_;
};
""",
    "Robot": """
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    group_ = create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive);
    one_ = create_client<Trigger>("one");
    two_ = create_client<Trigger>("two"GROUP);
    timer_ = create_wall_timer(std::chrono::seconds(1), [this]() { tick(); });
  }
  void tick() {
    one_->async_send_request(std::make_shared<Trigger::Request>(),
      [this](rclcpp::Client<Trigger>::SharedFuture) { answered(); });
  }
  void answered() {
    auto future = two_->async_send_request(std::make_shared<Trigger::Request>());
    future.get();
  }
  rclcpp::CallbackGroup::SharedPtr group_;
  rclcpp::Client<Trigger>::SharedPtr one_, two_;
  rclcpp::TimerBase::SharedPtr timer_;
};
""",
}
MAIN = """
int main() {
  rclcpp::init(0, nullptr);
  rclcpp::executors::MultiThreadedExecutor executor(rclcpp::ExecutorOptions(), 2);
  auto node = std::make_shared<%s>();
  executor.add_node(node);
  executor.spin();
}
"""
PYTHON = {
    "Robot": """
class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.one = self.create_client(Trigger, "one")
        self.two = self.create_client(Trigger, "two")
        self.create_timer(1.0, self.tick)
    def tick(self):
        self.one.call_async(Trigger.Request()).add_done_callback(self.answered)
    def answered(self, future):
        self.two.call(Trigger.Request())
""",
    "Server": """
class Server(Node):
    def __init__(self):
        super().__init__("server")
        self.create_service(Trigger, "one", self.serve)
        self.create_service(Trigger, "two", self.serve)
    def serve(self, request, response): return response
""",
}
PYTHON_MAIN = """
def main():
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=2)
    node = %s()
    executor.add_node(node)
    executor.spin()
if __name__ == "__main__": main()
"""


def cpp(folder: Path, group: str) -> Path:
    for name in ("Robot", "Server"):
        (folder / f"{name}.cpp").write_text(HEAD + CPP[name].replace("GROUP", group) + MAIN % name)
    return folder


def deadlocks(folder: Path) -> list[str]:
    told = json.loads(run("check", "--source", folder, "--json", "--timeout", 60)[1])
    return [each["message"] for each in told["findings"] if each["rule"] == "callback-deadlock"]


@pytest.mark.parametrize(
    ("group", "is_stuck"), [("", True), (", rmw_qos_profile_services_default, group_", False)]
)
def test_a_callback_of_a_response_in_cpp_holds_the_group_of_its_client(
    tmp_path: Path, group: str, is_stuck: bool
) -> None:
    model = model_of(cpp(tmp_path, group))
    groups = {
        page.group.id
        for page in elements(model)
        if isinstance(page, sym.CallbackPage)
        and page.kind == sym.CallbackKind.client
        and page.group is not None
    }
    assert "robot.default_group" in groups
    found = deadlocks(tmp_path)
    assert len(found) == is_stuck
    assert all("default_group" in each for each in found)


def test_a_done_callback_in_python_holds_none(tmp_path: Path) -> None:
    source = files(
        tmp_path, **{name.lower(): PYTHON[name] + PYTHON_MAIN % name for name in ("Robot", "Server")}
    )
    model = model_of(source)
    pages = [each for each in elements(model) if isinstance(each, sym.CallbackPage)]
    assert any(page.kind == sym.CallbackKind.client for page in pages)
    assert all(page.group is None for page in pages)
    (found,) = deadlocks(source)
    assert "threads" in found and "group" not in found, "several done callbacks can hold both threads"
