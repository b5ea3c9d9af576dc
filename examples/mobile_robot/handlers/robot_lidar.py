"""What the lidar does: it publishes the distance to what is ahead."""

from __future__ import annotations

from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.runtime import Net

from . import firings

FAR = 5.0
_measured = {"ahead": FAR}


def configure(net: Net) -> None:
    """Listen to the laser; without ROS, the way is free."""
    try:
        node = net.ros_node
    except DinerosError:
        return
    from std_msgs.msg import Float32  # type: ignore[import-untyped]

    node.create_subscription(Float32, "/laser/ahead", measure, 1)


def measure(range: Any) -> None:
    """Keep what the laser says."""
    _measured["ahead"] = float(range.data)


@firings.on("TScan")
def scan(firing: firings.TScanFiring) -> firings.TScanOutcome:
    """Nothing -> Ahead."""
    return {"data": _measured["ahead"]}
