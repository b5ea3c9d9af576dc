"""What the camera does: it takes pictures."""

from __future__ import annotations

from typing import Any

from dineros.runtime import Net

from . import firings

_number = 0
_is_in_sight = True


def configure(net: Net) -> None:
    """Open the eye; without ROS, the dock is always in sight."""
    if net.ros_node is not None:
        from std_msgs.msg import Bool  # type: ignore[import-untyped]

        net.ros_node.create_subscription(Bool, "/eye/marker", see, 1)


def see(marker: Any) -> None:
    """Keep what is in sight."""
    global _is_in_sight
    _is_in_sight = bool(marker.data)


@firings.on("TShoot")
def shoot(firing: firings.TShootFiring) -> firings.TShootOutcome:
    """Nothing -> Image."""
    global _number
    _number += 1
    return {"number": _number, "marker": _is_in_sight}
