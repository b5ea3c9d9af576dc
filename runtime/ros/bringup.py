"""The manager of an application: configures and activates its managed nodes in order, then ends.

``python -m dineros.runtime.ros.bringup configure:/display activate:/display configure:/camera ...``

A restarted node that has restored its state keeps it. The exit status is 1 if a node is missing, or cannot be
configured or activated.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from typing import Any

from dineros.metamodel.lifecycles.states import STATE_AFTER, STATES_BEFORE

PATIENCE = 60.0
"""Seconds for a node to become available and to respond."""

ATTEMPTS = 5
"""Maximum number of attempts to configure or activate a node."""

PAUSE = 1.0
"""Seconds between attempts."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Configure and activate nodes according to the arguments."""
    import rclpy
    from rclpy.executors import ExternalShutdownException
    from rclpy.utilities import ok

    given = list(sys.argv[1:] if arguments is None else arguments)
    steps = [step.split(":", 1) for step in given if ":/" in step]
    rclpy.init()
    node = rclpy.create_node("bringup")
    try:
        return 0 if all(_bring(node, what, name) for what, name in steps) else 1
    except (KeyboardInterrupt, ExternalShutdownException):
        return 0
    except RuntimeError:  # raised by rclpy if the process is stopped during another call
        if ok():
            raise
        return 0
    finally:
        node.destroy_node()
        if ok():
            rclpy.shutdown()


def _bring(node: Any, what: str, name: str) -> bool:
    """Request one state change of a node, unless it has happened already; return whether it has happened."""
    from lifecycle_msgs.msg import Transition
    from lifecycle_msgs.srv import ChangeState, GetState

    ids = {"configure": Transition.TRANSITION_CONFIGURE, "activate": Transition.TRANSITION_ACTIVATE}
    state = _ask(node, GetState, f"{name}/get_state", GetState.Request())
    if state is None:
        print(f"the node {name} does not exist", file=sys.stderr)
        return False
    if state.current_state.label not in STATES_BEFORE[what]:
        return True  # restored after a restart, or changed by another manager
    for attempt in range(ATTEMPTS):
        time.sleep(PAUSE if attempt else 0)
        request = ChangeState.Request(transition=Transition(id=ids[what]))
        answer = _ask(node, ChangeState, f"{name}/change_state", request)
        if answer is not None and answer.success:
            print(f"{name} is {STATE_AFTER[what]}")
            return True
    print(f"the node {name} does not {what}", file=sys.stderr)
    return False


def _ask(node: Any, kind: Any, name: str, request: Any) -> Any:
    """Return the response of a service; None: there is none."""
    import rclpy

    client = node.create_client(kind, name)
    try:
        if not client.wait_for_service(PATIENCE):
            return None
        future = client.call_async(request)
        rclpy.spin_until_future_complete(node, future, timeout_sec=PATIENCE)
        return future.result() if future.done() else None
    finally:
        node.destroy_client(client)


if __name__ == "__main__":
    sys.exit(main())
