"""What the camera does: it takes pictures."""

from __future__ import annotations

import itertools
from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.runtime import Net

from . import firings

_numbers = itertools.count(1)
_seen = {"marker": True}


def configure(net: Net) -> None:
    """Open the eye; without ROS, the dock is always in sight."""
    try:
        node = net.ros_node
    except DinerosError:
        return
    from std_msgs.msg import Bool  # type: ignore[import-untyped]

    node.create_subscription(Bool, "/eye/marker", see, 1)


def see(marker: Any) -> None:
    """Keep what is in sight."""
    _seen["marker"] = bool(marker.data)


@firings.on("TShoot")
def shoot(firing: firings.TShootFiring) -> firings.TShootOutcome:
    """Nothing -> Image."""
    return {"number": next(_numbers), "marker": _seen["marker"]}
