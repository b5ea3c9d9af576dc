"""Deadlines and liveliness of ports in Python, and negative time-outs."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.sources.reading import read_source

PROGRAM = """
import rclpy
from rclpy.duration import Duration, Infinite
from rclpy.node import Node
from rclpy.qos import LivelinessPolicy, QoSLivelinessPolicy, QoSProfile, qos_profile_sensor_data
from std_msgs.msg import String
from std_srvs.srv import Trigger

class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        period = self.declare_parameter("period", rclpy.Parameter.Type.DOUBLE).value
        qos = QOS
        CHANGE
        self.out = self.create_publisher(String, "out", qos)
        self.client = self.create_client(Trigger, "go")
        self.create_timer(1.0, self.tick)

    def tick(self):
        BODY

rclpy.init()
rclpy.spin(Robot())
"""
MANUAL = "manual_by_topic"


@pytest.mark.parametrize(
    ("qos", "change", "found"),
    [
        ("QoSProfile(depth=1, deadline=Duration(seconds=0.5))", "", (0.5, None, None)),
        ("QoSProfile(depth=1, deadline=Duration(seconds=1, nanoseconds=500000000))", "", (1.5, None, None)),
        ("QoSProfile(depth=1, deadline=Infinite)", "", (None, None, None)),
        ("QoSProfile(depth=1, deadline=Duration())", "", (None, None, None)),
        ("QoSProfile(depth=1, deadline=Duration(seconds=period))", "", ("open", None, None)),
        ("QoSProfile(depth=1, liveliness=LivelinessPolicy.MANUAL_BY_TOPIC)", "", (None, MANUAL, None)),
        ("QoSProfile(depth=1, liveliness=LivelinessPolicy.AUTOMATIC)", "", (None, None, None)),
        ("QoSProfile(depth=1, liveliness=period)", "", (None, "open", None)),
        ("QoSProfile(depth=1, liveliness_lease_duration=Duration(seconds=2))", "", (None, None, 2.0)),
        ("QoSProfile(depth=1)", "qos.deadline = Duration(seconds=3)", (3.0, None, None)),
        ("QoSProfile(depth=1)", "qos.liveliness = QoSLivelinessPolicy.MANUAL_BY_TOPIC", (None, MANUAL, None)),
        ("QoSProfile(depth=1)", "if period: qos.deadline = Duration(seconds=3)", ("open", None, None)),
        ("qos_profile_sensor_data", "qos.liveliness_lease_duration = Duration(seconds=1)", (None, None, 1.0)),
        ("QoSProfile(depth=1, deadline=Duration(seconds=1)) if period else 3", "", ("open", None, None)),
        ("10", "", (None, None, None)),
    ],
)
def test_deadlines_and_liveliness_are_read(
    tmp_path: Path, qos: str, change: str, found: tuple[object, ...]
) -> None:
    """They were ignored, so that ports that do not match were proved to match."""
    text = PROGRAM.replace("QOS", qos).replace("CHANGE", change).replace("BODY", "pass")
    (tmp_path / "robot.py").write_text(text)
    (port,) = read_source(tmp_path).nodes[0].of("publishers")
    values = [port.details.get(key) for key in ("deadline", "liveliness", "lease_duration")]
    assert tuple("open" if str(each).startswith("open") else each for each in values) == found


@pytest.mark.parametrize(
    ("body", "how"),
    [
        ("self.client.wait_for_service(timeout_sec=-1)", "time-out 0 s"),
        ("self.client.wait_for_service(-0.5)", "time-out 0 s"),
        ("self.client.wait_for_service()", "without time-out"),
        ("self.client.call(Trigger.Request(), timeout_sec=-1)", "blocks, time-out 0 s"),
        ("rclpy.spin_until_future_complete(self, rclpy.Future(), timeout_sec=-1)", "without time-out"),
    ],
)
def test_negative_time_outs_have_passed_except_in_spinning(tmp_path: Path, body: str, how: str) -> None:
    """As in rclpy: ``while not ready and timeout_sec > 0``, but ``timeout_sec < 0`` spins without end."""
    text = PROGRAM.replace("QOS", "1").replace("CHANGE", "pass").replace("BODY", body)
    (tmp_path / "robot.py").write_text(text)
    (node,) = read_source(tmp_path).nodes
    (tick,) = [each for each in node.callbacks if each.kind == "timer"]
    assert tick.effects[-1].how.endswith(how)
