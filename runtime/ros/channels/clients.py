"""The service clients of a ROS node: requests under way, each with a time-out.

If a server never responds, the future of rclpy never completes: queues of a busy server drop requests without
notice. Here the node is notified of the time-out, and sends the request again with the same id. Earlier
attempts stay valid: the first response to any attempt is delivered at once, even while the node waits before
the next attempt. Otherwise a server without ids that takes longer than the time-out could never deliver its
response.
"""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass, field
from typing import Any

from dineros.runtime.channels.transport import Receiver
from dineros.runtime.nets.ports import ClientPort, Message
from dineros.runtime.ros.channels.companions import REQUESTS, Announcer
from dineros.runtime.ros.channels.quality import SERVICE_DEPTH, reliable_quality
from dineros.runtime.ros.conversion.codecs import Codecs
from dineros.runtime.ros.conversion.messages import Codec
from dineros.runtime.ros.process.clocks import Alarm
from dineros.runtime.ros.process.session import LOG, RosError

FIRST_LOOK, LAST_LOOK = 0.05, 0.5
"""Seconds between checks for a missing server: the first delay, doubled up to the second.

ROS does not notify rclpy of new services.
"""

KEPT_ATTEMPTS = 64
"""Attempts of a request whose responses are accepted: the first one, and the last ones."""


@dataclass(eq=False)
class _PendingCall:
    """A request under way.

    Attributes
    ----------
    deadline : float or None
        Time of the time-out; None: it has timed out, and the node was notified.
    attempts : list
        The futures of the responses, one for each attempt.
    look : float
        Seconds until the next check for its server; 0: the current attempt has been sent.
    """

    message: Message
    deadline: float | None
    attempts: list[Any] = field(default_factory=list)
    look: float = FIRST_LOOK


@dataclass(eq=False)
class _RosClient:
    port: ClientPort
    entity: Any
    requests: Codec
    responses: Codec
    announcer: Announcer | None
    calls: dict[str, _PendingCall] = field(default_factory=dict)


class Clients:
    """The service clients of a ROS node.

    While no request is under way, they never wake the node.

    Parameters
    ----------
    node : rclpy.node.Node
        The ROS node.
    receiver : Receiver
        Receives responses and time-outs.
    timeout : float
        Time-out of a request, in seconds.
    """

    def __init__(self, node: Any, receiver: Receiver, timeout: float) -> None:
        self._node = node
        self._receiver = receiver
        self._timeout = timeout
        self._clients: dict[tuple[str, str], _RosClient] = {}
        self._lock = threading.Lock()
        self._alarm: Alarm | None = None

    def add(self, port: ClientPort, codecs: Codecs) -> Codec:
        """Create the client of a port, and return the codec of its requests.

        Raises
        ------
        RosError
            ROS refuses its service name.
        InterfaceError
            The interface is not installed, or does not fit the model.
        """
        from rclpy.callback_groups import MutuallyExclusiveCallbackGroup

        interface, requests, responses = codecs.service(port)
        announcer = None
        try:
            if port.type is not None:
                name = f"{self._node.resolve_service_name(port.service)}/{REQUESTS}"
                announcer = Announcer(self._node, name, port.outstanding)
            entity = self._node.create_client(
                interface,
                port.service,
                qos_profile=reliable_quality(SERVICE_DEPTH),
                callback_group=MutuallyExclusiveCallbackGroup(),
            )
        except Exception as error:
            raise RosError(f"the service {port.service!r} cannot be called: {error}") from error
        self._clients[port.channel, port.client] = _RosClient(port, entity, requests, responses, announcer)
        self._alarm = self._alarm or Alarm(self._node, self._look)
        return requests

    def request(self, port: ClientPort, message: Message) -> None:
        """Send a request once its server is available; if it is under way, send it again."""
        client = self._clients[port.channel, port.client]
        now = time.monotonic()
        with self._lock:
            call = client.calls.setdefault(message.id, _PendingCall(message, None))
            call.deadline, call.look = now + self._timeout, FIRST_LOOK
        if client.entity.service_is_ready():
            self._send(client, call)
        self._look_in_time(call, now)

    def forget(self, port: ClientPort, message_id: str) -> None:
        """Stop waiting for the response to a request."""
        client = self._clients[port.channel, port.client]
        with self._lock:
            call = client.calls.pop(message_id, None)
        if call is not None:
            self._forget(client, call)

    def _send(self, client: _RosClient, call: _PendingCall) -> None:
        request = client.requests.encode(call.message)
        call.look = 0.0
        if client.announcer is None:
            future = client.entity.call_async(request)
        else:
            future = client.announcer.send(call.message.id, request, client.entity.call_async)
        call.attempts.append(future)
        if len(call.attempts) > KEPT_ATTEMPTS:
            client.entity.remove_pending_request(call.attempts.pop(1))
        future.add_done_callback(lambda future: self._done(client, call, future))

    def _done(self, client: _RosClient, call: _PendingCall, future: Any) -> None:
        with self._lock:
            if client.calls.get(call.message.id) is not call:
                return
            del client.calls[call.message.id]
        self._forget(client, call)
        try:
            response = client.responses.decode(future.result())
        except Exception as error:
            self._receiver.request_failed(client.port, call.message.id, f"no response: {error}")
            return
        if response.id not in ("", call.message.id):
            self._receiver.request_failed(client.port, call.message.id, "the response has another id")
            return
        # Servers without DiNeROS return no ids; the future identifies the request.
        self._receiver.response_arrived(client.port, Message(response.id or call.message.id, response.data))

    def _look_in_time(self, call: _PendingCall, now: float) -> None:
        """Set the alarm to the next time at which a request needs an action, unless it is earlier already."""
        due = call.deadline
        if due is not None and call.look:
            due = min(due, now + call.look)
        with self._lock:
            if self._alarm is not None:
                self._alarm.set(due)

    def _look(self) -> None:
        """Send requests that waited for a server, report time-outs; then sleep as long as possible."""
        now = time.monotonic()
        with self._lock:
            if self._alarm is not None:
                self._alarm.silence()
        for client, call in self._waiting():
            if call.deadline is None:
                continue
            if call.look and client.entity.service_is_ready():
                try:
                    self._send(client, call)
                except Exception as error:
                    self._tell(client, call, str(error))
            elif now >= call.deadline:
                reason = "no server is available" if call.look else "no response"
                self._tell(client, call, f"{reason} in {self._timeout:g} s")
            elif call.look:
                call.look = min(LAST_LOOK, 2 * call.look)
            self._look_in_time(call, now)

    def _waiting(self) -> list[tuple[_RosClient, _PendingCall]]:
        with self._lock:
            return [(client, call) for client in self._clients.values() for call in client.calls.values()]

    def _tell(self, client: _RosClient, call: _PendingCall, reason: str) -> None:
        """Report the time-out of a request to the node; a later response is still accepted."""
        with self._lock:
            if client.calls.get(call.message.id) is not call:
                return
            call.deadline = None
        LOG.debug("request %s: %s", call.message.id, reason)
        self._receiver.request_failed(client.port, call.message.id, reason)

    def _forget(self, client: _RosClient, call: _PendingCall) -> None:
        """Stop waiting for any response to a request."""
        for future in call.attempts:
            client.entity.remove_pending_request(future)

    def close(self) -> None:
        """Destroy the clients; no further events are reported."""
        with self._lock:
            for client in self._clients.values():
                client.calls.clear()
            alarm, self._alarm = self._alarm, None
        if alarm is not None:
            alarm.close()
        for client in self._clients.values():
            self._node.destroy_client(client.entity)
            if client.announcer is not None:
                client.announcer.close()
        self._clients.clear()
