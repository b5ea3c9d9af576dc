"""Queries nodes: whether they use simulated time, and the state of managed nodes."""

from __future__ import annotations

from typing import Any

_PARAMETERS = ("get_parameters", "rcl_interfaces/srv/GetParameters")
_STATE = ("get_state", "lifecycle_msgs/srv/GetState")


class Questions:
    """Queries each node once, as soon as possible; missing responses are ignored.

    `node`: the querying node; its callbacks are run elsewhere.
    """

    def __init__(self, node: Any) -> None:
        self._node = node
        self._able: set[tuple[str, str]] = set()
        self._clients: dict[tuple[str, str], Any] = {}
        self._futures: dict[tuple[str, str], Any] = {}

    def can_be_asked(self, node: str, service: str, type: str) -> None:
        """Record that a node has a service."""
        for word, wanted in (_PARAMETERS, _STATE):
            if service == f"{node}/{word}" and type == wanted:
                self._able.add((node, word))

    def ask(self, node: str) -> None:
        """Send a node the queries that remain, if it has the services."""
        for word, _ in (_PARAMETERS, _STATE):
            key = node, word
            if key not in self._able or key in self._futures:
                continue
            interface, request = _made(word)
            if key not in self._clients:
                self._clients[key] = self._node.create_client(interface, f"{node}/{word}")
            if self._clients[key].service_is_ready():
                self._futures[key] = self._clients[key].call_async(request)

    def answers(self, node: str) -> tuple[bool | None, str | None]:
        """Return whether a node uses simulated time, and the state of a managed node; None: unknown."""
        told, state = self._result(node, "get_parameters"), self._result(node, "get_state")
        simulated = None
        if told is not None:
            values = list(told.values)
            simulated = bool(values[0].bool_value) if values and values[0].type == 1 else None
        if (node, "get_state") not in self._able:
            return simulated, None
        return simulated, "unknown" if state is None else str(state.current_state.label)

    def close(self) -> None:
        """Destroy the clients."""
        for client in self._clients.values():
            self._node.destroy_client(client)

    def _result(self, node: str, word: str) -> Any:
        future = self._futures.get((node, word))
        if future is None or not future.done() or future.exception() is not None:
            return None
        return future.result()


def _made(word: str) -> tuple[Any, Any]:
    """Return the interface and the request of a question."""
    if word == "get_state":
        from lifecycle_msgs.srv import GetState

        return GetState, GetState.Request()
    from rcl_interfaces.srv import GetParameters

    return GetParameters, GetParameters.Request(names=["use_sim_time"])
