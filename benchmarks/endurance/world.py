"""The world of the flooded case study: a human who walks in and out of the cell without end."""

from __future__ import annotations

import json
import signal
import sys
import threading
from typing import Any

import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Bool, String

#: Seconds that the human stays in the cell, and out of it.
INSIDE, OUTSIDE = 4.0, 0.5


def main() -> int:
    """Walk in and out of the cell, as the world of the nodes, until it gets a signal to end."""
    ends = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ends.set())
    rclpy.init(signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
    node: Any = rclpy.create_node("cell")
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    human = node.create_publisher(Bool, "/cell/human", latched)
    sensor, danger = (
        node.create_publisher(String, f"/{name}/signals", latched) for name in ("sensorics", "executor")
    )
    sensor.publish(String(data=json.dumps({"Sensor": True})))
    is_inside = False
    while not ends.wait(INSIDE if is_inside else OUTSIDE):
        is_inside = not is_inside
        human.publish(Bool(data=is_inside))
        danger.publish(String(data=json.dumps({"Danger": is_inside, "RobotIsIdle": True})))
    node.destroy_node()
    rclpy.shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
