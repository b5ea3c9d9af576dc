"""Proofs are under an assumption where the code does not say how many threads there are, and that matters."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.metamodel import sym
from dineros.metamodel.elements import elements
from dineros.observation.importing.building import to_model
from dineros.observation.importing.given import Given, GivenNode
from tests.support.programs.coded import BATTERY, MONITOR, files, read, run

ROBOT = """
import os, sys
class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.out = self.create_publisher(String, "out", 10)
        self.create_timer(1.0, self.tick, callback_group=GROUP)
        self.create_subscription(String, "out", self.hear, 10)
    def tick(self): self.out.publish(String())
    def hear(self, message): pass
def main():
    rclpy.init()
    executor = MultiThreadedExecutor(THREADS)
    executor.add_node(Robot())
    executor.spin()
if __name__ == "__main__": main()
"""
EXCLUSIVE, REENTRANT = "MutuallyExclusiveCallbackGroup()", "ReentrantCallbackGroup()"
OPEN = "num_threads=int(sys.argv[1])"
CPP = """
#include <rclcpp/rclcpp.hpp>
#include <std_msgs/msg/string.hpp>
#include <std_srvs/srv/trigger.hpp>
class Robot : public rclcpp::Node {
 public:
  explicit Robot(const rclcpp::NodeOptions & options = rclcpp::NodeOptions()) : Node("robot", options) {
    one_ = create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive);
    two_ = create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive);
    out_ = create_publisher<std_msgs::msg::String>("out", 10);
    ask_ = create_client<std_srvs::srv::Trigger>("level", rmw_qos_profile_services_default, one_);
    timer_ = create_wall_timer(std::chrono::seconds(1), [this]() { tick(); }, FIRST);
    other_ = create_wall_timer(std::chrono::seconds(1), [this]() { }, SECOND);
  }
  void tick() { TICK }
  rclcpp::CallbackGroup::SharedPtr one_, two_;
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr out_;
  rclcpp::Client<std_srvs::srv::Trigger>::SharedPtr ask_;
  rclcpp::TimerBase::SharedPtr timer_, other_;
};
"""
PUBLISH = "out_->publish(std_msgs::msg::String());"
WAIT = "auto f = ask_->async_send_request(std::make_shared<std_srvs::srv::Trigger::Request>()); f.wait();"
MAIN = """
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  rclcpp::executors::MultiThreadedExecutor executor(rclcpp::ExecutorOptions(), THREADS);
  auto node = std::make_shared<Robot>();
  executor.add_node(node);
  executor.spin();
}
"""
REGISTERED = "#include <rclcpp_components/register_node_macro.hpp>\nRCLCPP_COMPONENTS_REGISTER_NODE(Robot)\n"


def lacks(folder: Path, said: Given | None = None) -> tuple[str, ...]:
    """Return the assumed numbers of threads that matter."""
    found = read(folder)
    return found.lacks_of_threads(found.with_people(said or Given()))


def robot(folder: Path, group: str, threads: str) -> Path:
    return files(folder, robot=ROBOT.replace("GROUP", group).replace("THREADS", threads))


@pytest.mark.parametrize(
    ("group", "threads", "said"),
    [
        ("None", OPEN, ""),
        ("None", "", ""),
        (EXCLUSIVE, "2", ""),
        (EXCLUSIVE, OPEN, "the number of threads is open: sys.argv[1]; 1 is assumed for node /robot"),
        (EXCLUSIVE, "", "as many threads as processors; 4 are assumed for node /robot"),
        (EXCLUSIVE, "os.cpu_count()", "as many threads as processors; 4 are assumed for node /robot"),
        (REENTRANT, OPEN, "the number of threads is open: sys.argv[1]; 1 is assumed for node /robot"),
    ],
)
def test_in_python(tmp_path: Path, group: str, threads: str, said: str) -> None:
    """With one exclusive group, a second thread never has anything to do."""
    found = lacks(robot(tmp_path, group, threads))
    assert [each.partition(": ")[2] for each in found] == ([said] if said else [])
    assert all(each.startswith("src/robot.py:") for each in found)


def test_a_client_in_python_has_callbacks_in_no_group(tmp_path: Path) -> None:
    text = MONITOR.replace("GROUP", "").replace("num_threads=2", "")
    assert len(lacks(files(tmp_path, battery=BATTERY, monitor=text))) == 1


@pytest.mark.parametrize(
    ("first", "second", "does", "threads", "matters"),
    [
        ("one_", "one_", PUBLISH, "n", False),
        ("one_", "two_", PUBLISH, "n", True),
        ("one_", "two_", PUBLISH, "3", False),
        ("one_", "two_", PUBLISH, "0", False),  # as many as processors, and at least two
        ("two_", "nullptr", PUBLISH, "0", True),
        ("one_", "one_", WAIT, "n", False),
        ("one_", "two_", WAIT, "0", False),
    ],
)
def test_in_cpp(tmp_path: Path, first: str, second: str, does: str, threads: str, matters: bool) -> None:
    text = CPP.replace("FIRST", first).replace("SECOND", second).replace("TICK", does)
    main = MAIN.replace("THREADS", threads).replace(
        "rclcpp::init", "int n = std::stoi(argv[1]); rclcpp::init"
    )
    (tmp_path / "robot.cpp").write_text(text + main)
    assert bool(lacks(tmp_path)) is matters


@pytest.mark.parametrize(
    ("second", "does", "matters"), [("one_", PUBLISH, False), ("two_", PUBLISH, True), ("one_", WAIT, True)]
)
def test_the_container_of_a_component_may_have_threads_and_other_nodes(
    tmp_path: Path, second: str, does: str, matters: bool
) -> None:
    text = CPP.replace("FIRST", "one_").replace("SECOND", second).replace("TICK", does)
    (tmp_path / "robot.cpp").write_text(text + REGISTERED)
    words = [each.partition(": ")[2] for each in lacks(tmp_path)]
    said = "the number of threads is open: a component: its container decides; 1 is assumed for node /robot"
    assert words == ([said] if matters else [])


def test_a_given_number_is_not_assumed(tmp_path: Path) -> None:
    source = robot(tmp_path, EXCLUSIVE, OPEN)
    said = Given({"/robot": GivenNode(threads=3)})
    assert lacks(source) and not lacks(source, said)
    found = read(source)
    for given, mark, threads in ((found.given, "executor", 1), (found.with_people(said), None, 3)):
        model = to_model(found.system, given).model
        (net,) = (each for each in elements(model) if isinstance(each, sym.NodeNet) and each.id == "robot")
        assert (net.assumed, net.threads) == (mark, threads)


@pytest.mark.parametrize(("threads", "is_proved"), [("2", True), (OPEN, False), ("", False)])
def test_what_check_proves_rests_on_the_number(tmp_path: Path, threads: str, is_proved: bool) -> None:
    source = robot(tmp_path, EXCLUSIVE, threads)
    _, out = run("check", "--source", source, "--json", "--timeout", 60)
    told = json.loads(out)
    assert bool(told["proved"]) is is_proved
    assert bool(told.get("assumed")) is not is_proved


@pytest.mark.parametrize(
    ("threads", "said"),
    [("1", "the only thread,"), (OPEN, "the only thread (that it has one is assumed),")],
)
def test_a_deadlock_for_want_of_a_thread_says_that_the_number_is_assumed(
    tmp_path: Path, threads: str, said: str
) -> None:
    text = MONITOR.replace("GROUP", f", callback_group={EXCLUSIVE}").replace("num_threads=2", threads)
    source = files(tmp_path, battery=BATTERY, monitor="import sys\n" + text)
    told = json.loads(run("check", "--source", source, "--json", "--timeout", 60)[1])
    (found,) = (each["message"] for each in told["findings"] if each["rule"] == "callback-deadlock")
    assert f"needs {said} which monitor.on_tick itself holds" in found
