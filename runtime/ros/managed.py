"""Managed nodes (ROS 2 design, "Managed nodes"): a manager decides when a node opens channels and fires.

===========  ==========================================================================
configure    creates the net, opens its channels and journal; nothing fires yet
activate     the net fires
deactivate   the net stops firing; tokens and signals still arrive
cleanup      closes the channels and the journal
===========  ==========================================================================

This applies to a node whose model has no lifecycle. If the model has one, its net also fires while the node
is inactive, unless it pauses; messages published then are lost, as with lifecycle publishers. Each state
change is a record of its journal, and a restarted node restores its state.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from dineros.runtime.ros.control import INACTIVE
from dineros.runtime.ros.process.session import LOG
from dineros.runtime.ros.running import RosNode


def make_managed_node(name: str, **options: Any) -> Any:
    """Return an rclpy lifecycle node; it drives a node made by the function given to `manage`."""
    from rclpy.impl.implementation_singleton import rclpy_implementation
    from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn

    RCLError = rclpy_implementation.RCLError  # noqa: N806
    success, failure = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE

    class ManagedNode(LifecycleNode):
        """Its callbacks run on the thread of the session, which is the thread of the net."""

        running: RosNode | None = None
        make: Callable[[], RosNode]

        def manage(self, make: Callable[[], RosNode]) -> None:
            """Create nodes with this function."""
            self.make = make

        def work(self) -> float | None:
            """Let the net do its work, if there is one."""
            return None if self.running is None else self.running.work()

        def finish(self) -> None:
            """Close the node, if it is open."""
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
            """Let the net stop firing."""
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
            """Refuse a change that the state does not allow; rclpy would raise an error and not respond."""
            try:
                return super()._LifecycleNodeMixin__change_state(transition)  # type: ignore[misc]
            except RCLError as error:
                LOG.warning("a change of state is rejected: %s", error)
                return failure

        def come_back(self, state: str) -> None:
            """Restore the state that the node had when its process ended."""
            if state in ("inactive", "active"):
                self.trigger_configure()  # type: ignore[no-untyped-call]
            if state == "active":
                self.trigger_activate()  # type: ignore[no-untyped-call]

        @staticmethod
        def _change(running: RosNode, label: str, before: str) -> bool:
            """Change the state of the net, unless it restores it; return whether it has a lifecycle."""
            core = running.net.core
            if core.structure.ports.is_managed and core.state == before:
                core.change_state(label)
            return core.structure.ports.is_managed

        def _leave(self, label: str) -> None:
            if self.running is not None and self.running.net.core.structure.ports.is_managed:
                self.running.net.core.change_state(label)
            self.finish()

    return ManagedNode(name, **options)
