"""What happens on the floor: robots are blocked for a moment, and the operator stops the floor now and then.

``python examples/dispatch/floor.py --robots 3`` runs next to the nodes until it gets a signal to end. Its
signals are latched, so that a node that is started again hears what holds.
"""

from __future__ import annotations

import argparse
import json
import signal
import threading
from collections.abc import Iterator
from typing import Any


def phases(robots: int) -> Iterator[dict[str, dict[str, bool]]]:
    """Yield, without end, the signals of each node that change next."""
    turn = 0
    while True:
        blocked = 1 + turn % robots
        yield {f"robot{n}": {f"Blocked{n}": n == blocked and turn % 2 == 1} for n in range(1, robots + 1)}
        yield {"dispatcher": {"FloorStopped": turn % 3 == 2}}
        turn += 1


def main() -> int:
    """Set signals until it gets a signal to end."""
    import rclpy
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_msgs.msg import String

    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robots", type=int, default=3)
    parser.add_argument("--period", type=float, default=0.3, help="seconds between two changes")
    options = parser.parse_args()
    ends = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ends.set())
    rclpy.init(signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
    node: Any = rclpy.create_node("floor")
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    owners = ["dispatcher", *(f"robot{n}" for n in range(1, options.robots + 1))]
    publishers = {owner: node.create_publisher(String, f"/{owner}/signals", latched) for owner in owners}
    for phase in phases(options.robots):
        for owner, values in phase.items():
            publishers[owner].publish(String(data=json.dumps(values)))
        if ends.wait(options.period):
            break
    node.destroy_node()
    rclpy.shutdown()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
