"""The time of a node's net: the machine's time, or that of a simulation."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, TypedDict

USE_SIM_TIME = "use_sim_time"


class Clocks(TypedDict):
    """The clock of a net and, if different, that of the machine; both return seconds."""

    clock: Callable[[], float]
    steady: Callable[[], float] | None


def clocks_of(node: Any) -> Clocks:
    """Return the clocks of a net.

    With the parameter `use_sim_time`, its time is that of ``/clock``: firing intervals, time-outs of handlers
    and delays use it. If the clock goes back, for example because the simulation restarts, the net's time
    stands still.
    """
    clock = node.get_clock()
    if not clock.ros_time_is_active:
        return {"clock": time.monotonic, "steady": None}
    passed = last = 0

    def simulated() -> float:
        nonlocal passed, last
        now = int(clock.now().nanoseconds)
        passed += max(0, now - last)
        last = now
        return passed * 1e-9

    return {"clock": simulated, "steady": time.monotonic}


def hold_time_source(node: Any) -> None:
    """Refuse later changes of `use_sim_time`: running timers use the clock with which they began."""
    from rcl_interfaces.msg import SetParametersResult

    def judge(parameters: Any) -> Any:
        now = node.get_parameter(USE_SIM_TIME).value
        is_other = any(each.name == USE_SIM_TIME and each.value != now for each in parameters)
        reason = f"{USE_SIM_TIME} can be set at the start only" if is_other else ""
        return SetParametersResult(successful=not is_other, reason=reason)

    node.add_on_set_parameters_callback(judge)


def steady_timer(node: Any, seconds: float, action: Callable[[], None], group: Any = None) -> Any:
    """Return a timer with the machine's clock, even in a simulation; by default in a group of its own."""
    from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
    from rclpy.clock import Clock
    from rclpy.clock_type import ClockType

    group, clock = group or MutuallyExclusiveCallbackGroup(), Clock(clock_type=ClockType.STEADY_TIME)
    return node.create_timer(seconds, action, callback_group=group, clock=clock)


class Alarm:
    """Wakes a node at a time of the machine's clock.

    Parameters
    ----------
    node : rclpy.node.Node
        The ROS node.
    ring : callable
        Called when the time comes; then the alarm is off.
    """

    def __init__(self, node: Any, ring: Callable[[], None]) -> None:
        self._node = node
        self._timer = steady_timer(node, 1.0, ring)
        self._timer.cancel()
        self._due: float | None = None

    def set(self, due: float | None) -> None:
        """Set the alarm to a time of `time.monotonic`, unless it is set to an earlier one; None: ignored."""
        if due is not None and (self._due is None or due < self._due):
            self._due = due
            self._timer.timer_period_ns = max(1, int((due - time.monotonic()) * 1e9))
            self._timer.reset()

    def silence(self) -> None:
        """Turn the alarm off until it is set again."""
        self._due = None
        self._timer.cancel()

    def close(self) -> None:
        """Destroy the timer."""
        self._node.destroy_timer(self._timer)
