"""The cell that the nodes work in: an arm's drive, a gate, buttons, and a person who comes near.

``python examples/sorting_actions/cell.py`` runs next to the nodes until it gets a signal to end. It gets the
commands of `/cell/arm` and `/cell/gate`, and sets the nodes' signals, latched, so that a
node that is started again hears what holds. The arm hears nothing before its first command has come: "at
rest" would be taken for the end of a motion that the cell, if it starts later, does not know of yet.
"""

from __future__ import annotations

import argparse
import json
import signal
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

COLORS = ("Red", "Blue", "Green")
PERIOD = 0.05


@dataclass
class Cell:
    """What is so in the cell; time is what `advance` is told.

    Attributes
    ----------
    tell : callable
        Takes a node and all its signals, whenever one of them has changed.
    motion_time, brake_time : float
        Seconds that the arm needs for a motion, and to come to rest.
    visit_every : int
        A person comes near in each motion with such a number, half way; 0: never.
    stay : float
        Seconds that the person stays.
    accidents : int
        Moments at which the arm moved and the gate was open.
    """

    tell: Callable[[str, dict[str, bool]], None]
    motion_time: float = 0.4
    brake_time: float = 0.1
    visit_every: int = 0
    stay: float = 1.0
    log: Callable[[str], object] = lambda line: None
    accidents: int = 0
    motions: int = 0
    stopped: int = 0
    is_gate_open: bool = False
    _now: float = 0.0
    _motion: tuple[str, str] | None = None
    _left: float = 0.0
    _held: str | None = None
    _is_commanded: bool = False
    _comes_at: float | None = None
    _goes_at: float | None = None
    _told: dict[str, dict[str, bool]] = field(default_factory=dict)

    def command(self, motion: str, piece: str) -> None:
        """Move, or brake; a command that comes again while the arm moves changes nothing."""
        self._is_commanded = True
        if motion == "brake":
            if self._motion is not None and self._motion[0] != "brake":
                self.stopped += 1
                self._motion, self._left = ("brake", piece), self.brake_time
                self.log(f"brakes with {piece}")
        elif self._motion != (motion, piece):
            self.motions += 1
            is_done = (motion == "pick") is (self._held == piece)  # by a command before a restart
            self._motion, self._left = (motion, piece), self.brake_time if is_done else self.motion_time
            self.log(f"{motion}s {piece}")
            if self.visit_every and self.motions % self.visit_every == 0 and self._goes_at is None:
                self._comes_at = self._now + self.motion_time / 2
        self.tell_all()

    def gate(self, is_open: bool) -> None:
        """Open or shut the gate."""
        if is_open is not self.is_gate_open:
            self.log(f"gate {'opens' if is_open else 'is shut'}")
        self.is_gate_open = is_open
        self.tell_all()

    def advance(self, seconds: float) -> None:
        """Let time pass."""
        self._now += seconds
        if self._motion is not None:
            self.accidents += self.is_gate_open
            self._left -= seconds
            if self._left <= 0:
                motion, piece = self._motion
                if motion != "brake":
                    self._held = piece if motion == "pick" else None
                self._motion = None
        if self._comes_at is not None and self._now >= self._comes_at:
            self._comes_at, self._goes_at = None, self._now + self.stay
            self.log("a person comes near")
        if self._goes_at is not None and self._now >= self._goes_at:
            self._goes_at = None
            self.log("the person goes")
        self.tell_all()

    def tell_all(self) -> None:
        """Tell each node its signals, where they have changed."""
        pressed = int(self._now / 0.3) % (2 * len(COLORS))  # the buttons in turn: down, up, the next one
        arm = {"AtRest": self._motion is None, "Holding": self._held is not None}
        signals = {
            **({"arm": arm} if self._is_commanded else {}),
            "guard": {"PersonNear": self._goes_at is not None, "GateShut": not self.is_gate_open},
            "selector": {color: 2 * number == pressed for number, color in enumerate(COLORS)},
        }
        for node, values in signals.items():
            if self._told.get(node) != values:
                self._told[node] = values
                self.tell(node, values)


def main() -> int:
    """Run the cell on ROS; the exit status is 1 where the arm ever moved while the gate was open."""
    import rclpy
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_msgs.msg import Bool, String

    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--motion-time", type=float, default=0.4, help="seconds of a motion")
    parser.add_argument(
        "--visit-every", type=int, default=3, help="a person comes in each such motion; 0: never"
    )
    parser.add_argument("--stay", type=float, default=1.0, help="seconds that a person stays")
    options = parser.parse_args()
    ends = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ends.set())
    rclpy.init(signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
    node: Any = rclpy.create_node("cell")
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publishers = {
        name: node.create_publisher(String, f"/{name}/signals", latched)
        for name in ("arm", "guard", "selector")
    }

    def tell(name: str, values: dict[str, bool]) -> None:
        publishers[name].publish(String(data=json.dumps(values)))

    cell = Cell(
        tell,
        options.motion_time,
        visit_every=options.visit_every,
        stay=options.stay,
        log=node.get_logger().info,
    )

    def command(message: String) -> None:
        wanted = json.loads(message.data)
        cell.command(wanted["motion"], wanted["piece"])

    node.create_subscription(String, "/cell/arm", command, latched)
    node.create_subscription(Bool, "/cell/gate", lambda message: cell.gate(message.data), latched)
    last = time.monotonic()

    def tick() -> None:
        nonlocal last
        now = time.monotonic()
        cell.advance(now - last)
        last = now

    node.create_timer(PERIOD, tick)
    while not ends.is_set():
        rclpy.spin_once(node, timeout_sec=0.1)
    node.destroy_node()
    rclpy.shutdown()
    return 1 if cell.accidents else 0


if __name__ == "__main__":
    raise SystemExit(main())
