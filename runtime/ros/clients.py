"""The clients of a node: one request under way each, with a time-out.

A request whose server never answers would leave a future that never completes: the queues of a busy server
drop requests, and nobody is told. Here the node is told, and asks again with the same id.
"""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import Any

from dineros.runtime.ros.codecs import Codecs
from dineros.runtime.ros.messages import Codec
from dineros.runtime.ros.quality import service_quality
from dineros.runtime.ros.session import LOG, RosError
from dineros.runtime.transport import ClientPort, Message, Receiver

PERIOD = 0.05
"""Seconds between looks for servers that came and for requests whose time is over."""


@dataclass(eq=False)
class _Call:
    """A request under way; `future` is None until the server is there."""

    message: Message
    deadline: float
    future: Any = None


@dataclass(eq=False)
class _Client:
    port: ClientPort
    entity: Any
    requests: Codec
    responses: Codec
    call: _Call | None = None


class Clients:
    """The service clients of a ROS node.

    Parameters
    ----------
    node : rclpy.node.Node
        The ROS node.
    receiver : Receiver
        Told of responses and time-outs.
    timeout : float
        Seconds that a request may take.
    """

    def __init__(self, node: Any, receiver: Receiver, timeout: float) -> None:
        self._node = node
        self._receiver = receiver
        self._timeout = timeout
        self._clients: dict[tuple[str, str], _Client] = {}
        self._lock = threading.Lock()
        self._timer: Any = None

    def add(self, port: ClientPort, codecs: Codecs) -> Codec:
        """Make the client of a port, and return the codec of its requests.

        Raises
        ------
        RosError
            ROS refuses its name.
        InterfaceError
            Its interface is not installed, or does not fit the model.
        """
        from rclpy.callback_groups import MutuallyExclusiveCallbackGroup

        interface, requests, responses = codecs.service(port)
        try:
            entity = self._node.create_client(
                interface,
                port.service,
                qos_profile=service_quality(),
                callback_group=MutuallyExclusiveCallbackGroup(),
            )
        except Exception as error:
            raise RosError(f"the service {port.service!r} cannot be asked: {error}") from error
        self._clients[port.channel, port.client] = _Client(port, entity, requests, responses)
        if self._timer is None:
            self._timer = self._node.create_timer(
                PERIOD, self._look, callback_group=MutuallyExclusiveCallbackGroup()
            )
        return requests

    def request(self, port: ClientPort, message: Message) -> None:
        """Send a request, now or when its server is there; what was under way is given up."""
        client = self._clients[port.channel, port.client]
        call = _Call(message, time.monotonic() + self._timeout)
        with self._lock:
            former, client.call = client.call, call
        if former is not None and former.future is not None:
            client.entity.remove_pending_request(former.future)
        if client.entity.service_is_ready():
            self._send(client, call)

    def _send(self, client: _Client, call: _Call) -> None:
        request = client.requests.encode(call.message)
        call.future = client.entity.call_async(request)
        call.future.add_done_callback(lambda future: self._done(client, call, future))

    def _done(self, client: _Client, call: _Call, future: Any) -> None:
        with self._lock:
            if client.call is not call:
                return
            client.call = None
        try:
            response = client.responses.decode(future.result())
        except Exception as error:
            self._receiver.request_failed(client.port, call.message.id, f"no response: {error}")
            return
        if response.id not in ("", call.message.id):
            self._receiver.request_failed(client.port, call.message.id, "the response has another id")
            return
        # Servers that know nothing of DiNeROS give no ids back; the future knows which request it was.
        self._receiver.response_arrived(client.port, Message(response.id or call.message.id, response.data))

    def _look(self) -> None:
        """Send what waited for a server, give up what took too long."""
        now = time.monotonic()
        for client in self._clients.values():
            call = client.call
            if call is None:
                continue
            if call.future is None and client.entity.service_is_ready():
                try:
                    self._send(client, call)
                except Exception as error:
                    self._give_up(client, call, str(error))
            elif now >= call.deadline:
                reason = "there is no server" if call.future is None else "no response"
                self._give_up(client, call, f"{reason} in {self._timeout:g} s")

    def _give_up(self, client: _Client, call: _Call, reason: str) -> None:
        with self._lock:
            if client.call is not call:
                return
            client.call = None
        if call.future is not None:
            client.entity.remove_pending_request(call.future)
        LOG.debug("request %s: %s", call.message.id, reason)
        self._receiver.request_failed(client.port, call.message.id, reason)

    def close(self) -> None:
        """Take the clients down; nothing is told any more."""
        with self._lock:
            for client in self._clients.values():
                client.call = None
        if self._timer is not None:
            self._node.destroy_timer(self._timer)
            self._timer = None
        for client in self._clients.values():
            self._node.destroy_client(client.entity)
        self._clients.clear()
