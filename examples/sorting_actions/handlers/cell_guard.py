"""What the guard does: it opens the gate and shuts it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

from dineros.metamodel.errors import DinerosError
from dineros.runtime import Net

from . import firings

TOPIC = "/cell/gate"


class Gate:
    """What opens and shuts."""

    def set(self, is_open: bool) -> None:
        """Do nothing: there is no gate yet."""


GATE = Gate()


def configure(net: Net) -> None:
    """Connect the gate."""
    with suppress(DinerosError):  # without ROS, whoever runs the node says so by `use`
        use(_gate(net))


def use(set_gate: Callable[[bool], None]) -> None:
    """Open and shut this one."""
    GATE.set = set_gate  # type: ignore[method-assign]


def _gate(net: Net) -> Callable[[bool], None]:
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_msgs.msg import Bool  # type: ignore[import-untyped]

    # Kept for a gate that is started again; only the last command counts.
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher = net.ros_node.create_publisher(Bool, TOPIC, latched)
    return lambda is_open: publisher.publish(Bool(data=is_open))


@firings.on("Notice")
def notice(firing: firings.NoticeFiring) -> firings.Outcome:
    """Watching -> HoldReq, while PersonNear."""
    return {"reason": "a person is near", "number": firing.data["number"] + 1}


@firings.on("OpenGate")
def open_gate(firing: firings.OpenGateFiring) -> firings.Outcome:
    """HoldRes -> GateOpen: nothing moves, says the controller."""
    GATE.set(True)
    return {}


@firings.on("ShutGate")
def shut_gate(firing: firings.ShutGateFiring) -> firings.Outcome:
    """GateOpen -> GateShutting, while !PersonNear."""
    GATE.set(False)
    return {}
