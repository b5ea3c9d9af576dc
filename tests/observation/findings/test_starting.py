"""Programs that wait in vain while they start are found; those that start are not."""

from __future__ import annotations

from itertools import permutations
from pathlib import Path

import pytest

from dineros.observation.findings.code import code_findings
from dineros.sources.reading import Launch, read_source

PYTHON = """
import sys, threading, time
import rclpy
from rclpy.node import Node
from std_srvs.srv import Trigger

class One(Node):
    def __init__(self):
        super().__init__("NAME")
        STEPS
        self.create_timer(1.0, self.tick)
    def tick(self):
        self.client.call_async(Trigger.Request())
    def serve(self, request, response):
        return response
    def offer(self):
        self.create_service(Trigger, "MINE", self.serve)

rclpy.init()
node = One()
rclpy.spin(node)
"""
CPP = """
#include <rclcpp/rclcpp.hpp>
using namespace std::chrono_literals;
using std_srvs::srv::Trigger;
class One : public rclcpp::Node {
 public:
  One() : Node("NAME") {
    STEPS
  }
  rclcpp::Client<Trigger>::SharedPtr client_;
  rclcpp::Service<Trigger>::SharedPtr service_;
};
int main() {
  rclcpp::init(0, nullptr);
  rclcpp::spin(std::make_shared<One>());
}
"""
STEPS = {
    "py": {
        "ask": 'self.client = self.create_client(Trigger, "OTHER")',
        "wait": "while not self.client.wait_for_service(timeout_sec=1.0):\n            print('waiting')",
        "serve": "self.offer()",
    },
    "cpp": {
        "ask": 'client_ = create_client<Trigger>("OTHER");',
        "wait": "while (!client_->wait_for_service(1s)) { if (!rclcpp::ok()) { return; } }",
        "serve": 'service_ = create_service<Trigger>("MINE", [](Trigger::Request::SharedPtr, '
        "Trigger::Response::SharedPtr) {});",
    },
}


def _program(language: str, steps: tuple[str, ...], name: str, mine: str, other: str, wait: str = "") -> str:
    code = STEPS[language] | ({"wait": wait} if wait else {})
    text = (PYTHON if language == "py" else CPP).replace(
        "STEPS", "\n        ".join(code[each] for each in steps)
    )
    return text.replace("NAME", name).replace("MINE", mine).replace("OTHER", other)


def _rules(folder: Path) -> list[tuple[str, tuple[str, ...]]]:
    found = code_findings([(".", read_source(folder))])
    return [
        (each.rule, each.elements)
        for each in found
        if each.rule in ("code-never-starts", "code-waits-unspun")
    ]


def _write(folder: Path, language: str, *programs: str) -> None:
    for number, text in enumerate(programs):
        (folder / f"program{number}.{language}").write_text(text)


def _start_in_turn(orders: list[tuple[str, ...]]) -> set[int]:
    """Return which programs start if each does its steps as far as it can: an independent check."""
    done = [0] * len(orders)
    while True:
        served = {number for number, order in enumerate(orders) if "serve" in order[: done[number]]}
        able = [
            number
            for number, order in enumerate(orders)
            if done[number] < len(order)
            and (order[done[number]] != "wait" or (number + 1) % len(orders) in served)
        ]
        if not able:
            return {number for number, order in enumerate(orders) if done[number] == len(order)}
        for number in able:
            done[number] += 1


ORDERS = [each for each in permutations(("ask", "wait", "serve")) if each.index("ask") < each.index("wait")]


@pytest.mark.parametrize("language", ["py", "cpp"])
@pytest.mark.parametrize("first", ORDERS)
@pytest.mark.parametrize("second", ORDERS)
def test_two_nodes_wait_for_each_other(
    tmp_path: Path, language: str, first: tuple[str, ...], second: tuple[str, ...]
) -> None:
    if language == "cpp":
        pytest.importorskip("tree_sitter_cpp")
    _write(
        tmp_path,
        language,
        _program(language, first, "a", "a", "b"),
        _program(language, second, "b", "b", "a"),
    )
    start = _start_in_turn([first, second])
    expected = [name for number, name in enumerate("ab") if number not in start]
    assert [elements[0] for _, elements in _rules(tmp_path)] == expected


def test_three_nodes_in_a_circle(tmp_path: Path) -> None:
    order = ("ask", "wait", "serve")
    _write(
        tmp_path,
        "py",
        *(_program("py", order, name, name, other) for name, other in zip("abc", "bca", strict=True)),
    )
    assert [elements[0] for _, elements in _rules(tmp_path)] == ["a", "b", "c"]


def test_a_node_waits_for_itself(tmp_path: Path) -> None:
    _write(tmp_path, "py", _program("py", ("ask", "wait", "serve"), "a", "a", "a"))
    assert _rules(tmp_path) == [("code-never-starts", ("a", "__init__"))]
    message = next(
        each.message
        for each in code_findings([(".", read_source(tmp_path))])
        if each.rule == "code-never-starts"
    )
    assert message == ("a never starts: it waits for service /a, which a creates only later, after this wait")


@pytest.mark.parametrize(
    "wait",
    [
        "self.client.wait_for_service(timeout_sec=1.0)",
        "if not self.client.wait_for_service(1.0): raise SystemExit",
        "while not self.client.wait_for_service(1.0):\n            sys.exit(1)",
        "for _ in range(5):\n            self.client.wait_for_service(1.0)",
        "threading.Thread(target=self.client.wait_for_service).start()",
        "if len(sys.argv) > 1: self.client.wait_for_service()",
    ],
)
def test_waits_that_end(tmp_path: Path, wait: str) -> None:
    order = ("ask", "wait", "serve")
    _write(tmp_path, "py", *(_program("py", order, name, name, other, wait) for name, other in ("ab", "ba")))
    assert _rules(tmp_path) == []


def test_servers_outside_of_the_code_may_be_there(tmp_path: Path) -> None:
    _write(tmp_path, "py", _program("py", ("ask", "wait", "serve"), "a", "a", "elsewhere"))
    assert _rules(tmp_path) == []


CALLS = """
import threading
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import Trigger

class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.client = self.create_client(Trigger, "work")
        IN
    def ask(self):
        return self.client.call(Trigger.Request())

rclpy.init()
node = Robot()
MAIN
"""


@pytest.mark.parametrize(
    ("inside", "main", "expected"),
    [
        ("", "node.ask()\nrclpy.spin(node)", 1),
        ("self.ask()", "rclpy.spin(node)", 1),
        ("", "threading.Thread(target=rclpy.spin, args=(node,)).start()\nnode.ask()", 0),
        ("", "node.ask()\nthreading.Thread(target=rclpy.spin, args=(node,)).start()", 1),
        ("", "def run():\n    rclpy.spin(node)\nthreading.Thread(target=run).start()\nnode.ask()", 0),
        (
            "",
            "e = SingleThreadedExecutor()\ne.add_node(node)\n"
            "threading.Thread(target=e.spin).start()\nnode.ask()",
            0,
        ),
        ("", "f = node.client.call_async(Trigger.Request())\nrclpy.spin_until_future_complete(node, f)", 0),
        ("", "rclpy.spin(node)\nnode.client.call_async(Trigger.Request())", 0),
        ("", "threading.Thread(target=node.ask).start()\nrclpy.spin(node)", 0),
    ],
)
def test_calls_before_an_executor_runs(tmp_path: Path, inside: str, main: str, expected: int) -> None:
    (tmp_path / "robot.py").write_text(
        CALLS.replace("        IN\n", f"        {inside or 'pass'}\n").replace("MAIN", main)
    )
    assert [rule for rule, _ in _rules(tmp_path)] == ["code-waits-unspun"] * expected


@pytest.mark.parametrize(
    ("main", "expected"), [("node->ask(); rclcpp::spin(node);", 1), ("rclcpp::spin(node);", 0)]
)
def test_calls_in_cpp_before_an_executor_runs(tmp_path: Path, main: str, expected: int) -> None:
    pytest.importorskip("tree_sitter_cpp")
    (tmp_path / "robot.cpp").write_text(
        """
#include <rclcpp/rclcpp.hpp>
using std_srvs::srv::Trigger;
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") { client_ = create_client<Trigger>("work"); }
  void ask() { client_->async_send_request(std::make_shared<Trigger::Request>()).get(); }
  rclcpp::Client<Trigger>::SharedPtr client_;
};
int main() {
  rclcpp::init(0, nullptr);
  auto node = std::make_shared<Robot>();
  MAIN
}
""".replace("MAIN", main)
    )
    assert [rule for rule, _ in _rules(tmp_path)] == ["code-waits-unspun"] * expected


HELPERS = {
    "py": """
import rclpy, threading
from rclpy.node import Node
from std_srvs.srv import Trigger

class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.helper = rclpy.create_node("helper")
        self.client = self.helper.create_client(Trigger, "ask")
        self.create_timer(1.0, self.tick)
    def tick(self):
        self.client.call(Trigger.Request())

rclpy.init()
node = Robot()
SPINS
rclpy.spin(node)
""",
    "cpp": """
#include <rclcpp/rclcpp.hpp>
using std_srvs::srv::Trigger;
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    helper_ = std::make_shared<rclcpp::Node>("helper");
    client_ = helper_->create_client<Trigger>("ask");
    timer_ = create_wall_timer(std::chrono::seconds(1), [this]() { tick(); });
  }
  void tick() {
    auto future = client_->async_send_request(std::make_shared<Trigger::Request>());
    future.wait();
  }
  rclcpp::Node::SharedPtr helper_;
  rclcpp::Client<Trigger>::SharedPtr client_;
  rclcpp::TimerBase::SharedPtr timer_;
};
int main() {
  rclcpp::init(0, nullptr);
  auto node = std::make_shared<Robot>();
  SPINS
  rclcpp::spin(node);
}
""",
}


@pytest.mark.parametrize(
    ("language", "spins", "expected"),
    [
        ("py", "", ["error"]),
        ("py", "threading.Thread(target=rclpy.spin, args=(node.helper,)).start()", []),
        ("py", "from somewhere import spinner\nspinner.start(node.helper)", []),
        ("cpp", "", ["warning"]),
        ("cpp", "std::thread spinner([node]() { rclcpp::spin(node->helper_); }); spinner.detach();", []),
        ("cpp", "somewhere::start(node->helper_);", []),
    ],
)
def test_helper_nodes_that_nothing_spins(
    tmp_path: Path, language: str, spins: str, expected: list[str]
) -> None:
    """A callback waits for a response that only another node, without an executor, can receive."""
    (tmp_path / f"robot.{language}").write_text(HELPERS[language].replace("SPINS", spins))
    found = code_findings([(".", read_source(tmp_path))])
    unspun = [each for each in found if each.rule == "code-waits-unspun"]
    assert [each.severity for each in unspun] == expected
    assert all("no executor runs helper" in each.message for each in unspun)


FLEET = """
from launch import LaunchDescription
from launch_ros.actions import Node

def generate_launch_description():
    return LaunchDescription([
        Node(package="p", executable="program0.py", name="a", namespace="left", remappings=[REMAPPINGS]),
        Node(package="p", executable="program1.py", name="b", namespace="SPACE"),
    ])
"""


@pytest.mark.parametrize(
    ("space", "remappings", "is_stuck"),
    [
        *(("left", "", True), ("/left", "", True), ("right", "", False), ("left/inner", "", False)),
        *(("left", '("b", "c")', False), ("right", '("b", "/right/b"), ("a", "/right/a")', True)),
        ("right", '("b", "/right/b")', False),
    ],
)
def test_names_in_namespaces_and_after_remappings_decide(
    tmp_path: Path, space: str, remappings: str, is_stuck: bool
) -> None:
    order = ("ask", "wait", "serve")
    _write(tmp_path, "py", _program("py", order, "a", "a", "b"), _program("py", order, "b", "b", "a"))
    (tmp_path / "package.xml").write_text("<package><name>p</name></package>")
    text = FLEET.replace("REMAPPINGS", remappings).replace("SPACE", space)
    (tmp_path / "robot.launch.py").write_text(text)
    facts = read_source(tmp_path, launch=Launch("robot.launch.py"))
    assert len(facts.nodes) == 2 and facts.unread == []
    found = [each for each in code_findings([(".", facts)]) if each.rule == "code-never-starts"]
    assert [each.elements[0] for each in found] == (["a", "b"] if is_stuck else [])


def test_another_process_of_the_same_program_creates_its_server_itself(tmp_path: Path) -> None:
    """Each process waits for a server of the other, which creates it first."""
    _write(tmp_path, "py", _program("py", ("serve", "ask", "wait"), "a", "a", "b"))
    (tmp_path / "package.xml").write_text("<package><name>p</name></package>")
    rule = 'Node(package="p", executable="program0.py", name="{0}", remappings=[("a", "{1}"), ("b", "{2}")]),'
    later = _program("py", ("ask", "wait", "serve"), "a", "a", "b")
    for program, is_stuck in ((None, False), (later, True)):
        if program is not None:
            (tmp_path / "program0.py").write_text(program)
        nodes = rule.format("a", "x", "y") + rule.format("b", "y", "x")
        text = FLEET.partition("        Node")[0] + f"        {nodes}\n    ])\n"
        (tmp_path / "robot.launch.py").write_text(text)
        facts = read_source(tmp_path, launch=Launch("robot.launch.py"))
        found = [each for each in code_findings([(".", facts)]) if each.rule == "code-never-starts"]
        assert [each.elements[0] for each in found] == (["a", "b"] if is_stuck else [])
