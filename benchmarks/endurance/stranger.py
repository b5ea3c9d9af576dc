"""A stranger who publishes on a topic of the flooded case study without end, beside the world.

It is in the domain of the nodes and offers what their subscriber asks for, so that its messages match.
``python stranger.py RATE`` publishes about so many messages a second.
"""

from __future__ import annotations

import signal
import sys
import threading
from typing import Any

import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from sorting_interfaces.msg import SortingToken  # type: ignore[import-not-found]

#: What it floods: the node that shows what was sorted reads it.
TOPIC, DEPTH = "/UITopic", 10
#: Messages that are published at once.
BURST = 10


def main() -> int:
    """Publish until it gets a signal to end."""
    rate = float(sys.argv[1])
    ends = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ends.set())
    rclpy.init(signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
    node: Any = rclpy.create_node("stranger")
    quality = QoSProfile(depth=DEPTH, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher = node.create_publisher(SortingToken, TOPIC, quality)
    sent = 0
    while not ends.wait(BURST / rate):
        for _ in range(BURST):
            sent += 1
            publisher.publish(SortingToken(color="red", name=f"stranger {sent}"))
        if sent % 10_000 == 0:
            node.get_logger().info(f"{sent} messages on {TOPIC}")
    node.destroy_node()
    rclpy.shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
