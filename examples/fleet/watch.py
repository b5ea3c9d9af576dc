"""A program that knows nothing of DiNeROS: switches the fleet's signals on, and counts arrivals.

``python examples/fleet/watch.py 6`` ends when six missions have arrived.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any

import rclpy
from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from std_srvs.srv import SetBool

SIGNALS = {
    "/map_server": ["MapAvailable"],
    "/fleet/ada": ["AdaAtGoal"],
    "/fleet/bob": ["BobAtGoal"],
    "/dock": ["BatteryFull"],
    "/dispatcher": ["NewOrder"],
}
SECONDS = 120.0


def main() -> int:
    """Wait for the arrivals; print them as JSON."""
    wanted = int(sys.argv[1])
    rclpy.init()
    node: Any = Node("watch")
    arrivals: list[tuple[str, float, float]] = []

    def arrived(pose: PoseStamped) -> None:
        position = pose.pose.position
        arrivals.append((pose.header.frame_id, position.x, position.y))

    node.create_subscription(PoseStamped, "/fleet/arrivals", arrived, 10)
    end = time.monotonic() + SECONDS
    for owner, signals in SIGNALS.items():
        for signal in signals:
            client = node.create_client(SetBool, f"{owner}/set_signal/{signal}")
            if not client.wait_for_service(end - time.monotonic()):
                print(f"nobody serves {client.srv_name}", file=sys.stderr)
                return 1
            future: Any = client.call_async(SetBool.Request(data=True))
            rclpy.spin_until_future_complete(node, future, timeout_sec=end - time.monotonic())
            if not (future.done() and future.result().success):
                print(f"{client.srv_name} does not answer", file=sys.stderr)
                return 1
    while len(arrivals) < wanted and time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.2)
    print(json.dumps(arrivals))
    node.destroy_node()
    rclpy.shutdown()
    return 0 if len(arrivals) >= wanted else 1


if __name__ == "__main__":
    sys.exit(main())
