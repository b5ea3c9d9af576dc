"""What robots and dock sense: a program next to the fleet that sets its signals, again and again.

``python examples/fleet/world.py`` runs until it gets a signal to end. A robot is blocked for a moment on
every way, then at its goal; batteries fill; the dispatcher pauses now and then. Signals are latched, so that
a node that is started again hears what holds.
"""

from __future__ import annotations

import argparse
import json
import signal
import threading
from typing import Any

import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
#: One after the other, what holds for each node.
PHASES: list[dict[str, dict[str, bool]]] = [
    {
        "/fleet/ada": {"AdaBlocked": True, "AdaAtGoal": False},
        "/fleet/bob": {"BobBlocked": False, "BobAtGoal": True},
        "/dock": {"BatteryFull": False},
        "/dispatcher": {"Paused": False},
    },
    {
        "/fleet/ada": {"AdaBlocked": False, "AdaAtGoal": True},
        "/fleet/bob": {"BobBlocked": True, "BobAtGoal": False},
        "/dock": {"BatteryFull": True},
        "/dispatcher": {"Paused": False},
    },
    {"/dispatcher": {"Paused": True}},
]


def main() -> int:
    """Set signals until it gets a signal to end."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--period", type=float, default=0.2, help="seconds between two changes")
    options = parser.parse_args()
    ends = threading.Event()
    rclpy.init(signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ends.set())
    node: Any = rclpy.create_node("world")
    owners = ["/map_server", *PHASES[0]]
    publishers = {owner: node.create_publisher(String, f"{owner}/signals", LATCHED) for owner in owners}
    publishers["/map_server"].publish(String(data=json.dumps({"MapAvailable": True})))
    phase = 0
    while not ends.wait(options.period):
        for owner, values in PHASES[phase % len(PHASES)].items():
            publishers[owner].publish(String(data=json.dumps(values)))
        phase += 1
    node.destroy_node()
    rclpy.shutdown()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
