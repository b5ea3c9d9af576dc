"""An executor without the cost of rare events at each message.

rclpy rebuilds its set of entities to wait for at each callback, and checks each of them afterwards. Most of
that time is spent on events about publishers and subscriptions with incompatible quality of service, since
each of them has two such events. Their only effect is a warning in the log, which may come a little later.

After each callback, rclpy wakes the executor for other threads that may wait for the callback's group. With a
single thread, it wakes itself, and the set is rebuilt a second time for nothing.
"""

from __future__ import annotations

from threading import get_ident
from typing import Any

from dineros.runtime.ros.process.clocks import steady_timer

PERIOD = 2.0
"""Seconds between two checks for incompatible qualities of service."""


def calm_executor(context: Any) -> Any:
    """Return a single-threaded executor that waits for incompatibility events only if `hears_misfits` is set.

    It always waits for events for which the developers have registered their own callbacks.
    """
    from rclpy.event_handler import EventHandler
    from rclpy.executors import SingleThreadedExecutor

    can_execute = SingleThreadedExecutor.can_execute

    class CalmExecutor(SingleThreadedExecutor):
        hears_misfits = False

        def can_execute(self, entity: Any) -> bool:
            """Return whether to wait for an entity."""
            if type(entity) is EventHandler and not self.hears_misfits and _only_warns(entity):
                return False
            return bool(can_execute(self, entity))

    executor = CalmExecutor(context=context)
    _spare_own_wakes(executor)
    return executor


def _spare_own_wakes(executor: Any) -> None:
    """Prevent the spinning thread, once set as `spinner`, from waking itself: it checks anyway."""
    executor.spinner = None
    guard = getattr(executor, "_guard", None)
    if guard is None:  # another version of rclpy
        return
    wake = guard.trigger

    def trigger() -> None:
        if get_ident() != executor.spinner:
            wake()

    guard.trigger = trigger


def _only_warns(handler: Any) -> bool:
    """Return whether an event has the default callback of rclpy."""
    return getattr(handler.callback, "__module__", "") == "rclpy.event_handler"


class Misfits:
    """Checks periodically for publishers and subscriptions with incompatible quality of service."""

    def __init__(self, node: Any, executor: Any) -> None:
        self._node, self._executor = node, executor
        self.are_due = False
        self._timer = steady_timer(node, PERIOD, self._be_due)

    def _be_due(self) -> None:
        self.are_due = True

    def look(self) -> None:
        """Let rclpy warn of all known incompatibilities; on the spinning thread, if they `are_due`."""
        self.are_due = False
        self._executor.hears_misfits = True
        try:
            for _ in list(self._node.waitables):  # one callback each, if any
                self._executor.spin_once(0.0)
        finally:
            self._executor.hears_misfits = False

    def close(self) -> None:
        """Stop checking."""
        self._node.destroy_timer(self._timer)
