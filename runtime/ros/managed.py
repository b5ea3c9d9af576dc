"""Managed nodes (ROS 2 design, "Managed nodes"): others decide when a node opens its channels and fires.

===========  ==========================================================================
configure    makes the net, opens its channels and journal; nothing fires yet
activate     the net fires
deactivate   the net fires nothing more; tokens and signals still arrive
cleanup      closes the channels and the journal
===========  ==========================================================================
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from dineros.runtime.ros.control import INACTIVE
from dineros.runtime.ros.process.session import LOG
from dineros.runtime.ros.running import RosNode


def make_managed_node(name: str, **options: Any) -> Any:
    """Return an rclpy node with a life cycle, which drives the node that `manage` tells how to make."""
    from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn

    success, failure = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE

    class ManagedNode(LifecycleNode):
        """Its callbacks run on the thread of the session, which is the thread of the net."""

        running: RosNode | None = None
        make: Callable[[], RosNode]

        def manage(self, make: Callable[[], RosNode]) -> None:
            """Make nodes in this way."""
            self.make = make

        def work(self) -> float | None:
            """Let the net do what it can, where there is one."""
            return None if self.running is None else self.running.work()

        def finish(self) -> None:
            """Close what is open."""
            running, self.running = self.running, None
            if running is not None:
                running.close("stopped")

        def on_configure(self, state: Any) -> Any:
            """Open the channels."""
            try:
                running = self.make()
                running.net.halt(INACTIVE)
                running.control.is_active = False
                running.open()
            except Exception as error:
                LOG.error("cannot be configured: %s", error)
                return failure
            self.running = running
            return success

        def on_activate(self, state: Any) -> Any:
            """Let the net fire."""
            assert self.running is not None
            self.running.control.is_active = True
            self.running.net.proceed()
            return super().on_activate(state)

        def on_deactivate(self, state: Any) -> Any:
            """Let the net fire nothing more."""
            assert self.running is not None
            self.running.control.is_active = False
            self.running.net.halt(INACTIVE)
            return super().on_deactivate(state)

        def on_cleanup(self, state: Any) -> Any:
            """Close the channels."""
            self.finish()
            return success

        def on_shutdown(self, state: Any) -> Any:
            """Close the channels."""
            self.finish()
            return success

    return ManagedNode(name, **options)
