"""The robot's world, a program next to the nodes: wheels, a laser, an eye, and people in the way at times.

``python examples/mobile_robot/world.py`` runs until it gets a signal to end. It knows nothing of DiNeROS: it
receives ``/wheels/target``, publishes ``/laser/ahead`` and ``/eye/marker``, and sets the navigator's signals
when the robot is at its goal. Signals are latched, so that a node that is started again hears what holds.
"""

from __future__ import annotations

import argparse
import json
import math
import signal
import threading
from dataclasses import dataclass
from typing import Any

FAR, NEAR, IN_SIGHT, AT = 5.0, 0.3, 1.0, 0.05


@dataclass
class World:
    """Where the robot is, and what is around it.

    Attributes
    ----------
    speed : float
        Metres a second.
    every : int
        A person blocks each such way; 0: no person ever does.
    x, y : float
        Where the robot is; the dock is at the origin.
    target : tuple of float or None
        Where it is to go; None: it stands still.
    ways : int
        How many ways it has begun.
    """

    speed: float = 3.0
    every: int = 4
    x: float = 0.0
    y: float = 0.0
    target: tuple[float, float] | None = None
    ways: int = 0

    def go(self, x: float, y: float, moves: bool) -> None:
        """Execute the commands of the wheels."""
        target = (x, y) if moves else None
        if target is not None and target != self.target:
            self.ways += 1
        self.target = target

    def advance(self, seconds: float) -> None:
        """Let time pass."""
        if self.target is None:
            return
        dx, dy = self.target[0] - self.x, self.target[1] - self.y
        left, step = math.hypot(dx, dy), self.speed * seconds
        share = 1.0 if left <= step else step / left
        self.x, self.y = self.x + share * dx, self.y + share * dy

    @property
    def is_there(self) -> bool:
        """Whether the robot is where it was to go."""
        return self.target is not None and math.dist((self.x, self.y), self.target) < AT

    @property
    def ahead(self) -> float:
        """Metres to what is ahead."""
        is_blocked = self.every > 0 and self.ways % self.every == self.every - 1
        return NEAR if is_blocked and not self.is_there else FAR

    @property
    def sees_marker(self) -> bool:
        """Whether the dock is in sight."""
        return math.hypot(self.x, self.y) < IN_SIGHT


def main() -> int:
    """Let the world continue until it gets a signal to end."""
    import rclpy
    from geometry_msgs.msg import Point
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_msgs.msg import Bool, Float32, String

    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--period", type=float, default=0.05, help="seconds between two steps")
    parser.add_argument("--speed", type=float, default=World.speed, help="metres a second")
    parser.add_argument("--every", type=int, default=World.every, help="a person blocks each such way")
    options = parser.parse_args()
    world, ends, lock = World(options.speed, options.every), threading.Event(), threading.Lock()
    rclpy.init(signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ends.set())
    node: Any = rclpy.create_node("world")
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    at_goal = node.create_publisher(String, "/navigator/signals", latched)
    laser, eye = (
        node.create_publisher(Float32, "/laser/ahead", 1),
        node.create_publisher(Bool, "/eye/marker", 1),
    )

    def told(point: Point) -> None:
        with lock:
            world.go(point.x, point.y, point.z > 0)

    node.create_subscription(Point, "/wheels/target", told, 10)

    def step() -> None:
        with lock:
            world.advance(options.period)
            at_goal.publish(String(data=json.dumps({"AtGoal": world.is_there})))
            laser.publish(Float32(data=world.ahead))
            eye.publish(Bool(data=world.sees_marker))

    node.create_timer(options.period, step)
    while not ends.is_set():
        rclpy.spin_once(node, timeout_sec=0.2)
    node.destroy_node()
    rclpy.shutdown()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
