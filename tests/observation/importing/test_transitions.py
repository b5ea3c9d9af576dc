"""Callbacks that services of the library run: at any time, in the default group of their node."""

from __future__ import annotations

from pathlib import Path
from textwrap import dedent

import pytest

from dineros.observation.findings.code import code_findings
from dineros.observation.importing.coded import Coded, coded
from dineros.sources.reading import read_source

PYTHON = """
import rclpy, time
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from std_srvs.srv import Trigger
from std_msgs.msg import String

class Driver(LifecycleNode):
    def __init__(self):
        super().__init__("driver")
        self.client = self.create_client(Trigger, "power")
        self.pub = self.create_publisher(String, "state", 10)
    def on_configure(self, state):
        CONFIGURE
        return TransitionCallbackReturn.SUCCESS
    def on_activate(self, state):
        self.pub.publish(String())
        return super().on_activate(state)
    def on_cleanup(self, state):
        return TransitionCallbackReturn.SUCCESS

rclpy.init()
rclpy.spin(Driver())
"""
CPP = """
#include <rclcpp/rclcpp.hpp>
#include <rclcpp_lifecycle/lifecycle_node.hpp>
using Return = rclcpp_lifecycle::node_interfaces::LifecycleNodeInterface::CallbackReturn;
class Driver : public rclcpp_lifecycle::LifecycleNode {
 public:
  Driver() : LifecycleNode("driver") {
    client_ = create_client<std_srvs::srv::Trigger>("power");
    pub_ = create_publisher<std_msgs::msg::String>("state", 10);
  }
  Return on_configure(const rclcpp_lifecycle::State &) override { CONFIGURE return Return::SUCCESS; }
  Return on_activate(const rclcpp_lifecycle::State &) override {
    pub_->publish(std_msgs::msg::String());
    return Return::SUCCESS;
  }
  Return on_cleanup(const rclcpp_lifecycle::State &) override { return Return::SUCCESS; }
  rclcpp::Client<std_srvs::srv::Trigger>::SharedPtr client_;
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr pub_;
};
int main() { rclcpp::init(0, nullptr); rclcpp::spin(std::make_shared<Driver>()->get_node_base_interface()); }
"""
CALLS = {
    "driver.py": "self.client.call(Trigger.Request())",
    "driver.cpp": "client_->async_send_request(std::make_shared<std_srvs::srv::Trigger::Request>()).wait();",
}
MANAGER = """
import rclpy
from rclpy.node import Node
from lifecycle_msgs.srv import ChangeState

class Manager(Node):
    def __init__(self):
        super().__init__("manager")
        self.client = self.create_client(ChangeState, "/driver/change_state")
        self.create_timer(1.0, self.tick)
    def tick(self):
        self.client.call_async(ChangeState.Request())

rclpy.init()
rclpy.spin(Manager())
"""


def read(folder: Path, file: str, configure: str) -> Coded:
    if file.endswith("cpp"):
        pytest.importorskip("tree_sitter_cpp")
    text = PYTHON if file.endswith("py") else CPP
    (folder / file).write_text(dedent(text).replace("CONFIGURE", configure))
    return coded([(".", read_source(folder))], "test")


@pytest.mark.parametrize("file", CALLS)
def test_transitions_that_do_something_are_callbacks(tmp_path: Path, file: str) -> None:
    driver = read(tmp_path, file, CALLS[file]).given.nodes["/driver"]
    assert set(driver.timers or ()) == {"configure", "activate"} == set(driver.open_timers)
    (call,) = driver.callbacks["configure"].does or ()
    assert call.verb == "call" and driver.callbacks["configure"].group in (None, "default_group")
    assert [each.verb for each in driver.callbacks["activate"].does or ()] == ["publish"]


@pytest.mark.parametrize(("configure", "is_lacking"), [(CALLS["driver.py"], True), ("pass", False)])
def test_a_transition_that_waits_while_its_client_waits_is_named(
    tmp_path: Path, configure: str, is_lacking: bool
) -> None:
    (tmp_path / "manager.py").write_text(MANAGER)
    lacks = read(tmp_path, "driver.py", configure).lacks
    assert any("/manager requests transitions of /driver" in each for each in lacks) is is_lacking


@pytest.mark.parametrize(
    ("configure", "rule"),
    [
        ("time.sleep(3)", "code-sleeps"),
        ("self.client.wait_for_service()", "code-waits"),
        ("rclpy.spin_until_future_complete(self, self.client.call_async(Trigger.Request()))", "code-spins"),
    ],
)
def test_a_transition_holds_others_up(tmp_path: Path, configure: str, rule: str) -> None:
    read(tmp_path, "driver.py", configure)
    found = code_findings([(".", read_source(tmp_path))])
    assert [(each.rule, each.elements) for each in found] == [(rule, ("driver", "on_configure"))]


TUNER = """
import rclpy
from rclpy.node import Node
from rclpy.parameter_client import AsyncParameterClient
from rcl_interfaces.msg import SetParametersResult
from std_srvs.srv import Trigger

class Tuner(Node):
    def __init__(self):
        super().__init__("tuner")
        self.apply = self.create_client(Trigger, "apply")
        self.others = AsyncParameterClient(self, "motor")
        self.add_on_set_parameters_callback(self.on_set)
        self.create_timer(1.0, self.tick)
    def on_set(self, parameters):
        ON_SET
        return SetParametersResult(successful=True)
    def tick(self):
        self.others.get_parameters(["gain"])

rclpy.init()
rclpy.spin(Tuner())
"""


@pytest.mark.parametrize(("on_set", "is_callback"), [("self.apply.call(None)", True), ("pass", False)])
def test_what_checks_new_parameters_is_a_callback(tmp_path: Path, on_set: str, is_callback: bool) -> None:
    (tmp_path / "tuner.py").write_text(TUNER.replace("ON_SET", on_set))
    tuner = coded([(".", read_source(tmp_path))], "test").given.nodes["/tuner"]
    assert set(tuner.timers or ()) == ({"set", "tick"} if is_callback else {"tick"})
    if is_callback:
        assert [each.verb for each in tuner.callbacks["set"].does or ()] == ["call"]
        assert tuner.callbacks["set"].group is None and tuner.open_timers == {"set"}


def test_clients_of_a_library_that_nothing_uses_are_left_out(tmp_path: Path) -> None:
    (tmp_path / "tuner.py").write_text(TUNER.replace("ON_SET", "pass"))
    (node,) = coded([(".", read_source(tmp_path))], "test").system.nodes
    assert [each.name for each in node.clients] == ["/apply", "/motor/get_parameters"]


SYNC = """
#include <rclcpp/rclcpp.hpp>
using namespace std::chrono_literals;
class Tuner : public rclcpp::Node {
 public:
  Tuner() : Node("tuner") {
    client_ = std::make_shared<rclcpp::CLIENT>(this, "motor");
    timer_ = create_wall_timer(1s, [this]() { auto found = client_->get_parameters({"gain"}); });
  }
  std::shared_ptr<rclcpp::CLIENT> client_;
  rclcpp::TimerBase::SharedPtr timer_;
};
int main() { rclcpp::init(0, nullptr); rclcpp::spin(std::make_shared<Tuner>()); }
"""


@pytest.mark.parametrize(
    ("client", "rules"), [("SyncParametersClient", ["code-spins"]), ("AsyncParametersClient", [])]
)
def test_a_synchronous_client_of_parameters_spins_the_node(
    tmp_path: Path, client: str, rules: list[str]
) -> None:
    pytest.importorskip("tree_sitter_cpp")
    (tmp_path / "tuner.cpp").write_text(SYNC.replace("CLIENT", client))
    found = code_findings([(".", read_source(tmp_path))])
    assert [each.rule for each in found] == rules
    assert all("rclcpp throws" in each.message for each in found)
