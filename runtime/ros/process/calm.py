"""An executor that does not pay at each message for what hardly ever happens.

rclpy puts together again what it waits for at each callback, and looks at each of its parts after it; what
tells of publishers and subscribers that do not fit takes most of that time, since each of them has two such
parts. All that follows from it is a warning in the log, which may come a little later.

After each callback rclpy wakes the executor, for other threads that may wait for the callback's group; where
there is one thread, it wakes itself, and all is put together a second time for nothing.
"""

from __future__ import annotations

from threading import get_ident
from typing import Any

from dineros.runtime.ros.process.clocks import steady_timer

PERIOD = 2.0
"""Seconds between two looks for misfits."""


def calm_executor(context: Any) -> Any:
    """Return a single-threaded executor that waits for misfits only while `hears_misfits` is set.

    Events that the developers have callbacks of their own for are always waited for.
    """
    from rclpy.event_handler import EventHandler
    from rclpy.executors import SingleThreadedExecutor

    can_execute = SingleThreadedExecutor.can_execute

    class CalmExecutor(SingleThreadedExecutor):
        hears_misfits = False

        def can_execute(self, entity: Any) -> bool:
            """Return whether to wait for something."""
            if type(entity) is EventHandler and not self.hears_misfits and _only_warns(entity):
                return False
            return bool(can_execute(self, entity))

    executor = CalmExecutor(context=context)
    _spare_own_wakes(executor)
    return executor


def _spare_own_wakes(executor: Any) -> None:
    """Let the thread that spins, once it is noted as `spinner`, wake it no more: it looks anyway."""
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
    """Return whether an event has the callback that rclpy gives those who give none."""
    return getattr(handler.callback, "__module__", "") == "rclpy.event_handler"


class Misfits:
    """Looks from time to time for publishers and subscribers that do not fit.

    Parameters
    ----------
    node : rclpy.node.Node
        The node.
    executor : CalmExecutor
        Its executor.
    """

    def __init__(self, node: Any, executor: Any) -> None:
        self._node, self._executor = node, executor
        self.are_due = False
        self._timer = steady_timer(node, PERIOD, self._be_due)

    def _be_due(self) -> None:
        self.are_due = True

    def look(self) -> None:
        """Let rclpy warn of all that is known now; on the thread that spins, when they `are_due`."""
        self.are_due = False
        self._executor.hears_misfits = True
        try:
            for _ in list(self._node.waitables):  # a callback each, if there is one at all
                self._executor.spin_once(0.0)
        finally:
            self._executor.hears_misfits = False

    def close(self) -> None:
        """Look no more."""
        self._node.destroy_timer(self._timer)
