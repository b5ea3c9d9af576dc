"""A callback of a response that waits for another response holds its group in rclcpp, and none in rclpy."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.metamodel import sym
from dineros.metamodel.elements import channels, elements
from dineros.metamodel.files import load, save
from tests.support.programs.coded import BATTERY, MONITOR, files, model_of, run

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


OWN = "MutuallyExclusiveCallbackGroup()"
OPEN = f"{OWN} if len(sys.argv) > 1 else None"


def monitor(client: str, timer: str = "None", threads: int = 2) -> str:
    """Return the program of a node whose timer callback calls a service, with the groups of both."""
    text = MONITOR.replace("GROUP", f", callback_group={client}").replace(
        "num_threads=2", f"num_threads={threads}"
    )
    return "import sys\n" + text.replace("self.tick)", f"self.tick, callback_group={timer})")


@pytest.mark.parametrize(
    ("client", "timer", "assumed"),
    [
        ("None", "None", []),
        (OPEN, "None", ["that client monitor.on_tick of service /level"]),
        ("None", OPEN, ["that timer callback monitor.on_tick"]),
        (
            OPEN,
            OPEN,
            ["that timer callback monitor.on_tick", "that client monitor.on_tick of service /level"],
        ),
    ],
)
def test_a_deadlock_because_of_an_assumed_group_says_so(
    tmp_path: Path, client: str, timer: str, assumed: list[str]
) -> None:
    """Which group it is depends on how the program is started; only the default group leads to a deadlock."""
    (found,) = deadlocks(files(tmp_path, battery=BATTERY, monitor=monitor(client, timer)))
    first, *said = found.split("; that ")
    assert first.endswith("the response needs the default callback group, which monitor.on_tick itself holds")
    assert said == [f"{each.removeprefix('that ')} is in this callback group is assumed" for each in assumed]


def test_a_deadlock_because_of_threads_does_not_rest_on_an_assumed_group(tmp_path: Path) -> None:
    (found,) = deadlocks(files(tmp_path, battery=BATTERY, monitor=monitor(OPEN, OWN, 1)))
    assert found.endswith("the response needs the only thread, which monitor.on_tick itself holds")


@pytest.mark.parametrize(("group", "proved"), [(OWN, True), (OPEN, False)])
def test_nothing_is_proved_without_assumption_if_a_group_is_open(
    tmp_path: Path, group: str, proved: bool
) -> None:
    """In the group that the program chooses, other callbacks may wait."""
    source = files(tmp_path, battery=BATTERY, monitor=monitor(OWN, group))
    told = json.loads(run("check", "--source", source, "--json", "--timeout", 60)[1])
    assert [each for each in told["findings"] if each["severity"] == "error"] == []
    assert "every callback that has begun can end" in told["proved" if proved else "assumed"]
    assert bool(told["proved"]) is proved


def test_a_group_that_a_user_gives_is_not_assumed(tmp_path: Path) -> None:
    source = files(tmp_path, battery=BATTERY, monitor=monitor(OPEN))
    given = tmp_path / "robot.given.toml"
    given.write_text('[node."/monitor"]\ngroups = {calls = "exclusive"}\ncallback."/level".group = "calls"\n')
    status, text = run("check", "--source", source, "--given", given, "--timeout", 60)
    assert (status, "callback-deadlock" in text) == (0, False)


def test_an_assumed_group_of_a_client_outlives_pnml(tmp_path: Path) -> None:
    model, other = tmp_path / "robot.sym.xmi", tmp_path / "robot.pnml"
    save(model_of(files(tmp_path, battery=BATTERY, monitor=monitor(OPEN))), model)
    save(load(model), other)
    (service,) = channels(load(other), sym.ServiceChannel)
    assert [client.assumed for client in service.clients] == ["group"]
