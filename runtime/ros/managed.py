"""Managed nodes (ROS 2 design, "Managed nodes"): others decide when a node opens its channels and fires.

===========  ==========================================================================
configure    makes the net, opens its channels and journal; nothing fires yet
activate     the net fires
deactivate   the net fires nothing more; tokens and signals still arrive
cleanup      closes the channels and the journal
===========  ==========================================================================

So it is for a node whose model knows no lifecycle. Where the model has one, its net fires while it is
inactive, too, unless it pauses; what it publishes then is lost, as lifecycle publishers lose it. Each change
is a step of its journal, and a node that continues comes back in the state that it had.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from dineros.runtime.ros.control import INACTIVE
from dineros.runtime.ros.process.session import LOG
from dineros.runtime.ros.running import RosNode


def make_managed_node(name: str, **options: Any) -> Any:
    """Return an rclpy node with a life cycle, which drives the node that `manage` tells how to make."""
    from rclpy.impl.implementation_singleton import rclpy_implementation
    from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn

    RCLError = rclpy_implementation.RCLError  # noqa: N806
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
                if not running.net.core.structure.ports.is_managed:
                    running.net.halt(INACTIVE)
                running.control.is_active = False
                running.open()
                self._change(running, "configure", "unconfigured")
            except Exception as error:
                LOG.error("cannot be configured: %s", error)
                return failure
            self.running = running
            return success

        def on_activate(self, state: Any) -> Any:
            """Let the net fire."""
            assert self.running is not None
            self.running.control.is_active = True
            if not self._change(self.running, "activate", "inactive"):
                self.running.net.proceed()
            return super().on_activate(state)

        def on_deactivate(self, state: Any) -> Any:
            """Let the net fire nothing more."""
            assert self.running is not None
            self.running.control.is_active = False
            if not self._change(self.running, "deactivate", "active"):
                self.running.net.halt(INACTIVE)
            return super().on_deactivate(state)

        def on_cleanup(self, state: Any) -> Any:
            """Close the channels."""
            self._leave("cleanup")
            return success

        def on_shutdown(self, state: Any) -> Any:
            """Close the channels."""
            self._leave("shutdown")
            return success

        def _LifecycleNodeMixin__change_state(self, transition: int) -> Any:  # noqa: N802
            """Refuse what the state does not allow: rclpy would raise an error, and answer nobody."""
            try:
                return super()._LifecycleNodeMixin__change_state(transition)  # type: ignore[misc]
            except RCLError as error:
                LOG.warning("a change of state is refused: %s", error)
                return failure

        def come_back(self, state: str) -> None:
            """Have the state that the node had when its process ended."""
            if state in ("inactive", "active"):
                self.trigger_configure()  # type: ignore[no-untyped-call]
            if state == "active":
                self.trigger_activate()  # type: ignore[no-untyped-call]

        @staticmethod
        def _change(running: RosNode, label: str, before: str) -> bool:
            """Change the state of the net, unless it comes back with it; tell whether it has one."""
            core = running.net.core
            if core.structure.ports.is_managed and core.state == before:
                core.change_state(label)
            return core.structure.ports.is_managed

        def _leave(self, label: str) -> None:
            if self.running is not None and self.running.net.core.structure.ports.is_managed:
                self.running.net.core.change_state(label)
            self.finish()

    return ManagedNode(name, **options)
