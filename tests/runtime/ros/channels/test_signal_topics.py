"""Signals of a node in ROS: by topic, service and parameter, by whatever quality of service."""

from __future__ import annotations

import pytest

from tests.runtime.ros.conftest import Ros


@pytest.mark.long
def test_signals_from_outside(ros: Ros) -> None:
    """By topic, by service, by parameter; the node under another name and namespace."""
    office = ros.node(
        "office", {"signals.too_late": True}, arguments=["-r", "__ns:=/town", "-r", "__node:=counter"]
    )
    ros.wait(lambda: ros.records("office", "start"), "the start")
    said = ros.script(
        "import rclpy\n"
        "from rclpy.qos import QoSProfile, DurabilityPolicy\n"
        "from std_msgs.msg import Bool\n"
        "from std_srvs.srv import SetBool\n"
        "rclpy.init()\n"
        "node = rclpy.create_node('stranger')\n"
        "latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)\n"
        "publisher = node.create_publisher(Bool, '/town/counter/signals/Open', latched)\n"
        "publisher.publish(Bool(data=True))\n"
        "client = node.create_client(SetBool, '/town/counter/set_signal/too_late')\n"
        "assert client.wait_for_service(30)\n"
        "future = client.call_async(SetBool.Request(data=False))\n"
        "rclpy.spin_until_future_complete(node, future, timeout_sec=30)\n"
        "print(future.result().success, future.result().message)\n"
        "while not publisher.get_subscription_count():\n"
        "    rclpy.spin_once(node, timeout_sec=0.05)\n"
        "publisher.wait_for_all_acked(rclpy.duration.Duration(seconds=10))\n"
        "rclpy.shutdown()\n"
    )
    assert said == "True too-late is false\n"
    ros.wait(lambda: len(ros.fired("office", "TSend")) == 3, "sending")
    changes = {(r["signal"], r["value"], r["source"]) for r in ros.records("office", "signal")}
    assert changes == {
        ("too-late", True, "parameter"),
        ("too-late", False, "service"),
        ("Open", True, "topic"),
    }
    assert office.interrupt() == 0


def test_publisher_with_default_quality(ros: Ros) -> None:
    """It matches; what a latched publisher sends comes by two subscriptions and counts once, in order."""
    ros.node("office")
    ros.wait(lambda: ros.records("office", "start"), "the start")
    ros.script(
        "import rclpy, time\n"
        "from rclpy.qos import QoSProfile, DurabilityPolicy\n"
        "from std_msgs.msg import Bool, String\n"
        "rclpy.init()\n"
        "node = rclpy.create_node('stranger')\n"
        "def publish(type, topic, quality, count, *values):\n"
        "    publisher = node.create_publisher(type, topic, quality)\n"
        "    while publisher.get_subscription_count() < count:\n"
        "        time.sleep(0.01)\n"
        "    for value in values:\n"
        "        publisher.publish(type(data=value))\n"
        "    publisher.wait_for_all_acked(rclpy.duration.Duration(seconds=30))\n"
        "    return publisher\n"
        "publish(Bool, '/office/signals/Open', 10, 1, True, False, True)\n"
        "latched = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)\n"
        "publish(Bool, '/office/signals/Open', latched, 2, False, True, False, True)\n"
        "deep = '{\"Open\":' + '[' * 100000\n"
        "publish(String, '/office/signals', 10, 1, deep, '{', '{\"Opn\": true}', 'x' * 70000)\n"
        "publish(String, '/office/signals', 10, 1, '{\"Open\": false, \"too-late\": true}')\n"
        "rclpy.shutdown()\n"
    )
    ros.wait(lambda: len(ros.records("office", "signal")) >= 9, "the signals")
    changes = [(record["signal"], record["value"]) for record in ros.records("office", "signal")]
    toggles = [value for signal, value in changes if signal == "Open"]
    assert toggles == [True, False, True, False, True, False, True, False]
    assert changes[-2:] == [("Open", False), ("too-late", True)]
    errors = [record["error"] for record in ros.records("office", "error")]
    assert len(errors) == 1
    assert errors[0].startswith("~/signals: not a truth value")
    assert ros.processes[0].output().count("incompatible QoS") == 0


def test_latched_topic_counts_each_message_once(ros: Ros) -> None:
    """What was published before comes, and what comes by two subscriptions is handed on once, in order."""
    said = ros.script(
        "import rclpy, time\n"
        "from rclpy.qos import QoSProfile, DurabilityPolicy\n"
        "from std_msgs.msg import String\n"
        "from dineros.runtime.ros.channels.latched import LatchedTopic\n"
        "rclpy.init()\n"
        "node, other = rclpy.create_node('node'), rclpy.create_node('stranger')\n"
        "latched = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)\n"
        "publisher = other.create_publisher(String, '/node/topic', latched)\n"
        "default = other.create_publisher(String, '/node/topic', 10)\n"
        "publisher.publish(String(data='before'))\n"
        "default.publish(String(data='gone'))\n"
        "got = []\n"
        "topic = LatchedTopic(node, String, '~/topic', lambda message: got.append(message.data))\n"
        "def spin(last):\n"
        "    while got[-1:] != [last]:\n"
        "        rclpy.spin_once(node, timeout_sec=0.05)\n"
        "while publisher.get_subscription_count() < 2 or default.get_subscription_count() < 1:\n"
        "    rclpy.spin_once(node, timeout_sec=0.05)\n"
        "spin('before')\n"
        "for number in range(5):\n"
        "    publisher.publish(String(data=f'latched {number}'))\n"
        "spin('latched 4')\n"
        "for number in range(5):\n"
        "    default.publish(String(data=f'default {number}'))\n"
        "spin('default 4')\n"
        "for _ in range(5):\n"
        "    rclpy.spin_once(node, timeout_sec=0.05)\n"
        "print(*got, sep=',')\n"
        "rclpy.shutdown()\n"
    )
    numbers = range(5)
    expected = ["before", *(f"latched {n}" for n in numbers), *(f"default {n}" for n in numbers)]
    assert said.strip().split(",") == expected


def test_stale_signal(ros: Ros) -> None:
    """Parameters say after what time a signal is stale, and what is done then."""
    ros.node("office", {"stale_after.too_late": 0.2, "when_stale.too_late": True})
    ros.wait(lambda: ros.records("office", "signal"), "the fallback")
    (change,) = ros.records("office", "signal")
    assert (change["signal"], change["value"], change["source"]) == ("too-late", True, "stale")
