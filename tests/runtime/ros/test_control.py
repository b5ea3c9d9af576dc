"""A node on ROS 2 that does not run: it says so, and continues and ends when it is asked to."""

from __future__ import annotations

import json
import signal
from typing import Any

import pytest

from tests.runtime.ros.conftest import PATIENCE, Process, Ros

OPEN = {"signals.Open": True}
BLOCKED = """
import threading, time
from pathlib import Path
LOCK = threading.Lock()
LOCK.acquire()
def configure(net):
    @net.handler("TSend"{options})
    def send(firing):
        Path("begun").touch()
        {body}
"""
FAILING = """
from pathlib import Path
from dineros.runtime import Aside
def configure(net):
    @net.handler("TSend"{options})
    def send(firing):
        if not Path("fixed").exists():
            raise ValueError("no stamps")
"""
JAMMED = """
import asyncio
from pathlib import Path
def configure(net):
    @net.handler("TSend")
    async def send(firing):
        if not Path("fixed").exists():
            net.halt("jammed")
            await asyncio.sleep(3600)
"""
LISTENER = """
import json, sys, time
import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from std_srvs.srv import Trigger
rclpy.init()
node = rclpy.create_node("stranger")
heard = []
latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
node.create_subscription(String, "/office/state", lambda m: heard.append(json.loads(m.data)), latched)
end = time.monotonic() + 60
def state(wanted):
    while not any(each["state"] == wanted for each in heard):
        assert time.monotonic() < end, heard
        rclpy.spin_once(node, timeout_sec=0.1)
    found = [each for each in heard if each["state"] == wanted][-1]
    heard.clear()
    print(json.dumps(found))
def ask(name):
    client = node.create_client(Trigger, "/office/" + name)
    assert client.wait_for_service(60)
    future = client.call_async(Trigger.Request())
    rclpy.spin_until_future_complete(node, future, timeout_sec=60)
    print(json.dumps([future.result().success, future.result().message]))
"""


def told(ros: Ros, script: str) -> list[Any]:
    """Run a listener on ROS, and return what it was told."""
    return [json.loads(line) for line in ros.script(LISTENER + script + "\nrclpy.shutdown()\n").splitlines()]


def terminate(process: Process) -> int:
    process.popen.send_signal(signal.SIGTERM)
    return process.popen.wait(PATIENCE)


@pytest.mark.long
def test_a_blocked_node_says_so_and_ends(ros: Ros) -> None:
    """The state topic has the handler's stack, the log has it once; SIGTERM ends the node in order."""
    handlers = BLOCKED.format(options="", body="time.sleep(3600)")
    office = ros.node("office", {**OPEN, "watchdog": 0.2}, handlers)
    (state,) = told(ros, "state('blocked')")
    assert (state["node"], state["blocked"]["transition"], state["blocked"]["handler"]) == (
        "office",
        "TSend",
        "send",
    )
    assert "time.sleep(3600)" in state["blocked"]["stack"]
    assert terminate(office) == 0
    assert office.output().count("the handler send of TSend has blocked the node office") == 1
    error, stop = ros.records("office")[-2:]
    assert (error["event"], error["transition"], error["policy"]) == ("error", "TSend", None)
    assert (stop["event"], stop["reason"]) == ("stop", "signal")
    assert ros.fired("office", "TSend") == []
    # Its firing was released: the next life begins it again.
    again = ros.node("office", {"resume": True}, "def configure(net): pass")
    ros.wait(lambda: len(ros.fired("office", "TSend")) == 3, "sending")
    assert terminate(again) == 0


@pytest.mark.long
@pytest.mark.parametrize(
    ("options", "body"),
    [
        ("", "while True: pass"),
        ("", "LOCK.acquire()"),
        (", thread=True", "time.sleep(3600)"),
        (
            "",
            "__import__('concurrent.futures').futures.ThreadPoolExecutor().submit(time.sleep, 3600).result()",
        ),
    ],
    ids=["busy", "lock", "thread", "executor"],
)
def test_a_node_ends_although_a_handler_does_not(ros: Ros, options: str, body: str) -> None:
    office = ros.node("office", OPEN, BLOCKED.format(options=options, body=body))
    ros.wait((ros.folder / "begun").exists, "the handler")
    assert terminate(office) == 0, office.output()
    assert ros.records("office")[-1]["event"] == "stop"


@pytest.mark.long
def test_a_managed_node_ends_although_a_handler_does_not(ros: Ros) -> None:
    change = (
        "import rclpy\n"
        "from lifecycle_msgs.srv import ChangeState\n"
        "from lifecycle_msgs.msg import Transition\n"
        "rclpy.init()\n"
        "node = rclpy.create_node('manager')\n"
        "client = node.create_client(ChangeState, '/office/change_state')\n"
        "assert client.wait_for_service(60)\n"
        "for id in (1, 3):\n"
        "    future = client.call_async(ChangeState.Request(transition=Transition(id=id)))\n"
        "    rclpy.spin_until_future_complete(node, future, timeout_sec=60)\n"
        "rclpy.shutdown()\n"
    )
    office = ros.node(
        "office", OPEN, BLOCKED.format(options="", body="time.sleep(3600)"), options=["--lifecycle"]
    )
    ros.script(change)
    ros.wait((ros.folder / "begun").exists, "the handler")
    assert terminate(office) == 0, office.output()
    assert ros.records("office")[-1]["event"] == "stop"


@pytest.mark.long
def test_a_node_that_hangs_before_it_starts_ends_by_force_and_says_where(ros: Ros) -> None:
    office = ros.node(
        "office",
        handlers="import time\nfrom pathlib import Path\n\n\ndef configure(net):\n"
        "    Path('begun').touch()\n    time.sleep(3600)\n",
    )
    ros.wait((ros.folder / "begun").exists, "configuring")
    assert terminate(office) == 1
    assert "was asked to end and still runs" in office.output()
    assert 'office_handlers.py", line 7 in configure' in office.output()


def test_a_halted_node_proceeds_when_it_is_told_to(ros: Ros) -> None:
    office = ros.node("office", OPEN, FAILING.format(options=""))
    first = told(
        ros,
        "state('halted')\nfrom pathlib import Path\nPath('fixed').touch()\n"
        "ask('proceed')\nstate('running')\nask('proceed')\n",
    )
    halted, answer, running, again = first
    assert halted["reason"] == "the handler send of TSend failed: ValueError: no stamps"
    assert halted["error"] | {"time": 0} == {
        "time": 0,
        "transition": "TSend",
        "handler": "send",
        "error": "ValueError: no stamps",
        "policy": "halt",
    }
    assert answer[0] is True
    assert (running["reason"], running["failures"]) == (None, 1)
    assert again == [False, "the node is not halted"]
    ros.wait(lambda: len(ros.fired("office", "TSend")) == 3, "sending")
    assert terminate(office) == 0


@pytest.mark.long
def test_what_is_left_aside_is_released_when_it_is_told_to(ros: Ros) -> None:
    handlers = FAILING.format(options=", policy=Aside()")
    office = ros.node("office", OPEN, handlers)
    ros.wait(lambda: len(ros.records("office", "aside")) == 3, "leaving three letters aside")
    (ros.folder / "fixed").touch()
    (answer,) = told(ros, "ask('release')")
    assert answer == [True, "TSend may take the tokens again that were set aside"]
    ros.wait(lambda: len(ros.fired("office", "TSend")) == 3, "sending")
    (answer,) = told(ros, "ask('release')")
    assert answer[0] is False
    assert terminate(office) == 0


def test_what_a_halted_node_has_in_flight_is_released_when_it_is_told_to(ros: Ros) -> None:
    office = ros.node("office", OPEN, JAMMED)
    _, released, proceeds = told(
        ros,
        "state('halted')\nfrom pathlib import Path\nPath('fixed').touch()\nask('release')\nask('proceed')\n",
    )
    assert released == [True, "TSend is released"]
    assert proceeds[0] is True
    ros.wait(lambda: len(ros.fired("office", "TSend")) == 3, "sending")
    assert terminate(office) == 0


def test_values_outside_of_their_ros_field_fail_where_the_handler_returns_them(ros: Ros) -> None:
    """The firing fails by the name of the field; nothing is recorded as sent."""
    file = ros.folder / "scale.rtm.xmi"
    file.write_text(file.read_text().replace("std_msgs/msg/Float64", "std_msgs/msg/Float32"))
    handlers = 'def configure(net):\n    net.handler("TShow")(lambda firing: {"weight": 1e300})\n'
    scale = ros.node("scale", handlers=handlers)
    ros.wait(lambda: ros.records("scale", "error"), "the failure")
    assert terminate(scale) == 0
    (error,) = ros.records("scale", "error")
    assert (error["transition"], error["handler"], error["policy"]) == ("TShow", "<lambda>", "halt")
    assert error["error"].startswith(
        "weight cannot be sent: std_msgs/msg/Float32 data takes a single-precision number, not 1e+300"
    )
    assert ros.fired("scale", "TShow") + ros.records("scale", "publish") == []


def test_a_text_with_nul_fails_where_the_handler_returns_it(ros: Ros) -> None:
    office = ros.node(
        "office", OPEN, 'def configure(net):\n    net.handler("TSend")(lambda f: {"subject": "a\\0b"})\n'
    )
    ros.wait(lambda: ros.records("office", "error"), "the failure")
    assert terminate(office) == 0
    (error,) = ros.records("office", "error")
    assert error["error"] == 'subject takes a string without NUL, not "a\\u0000b"'
    assert ros.fired("office", "TSend") + ros.records("office", "publish") == []


def test_handlers_that_cannot_be_imported_are_one_line(ros: Ros) -> None:
    office = ros.node("office", handlers="import nowhere\n")
    assert office.popen.wait(PATIENCE) == 2
    said = office.output().splitlines()[-1]
    assert said == f"{ros.folder}/office_handlers.py:1: ModuleNotFoundError: No module named 'nowhere'"
    assert "Traceback" not in office.output()
    ros.processes.remove(office)
