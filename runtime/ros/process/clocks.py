"""The time that a node's net goes by: the machine's, or that of a simulation."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any


def clock_of(node: Any) -> Callable[[], float]:
    """Return what tells a net's time in seconds.

    With the parameter `use_sim_time`, it is the time that is published on ``/clock``, which never goes back
    here; firing intervals, periods of timer callbacks, time-outs of handlers and delays all go by it.

    Parameters
    ----------
    node : rclpy.node.Node
        The ROS node.
    """
    if not node.get_parameter("use_sim_time").value:
        return time.monotonic
    clock, latest = node.get_clock(), 0.0

    def simulated() -> float:
        nonlocal latest
        latest = max(latest, float(clock.now().nanoseconds) * 1e-9)
        return latest

    return simulated
