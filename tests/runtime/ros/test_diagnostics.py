"""How a node fares, as others see it: /diagnostics, metrics, ~/describe, budgets, and levels of its log."""

from __future__ import annotations

import json
import socket
import urllib.error
import urllib.request
from typing import Any

import pytest

from dineros.metamodel.files import save
from dineros.transformations.flattening.split import split
from tests.runtime.ros.conftest import Ros
from tests.runtime.ros.post import post

OPEN = {"signals.Open": True}
SLOW = """
import time
def configure(net):
    @net.handler("TSend", budget=0.001)
    def send(firing):
        time.sleep(0.02)
"""
BROKEN = """
import logging
from dineros.runtime.nodes.health import HealthWatch
def configure(net):
    def look(self):
        raise ValueError("no look")
    HealthWatch.look = look
"""
LISTENER = """
import json, time
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
rclpy.init()
node = rclpy.create_node("stranger")
parts, end = {}, time.monotonic() + 60
def heard(message):
    for each in message.status:
        values = {value.key: value.value for value in each.values}
        parts[each.name] = [each.level[0], each.message, values, each.hardware_id]
node.create_subscription(DiagnosticArray, "/diagnostics", heard, 10)
def wait(condition):
    while not condition():
        assert time.monotonic() < end, parts
        rclpy.spin_once(node, timeout_sec=0.1)
"""


def told(ros: Ros, condition: str, more: str = "") -> dict[str, Any]:
    """Listen until a condition on `parts` holds, and return them."""
    script = f"{LISTENER}\nwait(lambda: {condition})\n{more}\nprint(json.dumps(parts))\nrclpy.shutdown()\n"
    return dict(json.loads(ros.script(script)))


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def fetch(port: int, path: str = "/metrics", host: str = "") -> str:
    request = urllib.request.Request(f"http://127.0.0.1:{port}{path}", headers={"Host": host} if host else {})
    with urllib.request.urlopen(request, timeout=30) as answer:
        return str(answer.read().decode())


@pytest.mark.long
def test_a_node_tells_how_it_fares_and_what_it_is(ros: Ros) -> None:
    port = free_port()
    more = {"metrics_port": port, "diagnostics_period": 0.1, "stale_after.Open": 0.1}
    office = ros.node("office", {**OPEN, **more}, SLOW)
    ask = """
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger
def ask(kind, name, request):
    client = node.create_client(kind, name)
    assert client.wait_for_service(60)
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future, timeout_sec=60)
    return future.result()
parts["describe"] = json.loads(ask(Trigger, "/office/describe", Trigger.Request()).message)
set_level = lambda level: ask(SetParameters, "/office/set_parameters", SetParameters.Request(
    parameters=[Parameter("log_level", value=level).to_parameter_msg()])).results[0]
parts["levels"] = [[each.successful, each.reason] for each in map(set_level, ("loud", "debug"))]
"""
    condition = (
        "parts.get('/office: state', [0, '', {}])[2].get('firings') == '3'"
        " and parts.get('/office: signals', [0])[0]"
    )
    parts = told(ros, condition, ask)
    level, text, values, application = parts["/office: state"]
    assert (level, text, values["state"], values["failures"], values["restarts"], application) == (
        *(0, "running", "running", "1", "0"),  # that a signal is stale counts as a failure
        "post",
    )
    assert parts["/office: places"][2]["Pile"] == "0"
    level, text, signals, _ = parts["/office: signals"]
    assert (level, text) == (1, "the signal Open is stale: not set for 0.1 s")
    assert signals["Open"].startswith("true ")
    (handler,) = parts["/office: handlers"][2].items()
    assert handler[0] == "TSend send"
    assert handler[1].endswith("budget 0.001 s, 3 too slow")
    described = parts["describe"]
    assert (described["name"], described["model"]) == ("/office", "post")
    assert parts["levels"] == [
        [False, "there is no log level 'loud': take one of debug, info, warn, error, fatal"],
        [True, ""],
    ]
    assert "[WARN]" in office.output()
    assert office.output().count("the handler send of TSend took ") == 1
    assert "its budget is 0.001 s [handler-time]" in office.output()
    text = fetch(port)
    assert 'dineros_firings_total{node="/office"} 3\n' in text
    assert 'dineros_signal_stale{node="/office",signal="Open"} 1\n' in text
    for path, host in (("/metrics", "evil.example"), ("/", "")):
        with pytest.raises(urllib.error.HTTPError):
            fetch(port, path, host)
    assert office.interrupt() == 0
    with pytest.raises(urllib.error.URLError):
        fetch(port)


@pytest.mark.long
def test_a_queue_that_fills_names_its_place(ros: Ros) -> None:
    """The house reads slowly: what waits in the middleware's history is seen, which rclpy cannot tell.

    It reads so slowly that who listens is there before the queue is shorter again.
    """
    for part in split(post(letters=9)):
        save(part, ros.folder / f"{part.node.id}.rtm.xmi")
    slow = "import time\ndef configure(net):\n    net.handler('TRead')(lambda firing: time.sleep(2))\n"
    house = ros.node("house", {"diagnostics_period": 0.1}, slow)
    ros.wait(lambda: ros.records("house", "start"), "the start")
    ros.node("office", {**OPEN, "expected_subscribers.Letters": 1})
    parts = told(ros, "parts.get('/house: queues', [0])[0] == 1")
    assert "the queue of Arrived (topic" in parts["/house: queues"][1]
    assert "[queue-fill]" in house.output()


def test_a_look_that_fails_ends_nothing(ros: Ros) -> None:
    office = ros.node("office", {**OPEN, "diagnostics_period": 0.01}, BROKEN)
    ros.wait(lambda: len(ros.fired("office", "TSend")) == 3, "sending")
    ros.wait(lambda: "the node cannot determine its state" in office.output(), "the log")
    assert office.interrupt() == 0
    assert office.output().count("the node cannot determine its state") == 1
