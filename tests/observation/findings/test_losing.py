"""Messages and requests that get lost, and timers that come late, are found at their line."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.findings.code import code_findings
from dineros.observation.findings.losing import FAULTS
from dineros.sources.reading import read_source

HEAD = """
import rclpy, sys, threading, time
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from std_srvs.srv import Trigger
"""
LATCHED = "QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)"
MAP = """
KINDS = {"volatile": DurabilityPolicy.VOLATILE, "latched": DurabilityPolicy.TRANSIENT_LOCAL}
class Slam(Node):
    def __init__(self):
        super().__init__("slam")
        BEFORE
        self.map = self.create_publisher(String, "map", QOS)
        self.map.publish(String())  # HERE
        self.create_timer(1.0, self.tick)
    def tick(self):
        TICK
class Saver(Node):
    def __init__(self):
        super().__init__("saver")
        self.create_subscription(String, "NAME", print, READER)
rclpy.init()
executor = SingleThreadedExecutor()
executor.add_node(Slam())
executor.add_node(Saver())
executor.spin()
"""
TIMER = """
class Worker(Node):
    def __init__(self):
        super().__init__("worker")
        self.create_timer(0.05, self.work)
        self.create_subscription(String, "in", self.on_in, 10)
    def work(self):
        time.sleep(SECONDS)  # HERE
    def on_in(self, message): pass
rclpy.init()
rclpy.spin(Worker())
"""
SERVER = """
class Planner(Node):
    def __init__(self):
        super().__init__("planner")
        self.route = self.create_service(Trigger, "route", self.on_route)
    def on_route(self, request, response):
        self.destroy_service(self.route)  # HERE
        return response
class Api(Node):
    def __init__(self):
        super().__init__("api")
        self.route = self.create_client(Trigger, "/route")
        self.create_timer(1.0, self.tick)
    def tick(self): self.route.CALL
rclpy.init()
executor = SingleThreadedExecutor()
executor.add_node(Planner())
executor.add_node(Api())
executor.spin()
"""
RATE = """
class Source(Node):
    def __init__(self):
        super().__init__("source")
        self.out = self.create_publisher(String, "command", 10)
        self.create_timer(PERIOD, self.say)
    def say(self):
        SAYS
class Sleeper(Node):
    def __init__(self):
        super().__init__("sleeper")
        self.rate = self.create_rate(HERTZ)
        self.create_subscription(String, "command", self.on_command, DEPTH, callback_group=GROUP)
    def on_command(self, message):
        self.rate.sleep()  # HERE
rclpy.init()
executor = MultiThreadedExecutor(num_threads=THREADS)
executor.add_node(Source())
executor.add_node(Sleeper())
executor.spin()
"""
AGAIN = """
class Manager(Node):
    def __init__(self):
        super().__init__("manager")
        self.create_service(Trigger, "configure", self.on_configure)
    def on_configure(self, request, response):
        time.sleep(WORK)
        return response
rclpy.init()
manager, spawner = Node("unused"), Node("spawner")
manager = Manager()
client = spawner.create_client(Trigger, "configure")
executor = SingleThreadedExecutor()
executor.add_node(manager)
threading.Thread(target=executor.spin).start()
for attempt in range(3):
    future = client.call_async(Trigger.Request())  # HERE
    rclpy.spin_until_future_complete(spawner, future, timeout_sec=PATIENCE)
"""


def found(folder: Path, text: str, **words: str) -> list[str]:
    """Return what gets lost in a program, as rules; all at the line that is marked."""
    text = HEAD + text
    for word, said in words.items():
        text = text.replace(word, said)
    (folder / "robot.py").write_text(text)
    line = next(number for number, line in enumerate(text.split("\n"), 1) if "HERE" in line)
    rules = {fault.rule: fault.severity for fault in FAULTS}
    findings = [each for each in code_findings([(".", read_source(folder))]) if each.rule in rules]
    assert all(each.lines == (f"robot.py:{line}",) for each in findings)
    assert all(each.severity in (rules[each.rule], "note") for each in findings)
    return ["note " * (each.severity == "note") + each.rule for each in findings]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ({}, ["code-publishes-early"]),
        ({"QOS": "QoSProfile(depth=1, durability=KINDS[sys.argv[1]])"}, ["note code-publishes-early"]),
        ({"QOS": "QoSProfile(depth=1, durability=KINDS['latched'])"}, []),
        ({"QOS": LATCHED}, []),
        ({"QOS": LATCHED, "READER": "10"}, ["code-publishes-early"]),  # it asks for no older message
        (
            {"QOS": LATCHED, "READER": "QoSProfile(depth=1, durability=KINDS[sys.argv[1]])"},
            ["note code-publishes-early"],
        ),
        ({"TICK": "self.map.publish(String())"}, []),  # makes up for it
        ({"BEFORE": "time.sleep(1.0)"}, []),
        ({"NAME": "other"}, []),
    ],
)
def test_a_message_before_its_subscriber(tmp_path: Path, words: dict[str, str], expected: list[str]) -> None:
    said = {"BEFORE": "pass", "QOS": "10", "TICK": "pass", "NAME": "map", "READER": LATCHED} | words
    assert found(tmp_path, MAP, **said) == expected


@pytest.mark.parametrize(
    ("seconds", "expected"),
    [("0.1", ["code-overruns"]), ("float(sys.argv[1])", ["code-overruns"]), ("0.01", []), ("0.0", [])],
)
def test_a_timer_that_sleeps_longer_than_its_period(
    tmp_path: Path, seconds: str, expected: list[str]
) -> None:
    assert found(tmp_path, TIMER, SECONDS=seconds) == expected


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ({}, ["code-falls-behind"]),
        ({"PERIOD": "2.0 if len((1, 2)) > 2 else 0.01"}, ["code-falls-behind"]),
        ({"PERIOD": "2.0 if len([1, 2]) > 1 else 0.01"}, []),
        ({"HERTZ": "20", "PERIOD": "0.1"}, []),
        ({"HERTZ": "10", "PERIOD": "0.1"}, []),
        ({"THREADS": "1"}, []),  # the callback never wakes up, which is another finding
        ({"GROUP": "ReentrantCallbackGroup()"}, []),  # one tick of the rate wakes all runs
        ({"DEPTH": "1"}, []),
        ({"SAYS": "if sys.argv: self.out.publish(String())"}, []),
        ({"self.rate.sleep()": "if sys.argv: self.rate.sleep()"}, []),
    ],
)
def test_a_rate_that_is_slower_than_the_messages(
    tmp_path: Path, words: dict[str, str], expected: list[str]
) -> None:
    said = {"PERIOD": "0.01", "HERTZ": "1", "THREADS": "2", "GROUP": "None", "DEPTH": "10"}
    assert found(tmp_path, RATE, **(said | {"SAYS": "self.out.publish(String())"} | words)) == expected


@pytest.mark.parametrize(
    ("call", "expected"),
    [
        ("call(Trigger.Request())", ["code-loses-server"]),
        ("call_async(Trigger.Request()).add_done_callback(print)", ["code-loses-server"]),
        ("call(Trigger.Request(), timeout_sec=1.0)", []),
    ],
)
def test_a_server_that_goes_while_clients_wait(tmp_path: Path, call: str, expected: list[str]) -> None:
    assert found(tmp_path, SERVER, CALL=call) == expected


@pytest.mark.parametrize(
    ("work", "patience", "expected"),
    [
        ("5.0", "1.0", ["code-asks-again"]),
        ("float(sys.argv[1])", "1.0", ["code-asks-again"]),
        ("0.01", "10.0", []),
        ("5.0", "None", []),
    ],
)
def test_a_request_that_is_sent_again(tmp_path: Path, work: str, patience: str, expected: list[str]) -> None:
    assert found(tmp_path, AGAIN, WORK=work, PATIENCE=patience) == expected
