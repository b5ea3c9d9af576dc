"""The status of a node on ROS, and services to control a halted node.

==============  ========================  ========================================================
``~/state``     ``std_msgs/msg/String``   its status as JSON, latched
``~/proceed``   ``std_srvs/srv/Trigger``  a halted node continues
``~/release``   ``std_srvs/srv/Trigger``  tokens that were put aside may be taken again; a halted
                                          node releases its firings in flight
``~/describe``  ``std_srvs/srv/Trigger``  its description as JSON: places, transitions, ports, handlers
==============  ========================  ========================================================
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from dineros.metamodel.ros_names import CONTROLS, STATE
from dineros.runtime.nodes.description import description_of
from dineros.runtime.nodes.net import Net
from dineros.runtime.nodes.status import Status
from dineros.runtime.ros.channels.quality import reliable_quality
from dineros.runtime.ros.process.session import LOG

INACTIVE = "the node is not active"
"""Reason of the halt of a managed node that is not active."""


class Control:
    """The status topic and the services of one node.

    Parameters
    ----------
    node : rclpy.node.Node
        The ROS node.
    net : Net
        Its net.
    said : callable
        Called with each published status, from any thread.

    Attributes
    ----------
    is_active : bool
        Whether it may proceed; for a managed node, only while it is active.
    """

    def __init__(self, node: Any, net: Net, said: Callable[[Status], None] = lambda status: None) -> None:
        self._node = node
        self._net = net
        self._told = said
        self.is_active = True
        self._lock = threading.Lock()
        self._said: Status | None = None
        self._publisher: Any = None
        self._services: list[Any] = []

    def open(self) -> None:
        """Create the topic and the services, and publish the status."""
        from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
        from rclpy.event_handler import PublisherEventCallbacks
        from std_msgs.msg import String
        from std_srvs.srv import Trigger

        self._publisher = self._node.create_publisher(
            String,
            f"~/{STATE}",
            reliable_quality(is_kept=True),
            # Its quality of service matches every request, so there are no events to report; events cost time
            # at
            # each message of the node.
            event_callbacks=PublisherEventCallbacks(use_default_callbacks=False),
        )
        for name, answer in zip(CONTROLS, (self._proceed, self._release, self._describe), strict=True):

            def answered(request: Any, response: Any, answer: Any = answer) -> Any:
                response.success, response.message = answer()
                return response

            group = MutuallyExclusiveCallbackGroup()
            self._services.append(
                self._node.create_service(Trigger, f"~/{name}", answered, callback_group=group)
            )
        self._net.core.observers.on_status = self._say
        self._say()

    def _say(self) -> None:
        """Publish the status if it has changed; from any thread."""
        from std_msgs.msg import String

        with self._lock:
            status = self._net.status
            if self._publisher is None or replace(status, time=0.0) == self._said:
                return
            self._said = replace(status, time=0.0)
            self._publisher.publish(String(data=status.json()))
        self._told(status)

    def _proceed(self) -> tuple[bool, str]:
        halted = self._net.core.execution.halted
        if halted is None:
            return False, "the node is not halted"
        if not self.is_active:
            return False, f"{INACTIVE}: activate it"
        LOG.info("received the request to proceed")
        self._net.proceed()
        return True, f"the node continues; it was halted: {halted}"

    def _release(self) -> tuple[bool, str]:
        state = self._net.inspect()
        given_up = self._net.give_up() if state.halted is not None else []
        self._net.release()
        said = [f"{transition} may take the tokens again that were set aside" for transition in state.aside]
        said += [f"{transition} is released" for transition in given_up]
        LOG.info("released on request: %s", ", ".join(said) or "nothing")
        return bool(said), ", ".join(said) or "no token is set aside or, in a halted node, in flight"

    def _describe(self) -> tuple[bool, str]:
        return True, json.dumps(
            {"name": self._node.get_fully_qualified_name(), **description_of(self._net.core)}
        )

    def close(self) -> None:
        """Destroy the topic and the services."""
        with self._lock:
            self._net.core.observers.on_status = None
            publisher, self._publisher = self._publisher, None
        if publisher is not None:
            self._node.destroy_publisher(publisher)
        for service in self._services:
            self._node.destroy_service(service)
        self._services.clear()
