"""The timers of a node's callbacks, as timers of rclpy on the clock of the ROS node.

A timer of rclpy whose callback is late continues at the next multiple of its period; missed ticks are lost.
The callback only notifies the node; the node knows whether it has begun the previous callback.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from dineros.runtime.nets.ports import TimerPort
from dineros.runtime.ros.channels.parameters import declare, period_parameters


class RosTimers:
    """The timers of a ROS node.

    Raises
    ------
    RosError
        A parameter is not a valid period.
    """

    def __init__(self, node: Any, timers: Sequence[TimerPort], ticked: Callable[[TimerPort], None]) -> None:
        self._node = node
        self._ticked = ticked
        parameters = period_parameters((timer.callback, timer.period) for timer in timers)
        self._periods = {timer: float(declare(node, parameters[timer.callback])) for timer in timers}
        self._entities: list[Any] = []

    def start(self) -> None:
        """Start the timers."""
        from rclpy.callback_groups import MutuallyExclusiveCallbackGroup

        for timer, period in self._periods.items():
            group, tick = MutuallyExclusiveCallbackGroup(), partial(self._ticked, timer)
            self._entities.append(self._node.create_timer(period, tick, callback_group=group))

    def close(self) -> None:
        """Stop the timers."""
        for entity in self._entities:
            self._node.destroy_timer(entity)
        self._entities.clear()
