"""A transport between processes over a Unix socket, and the broker between them, for tests that kill nodes.

The broker keeps what it was given: a subscriber that comes back gets the history of its topics again (as
with a transient-local topic), a server that comes back the requests that it has not answered. So nothing is
lost between nodes, much comes twice, and what is missing or double in the end was lost or doubled by a node.
"""

from __future__ import annotations

import contextlib
import json
import socket
import threading
from pathlib import Path
from typing import Any

from dineros.runtime.channels.transport import Receiver, Transport
from dineros.runtime.nets.ports import ClientPort, Message, Ports, PublisherPort, ServerPort, SubscriberPort


def _send(connection: socket.socket, lock: threading.Lock, packet: dict[str, Any]) -> None:
    with lock:
        connection.sendall(json.dumps(packet).encode() + b"\n")


class SocketTransport(Transport):
    """Joins a node to a broker."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lock = threading.Lock()

    def open(self, ports: Ports, receiver: Receiver) -> None:
        self._ports, self._receiver = ports, receiver
        self._connection = socket.socket(socket.AF_UNIX)
        self._connection.connect(str(self._path))
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()
        self._send(
            kind="hello",
            topics=sorted({port.topic for port in ports.subscribers}),
            services=[port.service for port in ports.servers],
            clients=[[port.service, port.client] for port in ports.clients],
        )

    def publish(self, port: PublisherPort, message: Message) -> bool:
        self._send(kind="publish", name=port.topic, id=message.id, data=dict(message.data))
        return True

    def request(self, port: ClientPort, message: Message) -> None:
        fields = {"name": port.service, "client": port.client}
        self._send(kind="request", **fields, id=message.id, data=dict(message.data))

    def close(self) -> None:
        self._connection.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._connection.close()

    def _send(self, **packet: Any) -> None:
        _send(self._connection, self._lock, packet)

    def _read(self) -> None:
        for line in self._connection.makefile("rb"):
            packet = json.loads(line)
            message = Message(packet["id"], packet["data"])
            if packet["kind"] == "message":
                for subscriber in self._ports.subscribers:
                    if subscriber.topic == packet["name"]:
                        self._message(subscriber, message)
            elif packet["kind"] == "request":
                server = next(port for port in self._ports.servers if port.service == packet["name"])
                self._request(server, message, packet["client"])
            else:
                client = next(
                    port
                    for port in self._ports.clients
                    if [port.service, port.client] == [packet["name"], packet["client"]]
                )
                self._receiver.response_arrived(client, message)

    def _message(self, port: SubscriberPort, message: Message) -> None:
        self._receiver.message_arrived(port, message, 0)

    def _request(self, port: ServerPort, message: Message, client: str) -> None:
        def answer(response: Message) -> None:
            fields = {"name": port.service, "client": client}
            self._send(kind="response", **fields, id=response.id, data=dict(response.data))

        self._receiver.request_arrived(port, message, answer)


class Broker:
    """Passes messages on; a context manager."""

    def __init__(self, path: Path) -> None:
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(str(path))
        self._listener.listen()
        self._state = threading.Lock()
        self._subscribers: dict[str, dict[socket.socket, threading.Lock]] = {}
        self._ends: dict[tuple[str, ...], tuple[socket.socket, threading.Lock]] = {}
        self._history: dict[str, dict[str, dict[str, Any]]] = {}
        self._unanswered: dict[str, dict[str, dict[str, Any]]] = {}
        self._connections: list[socket.socket] = []
        self._threads: list[threading.Thread] = []
        self.packets = 0

    def __enter__(self) -> Broker:
        self._start(self._accept)
        return self

    def __exit__(self, *_: object) -> None:
        self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        for connection in self._connections:
            connection.close()
        for thread in self._threads:
            thread.join()

    def _start(self, target: Any, *arguments: Any) -> None:
        thread = threading.Thread(target=target, args=arguments, daemon=True)
        self._threads.append(thread)
        thread.start()

    def _accept(self) -> None:
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return
            self._connections.append(connection)
            self._start(self._serve, connection)

    def _serve(self, connection: socket.socket) -> None:
        lock = threading.Lock()
        try:
            for line in connection.makefile("rb"):
                if not line.endswith(b"\n"):
                    break  # the sender was killed in between
                with self._state:
                    self.packets += 1
                    self._handle(json.loads(line), connection, lock)
        except (OSError, ValueError):
            pass
        with self._state:
            for subscribers in self._subscribers.values():
                subscribers.pop(connection, None)
            self._ends = {key: end for key, end in self._ends.items() if end[0] is not connection}
        connection.close()

    def _handle(self, packet: dict[str, Any], connection: socket.socket, lock: threading.Lock) -> None:
        if packet["kind"] == "hello":
            for topic in packet["topics"]:
                self._subscribers.setdefault(topic, {})[connection] = lock
                for message in self._history.get(topic, {}).values():
                    self._pass(connection, lock, message)
            for key in [(service,) for service in packet["services"]] + [*map(tuple, packet["clients"])]:
                self._ends[key] = (connection, lock)
            for service in packet["services"]:
                for request in self._unanswered.get(service, {}).values():
                    self._pass(connection, lock, request)
            return
        name, id = packet["name"], packet["id"]
        if packet["kind"] == "publish":
            packet["kind"] = "message"
            self._history.setdefault(name, {})[id] = packet
            for subscriber, its_lock in list(self._subscribers.get(name, {}).items()):
                self._pass(subscriber, its_lock, packet)
        elif packet["kind"] == "request":
            self._unanswered.setdefault(name, {})[id] = packet
            self._pass_to((name,), packet)
        else:
            self._unanswered.get(name, {}).pop(id, None)
            self._pass_to((name, packet["client"]), packet)

    def _pass_to(self, key: tuple[str, ...], packet: dict[str, Any]) -> None:
        if key in self._ends:
            self._pass(*self._ends[key], packet)

    @staticmethod
    def _pass(connection: socket.socket, lock: threading.Lock, packet: dict[str, Any]) -> None:
        with contextlib.suppress(OSError):  # it was killed; it asks again
            _send(connection, lock, packet)
