"""The manager of an application: brings its managed nodes up, one thing after the other, and ends.

``python -m dineros.runtime.ros.bringup configure:/display activate:/display configure:/camera ...``

A node that has come back in the state that it had is left in it. It ends with status 1 where a node is not
there, or cannot be brought up.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from typing import Any

from dineros.metamodel.lifecycles.states import STATE_AFTER, STATES_BEFORE

PATIENCE = 60.0
"""Seconds that a node has to be there, and to answer."""

ATTEMPTS = 5
"""How often a node is asked that fails to be configured or activated."""

PAUSE = 1.0
"""Seconds until it is asked again."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Bring nodes up as the arguments say."""
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
    except RuntimeError:  # what rclpy raises where it is told to end within another call
        if ok():
            raise
        return 0
    finally:
        node.destroy_node()
        if ok():
            rclpy.shutdown()


def _bring(node: Any, what: str, name: str) -> bool:
    """Ask a node for one thing, unless it has been asked before; return whether it has its state then."""
    from lifecycle_msgs.msg import Transition
    from lifecycle_msgs.srv import ChangeState, GetState

    ids = {"configure": Transition.TRANSITION_CONFIGURE, "activate": Transition.TRANSITION_ACTIVATE}
    state = _ask(node, GetState, f"{name}/get_state", GetState.Request())
    if state is None:
        print(f"the node {name} is not there", file=sys.stderr)
        return False
    if state.current_state.label not in STATES_BEFORE[what]:
        return True  # it came back so, or has been told by others
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
    """Return the answer of a service; None where there is none."""
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
