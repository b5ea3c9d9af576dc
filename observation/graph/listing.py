"""Lists a graph by rclpy, even if participants have invalid names.

Participants can announce nodes and topics with names that ROS does not allow. rclpy rejects queries about
them, and lists no node at all if one has no name. So these names are omitted here and recorded, and nodes are
found by their publishers and subscriptions if they cannot be listed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, TypeVar

from dineros.metamodel.errors import DinerosError
from dineros.observation.systems import is_name

T = TypeVar("T")

MOST_REMEMBERED = 100
"""Limit of the recorded names that were omitted."""
UNKNOWN = "_NODE_NAME_UNKNOWN_"
"""Name of the node of an endpoint before the middleware has discovered the node."""


class Listing:
    """Lists a graph.

    `node`: the node that sends queries.
    """

    def __init__(self, node: Any) -> None:
        self._node = node
        self.left_out: dict[str, None] = {}
        """Elements with a name that ROS does not allow, in words."""
        self.is_complete = True
        """Whether all endpoints that were listed last are known to be of some node."""

    def topics(self) -> Iterator[tuple[str, list[str]]]:
        """Yield topics and their types.

        Raises
        ------
        DinerosError
            The middleware does not list them.
        """
        self.is_complete = True
        for name, types in self._all(self._node.get_topic_names_and_types):
            if is_name(name):
                yield name, types
            else:
                self._leave_out("topic", name)

    def publishers(self, topic: str, *, is_raw: bool = False) -> list[Any]:
        """Return the known publishers of a topic; `is_raw`: by its name in the middleware."""
        return self._endpoints(self._node.get_publishers_info_by_topic, topic, is_raw)

    def subscribers(self, topic: str, *, is_raw: bool = False) -> list[Any]:
        """Return the known subscriptions of a topic; `is_raw`: by its name in the middleware."""
        return self._endpoints(self._node.get_subscriptions_info_by_topic, topic, is_raw)

    def nodes(self) -> list[tuple[str, str]]:
        """Return name and namespace of each node, with duplicates."""
        found: list[tuple[str, str]] | None = self._asked(self._node.get_node_names_and_namespaces)
        nodes = self._of_endpoints() if found is None else found
        kept = []
        for name, namespace in nodes:
            if is_name(f"{namespace.rstrip('/')}/{name}"):
                kept.append((name, namespace))
            else:
                self._leave_out("node", f"{namespace.rstrip('/')}/{name}")
        return kept

    def services(self, role: str, name: str, namespace: str) -> list[tuple[str, list[str]]]:
        """Return the services of a node as ``servers`` or ``clients``, and their types; none if it left."""
        ask = {
            "servers": self._node.get_service_names_and_types_by_node,
            "clients": self._node.get_client_names_and_types_by_node,
        }[role]
        kept = []
        found: list[tuple[str, list[str]]] | None = self._asked(ask, name, namespace)
        for service, types in found or []:
            if is_name(service):
                kept.append((service, types))
            else:
                self._leave_out("service", service)
        return kept

    def _endpoints(self, ask: Callable[..., list[Any]], topic: str, is_raw: bool) -> list[Any]:
        found: list[Any] = self._asked(ask, topic, is_raw) or []
        known = [info for info in found if info.node_name != UNKNOWN]
        if len(known) < len(found):
            self.is_complete = False
        return known

    def _of_endpoints(self) -> list[tuple[str, str]]:
        """Return the nodes that have an endpoint of any topic or service: a node has one as a rule."""
        self._leave_out("node", "")
        found: dict[tuple[str, str], None] = {}
        for topic, _ in self._all(self._node.get_topic_names_and_types, True):
            for infos in (self.publishers(topic, is_raw=True), self.subscribers(topic, is_raw=True)):
                found.update(dict.fromkeys((info.node_name, info.node_namespace) for info in infos))
        return list(found)

    def _all(self, ask: Callable[..., list[Any]], *arguments: Any) -> list[Any]:
        found = self._asked(ask, *arguments)
        if found is None:
            raise DinerosError(
                "the graph cannot be listed: some participant announces a name that is not text",
                hint="look for it with the tools of its middleware, or use another domain",
            )
        return found

    def _asked(self, ask: Callable[..., T], *arguments: Any) -> T | None:
        """Query rclpy; None if it rejects the query."""
        from rclpy.exceptions import InvalidHandle
        from rclpy.impl.implementation_singleton import rclpy_implementation
        from rclpy.node import NodeNameNonExistentError

        refusals = (rclpy_implementation.RCLError, NodeNameNonExistentError, ValueError, RuntimeError)
        try:
            return ask(*arguments)
        except InvalidHandle:  # the session has ended
            raise
        except refusals:
            return None

    def _leave_out(self, kind: str, name: str) -> None:
        if len(self.left_out) < MOST_REMEMBERED:
            self.left_out.setdefault(f"{kind} {name[:300]!r}: not a name that ROS 2 allows")
