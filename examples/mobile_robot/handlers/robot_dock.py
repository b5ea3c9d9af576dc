"""What the dock does: it wakes the camera, has the robot come home, and lets the camera rest again."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.runtime import Net

from . import firings

HOME = (0.0, 0.0)
PATIENCE = 1.0  # seconds for an answer of the camera
AGAIN = 0.2  # seconds between two calls to come home: wheels that have just started may miss one
_camera: dict[str, Callable[[str], bool]] = {"change": lambda label: True}


def configure(net: Net) -> None:
    """Connect the wheels and the camera; without ROS, there are none."""
    try:
        node = net.ros_node
    except DinerosError:
        return
    from geometry_msgs.msg import Point  # type: ignore[import-untyped]
    from lifecycle_msgs.srv import ChangeState, GetState  # type: ignore[import-untyped]

    publisher = node.create_publisher(Point, "/wheels/target", 10)
    changes = node.create_client(ChangeState, "/camera/change_state")
    states = node.create_client(GetState, "/camera/get_state")

    def come() -> None:
        """Have the robot come home while it searches, also where this or its world was started again."""
        if net.count("Dock[1].Searching"):
            publisher.publish(Point(x=HOME[0], y=HOME[1], z=1.0))

    def change(label: str) -> bool:
        """Ask the camera for a state, as any manager does; return whether it has it."""
        transition, state = {"activate": (3, 3), "deactivate": (4, 2)}[label]
        request = ChangeState.Request()
        request.transition.id = transition
        ask(changes, request)
        answer = ask(states, GetState.Request())
        return answer is not None and answer.current_state.id == state

    node.create_timer(AGAIN, come)
    _camera["change"] = change


def ask(client: Any, request: Any) -> Any:
    """Return the answer, None where there is none in time."""
    answered = threading.Event()
    future = client.call_async(request)
    future.add_done_callback(lambda _: answered.set())
    return future.result() if answered.wait(PATIENCE) else None


@firings.on("TSearch", thread=True)
def search(firing: firings.TSearchFiring) -> firings.Outcome:
    """DockEntry + Free -> Searching: pictures are wanted now, and the robot."""
    while not _camera["change"]("activate"):
        time.sleep(0.2)
    return {"note": "searching"}


@firings.on("TUndock", thread=True)
def undock(firing: firings.TUndockFiring) -> firings.Outcome:
    """Docked + Full -> DockExit + Free: no pictures are wanted on the way."""
    _camera["change"]("deactivate")
    return {"note": "charged"}
