"""Source code, launch files and tables of libraries: a model is made of a folder with one damaged file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

from tests.fuzz import mutators
from tests.fuzz.judging import REFUSED, Outcome, run_command
from tests.sources.cpp.test_cpp_nodes import ROBOT
from tests.sources.launch.test_launch import IN_PYTHON, PACKAGE

Attempt = Callable[[bytes], Outcome]
BUDGET = ("--memory", "600M", "--timeout", "20")

PYTHON = [
    b"""import rclpy
from rclpy.node import Node
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.action import ActionClient, ActionServer
from std_msgs.msg import String
from std_srvs.srv import Trigger
from example_interfaces.action import Fibonacci


class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.declare_parameter("rate", 4.0)
        self.names = ["left", "right"]
        self.group = ReentrantCallbackGroup()
        self.out = [self.create_publisher(String, f"{name}/out", 10) for name in self.names]
        self.client = self.create_client(Trigger, "reset", callback_group=self.group)
        self.goals = ActionClient(self, Fibonacci, "count")
        self.create_service(Trigger, "stop", self.on_stop)
        self.create_subscription(String, "in", lambda message: self.out[0].publish(message), 10)
        self.timer = self.create_timer(1.0 / self.get_parameter("rate").value, self.tick)

    async def tick(self):
        for out in self.out:
            if self.names and not self.busy():
                out.publish(String(data="x"))
        try:
            await self.client.call_async(Trigger.Request())
        finally:
            self.goals.send_goal_async(Fibonacci.Goal()).add_done_callback(self.on_goal)

    def busy(self):
        return self.client.service_is_ready() or self.busy()

    def on_goal(self, future):
        self.client.call(Trigger.Request())

    def on_stop(self, request, response):
        self.timer.cancel()
        return response


def main():
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=2)
    executor.add_node(Robot())
    executor.spin()


if __name__ == "__main__":
    main()
""",
    b"""import rclpy
rclpy.init()
node = rclpy.create_node("talker", namespace="/a")
out = node.create_publisher(__import__("std_msgs.msg").msg.String, "chatter", 1)
while rclpy.ok():
    rclpy.spin_once(node, timeout_sec=0.1)
    out.publish(None)
""",
]
CPP = [
    ROBOT.encode(),
    b"""#include <rclcpp/rclcpp.hpp>
namespace arm {
template <typename T> class Base : public rclcpp_lifecycle::LifecycleNode {
 protected:
  std::mutex m_; std::condition_variable c_; std::vector<std::shared_ptr<T>> all_;
  void wait() { std::unique_lock<std::mutex> lock(m_); c_.wait(lock, [&] { return true; }); }
};
class Driver : public Base<int> {
 public:
  Driver() : Base("driver") {
    for (int i = 0; i < 3; ++i) { pubs_.emplace_back(create_publisher<Msg>("p" + std::to_string(i), 1)); }
    srv_ = create_service<std_srvs::srv::Trigger>("go", std::bind(&Driver::go, this, _1, _2));
    std::thread([this]() { while (rclcpp::ok()) { wait(); } }).detach();
  }
  void go(Request::SharedPtr, Response::SharedPtr) {
    switch (mode_) { case 1: wait(); break; default: return; }
  }
};
}
RCLCPP_COMPONENTS_REGISTER_NODE(arm::Driver)
""",
]
LAUNCH = [
    IN_PYTHON.replace("mover", "robot").encode(),
    b"""from launch import LaunchDescription
from launch_ros.actions import Node
def generate_launch_description():
    names = ["a", "b"]
    return LaunchDescription([Node(package="arm", executable="robot", name=n, namespace=f"/{n}",
        remappings=[("in", "out")], parameters=[{"rate": 2.0 * 3}]) for n in names])
""",
]
LAUNCH_XML = [
    b"""<launch><arg name="n" default="$(env HOME /x)"/><let name="m" value="$(var n)/a"/>
<group if="$(eval 'True')"><push-ros-namespace namespace="left"/>
<node pkg="arm" exec="robot" name="r" output="screen"><remap from="in" to="out"/>
<param name="rate" value="3"/></node></group>
<include file="$(find-pkg-share arm)/launch/other.launch.xml"/></launch>"""
]
LAUNCH_YAML = [
    b"""launch:
- arg: {name: n, default: "3"}
- group:
  - push_ros_namespace: {namespace: left}
  - node:
      {pkg: arm, exec: robot, name: "r$(var n)", param: [{name: rate, value: 3}]}
- include: {file: other.launch.yaml}
"""
]
IDIOMS = [
    b"""[[idiom]]
path = "our_robot.heartbeat.Heartbeat"
arguments = ["node", "topic"]
makes = [{ kind = "publishers", name = "{topic}", type = "std_msgs/msg/Empty", depth = 1 }]
methods.beat = { do = "publish", entity = 0 }
""",
    b"""[[idiom]]
path = "our_robot::Heartbeat"
arguments = ["node", "topic", "qos"]
makes = [{ kind = "publishers", name = "{topic}", type = "std_msgs/msg/Empty", usual = true }]
methods.beat = { do = "publish", entity = 0 }
""",
]
PARAMETERS = [
    b"""/**:
  ros__parameters: {rate: 2.0, use_sim_time: false}
robot:
  ros__parameters:
    rate: 4
    names: [left, right]
    topics: {in: /scan, out: "/x"}
    qos_overrides: {/left/out: {publisher: {depth: 3, history: keep_last, reliability: best_effort}}}
/left/r3: &same
  ros__parameters: {rate: 1.5e-1}
other: *same
"""
]
STARTED = b"""<launch><let name="file" value="$(find-pkg-share arm)/config/arm.yaml"/>
<node pkg="arm" exec="robot" name="robot"><param from="$(var file)"/></node>
<node pkg="arm" exec="robot" name="r3" namespace="left"><param from="$(var file)"/></node></launch>"""
INTERFACES = [
    b"""# what a robot says
uint8 IDLE=0
uint8 MOVING=1 # comment
string<=10 NAME="a b"
uint8 state 0
float64[<=3] values [1.0, 2.5]
std_msgs/Header header
builtin_interfaces/Time[] times
geometry_msgs/msg/Pose pose
---
bool success true
wstring text
---
int32 count -1
"""
]
CMAKE = b"""find_package(rclcpp REQUIRED)
set(names robot other)
foreach(name IN LISTS names)
  add_executable(${name} src/robot.cpp)
endforeach()
install(TARGETS ${names} DESTINATION lib/${PROJECT_NAME})
rclcpp_components_register_node(driver PLUGIN "arm::Driver" EXECUTABLE driver)
"""


class Damaged(NamedTuple):
    """A file of a folder of code: where it is, what is damaged, and how; options have OUT for the folder."""

    place: str
    originals: list[bytes]
    mutate: mutators.Mutator = mutators.mutate_words
    options: tuple[str, ...] = ()


def _launched(name: str) -> tuple[str, ...]:
    return ("--launch", f"OUT/robot/launch/{name}")


SOURCES = {
    "Python source": Damaged("robot/robot.py", PYTHON),
    "C++ source": Damaged("robot/robot.cpp", CPP),
    "build file": Damaged("robot/CMakeLists.txt", [CMAKE]),
    "launch file": Damaged("robot/launch/a.launch.py", LAUNCH, options=_launched("a.launch.py")),
    "launch XML": Damaged(
        "robot/launch/a.launch.xml", LAUNCH_XML, mutators.mutate_xml, _launched("a.launch.xml")
    ),
    "launch YAML": Damaged("robot/launch/a.launch.yaml", LAUNCH_YAML, options=_launched("a.launch.yaml")),
    "parameter file": Damaged("robot/config/arm.yaml", PARAMETERS, options=_launched("robot.launch.xml")),
    "interface": Damaged("robot/action/Move.action", INTERFACES),
    "idioms": Damaged("ours.toml", IDIOMS, options=("--idioms", "OUT/ours.toml")),
}
"""Kinds of files, by name."""


def source(damaged: Damaged, folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Import a folder of code in which one file is damaged; a model that is written must be valid."""
    work, out = folder / "robot", folder / "out.sym.xmi"
    for name in ("launch", "config", "action"):
        (work / name).mkdir(parents=True)
    files = {"robot.py": PYTHON[0], "robot.cpp": CPP[0], "CMakeLists.txt": CMAKE}
    files |= {"launch/robot.launch.xml": STARTED, "config/arm.yaml": PARAMETERS[0]}
    files["action/Move.action"] = INTERFACES[0]
    for name, content in {**files, "package.xml": PACKAGE.encode()}.items():
        (work / name).write_bytes(content)
    given = [option.replace("OUT", str(folder)) for option in damaged.options]

    def attempt(content: bytes) -> Outcome:
        for left in folder.glob("out.*"):
            left.unlink()
        path = folder / damaged.place
        path.write_bytes(content)
        facts = ["--facts", folder / "out.facts.json"]
        outcome = run_command("import", "--source", work, "-o", out, *facts, *given, *BUDGET)
        if outcome.status == REFUSED and out.exists():
            return Outcome(-1, f"is refused, but there is a model: {outcome.said}")
        if outcome.status in (0, 1):
            valid = run_command("validate", out)
            if valid.status != 0:
                return Outcome(-1, f"writes a model that is not valid: {valid.said}")
        return outcome

    return damaged.originals, attempt
