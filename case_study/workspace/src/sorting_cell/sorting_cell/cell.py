"""How handlers reach the cell: over ROS topics, or in the same process when the application is simulated.

A real cell would offer the same two topics: `/cell/command` takes motions for the arms, `/cell/human` tells
what the sensor sees.
"""

from __future__ import annotations

import json
from typing import Any, Protocol

from dineros.runtime import Net

from sorting_cell.world import Operation

COMMAND_TOPIC = "/cell/command"
HUMAN_TOPIC = "/cell/human"


class Cell(Protocol):
    """What handlers ask of the cell."""

    @property
    def is_human_inside(self) -> bool:
        """What the sensor sees."""

    def command(self, operation: Operation, name: str) -> None:
        """Start a motion with an object; the input signals tell how it goes."""

    def abort(self) -> None:
        """Stop the motion for good."""


_local: Cell | None = None


def use_local(cell: Cell | None) -> None:
    """Have all nodes of this process use a cell that lives in it; None: the one on ROS."""
    global _local
    _local = cell


def connect(net: Net) -> Cell:
    """Return the cell for the handlers of a node."""
    return _local or RosCell(net)


def latched(depth: int = 10) -> Any:
    """Return the quality of service of both topics: whoever starts late gets the last message."""
    from rclpy.qos import DurabilityPolicy, QoSProfile

    return QoSProfile(depth=depth, durability=DurabilityPolicy.TRANSIENT_LOCAL)  # type: ignore[no-untyped-call]


class RosCell:
    """The cell over ROS topics, through the node that the handlers run in.

    Parameters
    ----------
    net : Net
        The net of that node.
    """

    def __init__(self, net: Net) -> None:
        from std_msgs.msg import Bool, String  # type: ignore[import-untyped]

        node = net.ros_node
        self._text = String
        self._human = False
        self._commands = node.create_publisher(String, COMMAND_TOPIC, latched())
        self._subscription = node.create_subscription(Bool, HUMAN_TOPIC, self._see, latched())

    @property
    def is_human_inside(self) -> bool:
        """What came last."""
        return self._human

    def command(self, operation: Operation, name: str) -> None:
        """Publish a motion."""
        self._publish({"operation": operation, "object": name})

    def abort(self) -> None:
        """Publish that there is to be no motion."""
        self._publish({"operation": "abort", "object": ""})

    def _publish(self, command: dict[str, str]) -> None:
        self._commands.publish(self._text(data=json.dumps(command)))

    def _see(self, message: object) -> None:
        self._human = bool(getattr(message, "data", False))
