"""What the guard does: it opens the gate and shuts it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.runtime import Net

from . import firings

TOPIC = "/cell/gate"


@dataclass
class Gate:
    """What opens and shuts it."""

    set: Callable[[bool], None]


GATE = Gate(lambda is_open: None)  # nothing yet


def configure(net: Net) -> None:
    """Connect the gate."""
    with suppress(DinerosError):  # without ROS, whoever runs the node says so by `use`
        use(_gate(net))


def use(set_gate: Callable[[bool], None]) -> None:
    """Open and shut this one."""
    GATE.set = set_gate


def _gate(net: Net) -> Callable[[bool], None]:
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_msgs.msg import Bool  # type: ignore[import-untyped]

    # Kept for a gate that is started again; only the last command counts.
    latched: Any = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)  # type: ignore[no-untyped-call]
    publisher = net.ros_node.create_publisher(Bool, TOPIC, latched)
    return lambda is_open: publisher.publish(Bool(data=is_open))


@firings.on("Notice")
def notice(firing: firings.NoticeFiring) -> firings.NoticeOutcome:
    """Watching -> HoldReq, while PersonNear."""
    return {"reason": "a person is near", "number": firing.data["number"] + 1}


@firings.on("OpenGate")
def open_gate(firing: firings.OpenGateFiring) -> firings.OpenGateOutcome:
    """HoldRes -> GateOpen: nothing moves, says the controller."""
    GATE.set(True)
    return {}


@firings.on("ShutGate")
def shut_gate(firing: firings.ShutGateFiring) -> firings.ShutGateOutcome:
    """GateOpen -> GateShutting, while !PersonNear."""
    GATE.set(False)
    return {}
