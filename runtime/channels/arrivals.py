"""Moves messages and requests from the transport's threads to the places of a node.

Each message waits for the node's thread and, if its place is full, for room. Under the paper's rules, at most
as many messages wait as the port's limit allows; further ones are dropped. Under the rules of ROS 2, a
message is taken from the middleware only when its place has room. So at most one message waits here, if its
place has become full in the meantime. Requests are taken at once, up to the depth of their server, and wait
there for an instance.
"""

from __future__ import annotations

import threading
from collections import deque

from dineros.runtime.channels.exchange import Exchange
from dineros.runtime.channels.transport import Answer
from dineros.runtime.nets.engine import Engine
from dineros.runtime.nets.ports import Message, Port, Queue, ServerPort, SubscriberPort
from dineros.runtime.scheduling.loop import Loop


class Arrivals:
    """Receives the messages and requests of one node.

    Parameters
    ----------
    exchange : Exchange
            Handles them on the node's thread.
    engine : Engine
            The node's engine; it reports the places that got room.
    loop : Loop
            The node's loop.
    """

    def __init__(self, exchange: Exchange, engine: Engine, loop: Loop) -> None:
        ports = engine.structure.ports
        self._exchange = exchange
        self._subscribers = exchange.subscribers
        self._engine = engine
        self._post = loop.post
        self._traffic = exchange.traffic
        self._has_histories = ports.middleware == "ros2"
        self._lock = threading.Lock()
        self._arriving: dict[SubscriberPort, int] = dict.fromkeys(ports.subscribers, 0)
        self._most: dict[SubscriberPort, int] = dict.fromkeys(ports.subscribers, 0)
        self._held: dict[SubscriberPort, deque[tuple[Message, int]]] = {
            port: deque() for port in ports.subscribers
        }
        self._asked: dict[ServerPort, int] = dict.fromkeys(ports.servers, 0)
        self._losses: dict[tuple[Port, Queue], int] = {}

    # Called from any thread.

    def is_open(self, port: SubscriberPort | ServerPort) -> bool:
        """Return whether another message is taken now; under ROS 2, only one and if its place has room."""
        if isinstance(port, ServerPort):
            return self._exchange.servers[port].is_open(self._asked[port])
        has_room = self._subscribers[port].has_room
        return not self._has_histories or (not self._arriving[port] and has_room())

    def message_arrived(self, port: SubscriberPort, message: Message, lost: int) -> None:
        """Queue a message for the loop; `lost` messages are missing just before it."""
        if self._subscribers[port].had(message):  # a repeated message must not fill the queue
            return
        with self._lock:
            if self._arriving[port] >= port.limit and not self._has_histories:
                self._note_loss(port, "subscriber", 1 + lost)
                return
            self._arriving[port] += 1
            self._most[port] = max(self._most[port], self._arriving[port])
        self._post(lambda: self._place(port, message, lost))

    def request_arrived(self, port: ServerPort, message: Message, answer: Answer) -> None:
        """Queue a request for the loop."""

        def serve() -> None:
            with self._lock:
                self._asked[port] -= 1
            self._exchange.servers[port].requested(message, answer)

        with self._lock:
            self._asked[port] += 1
        self._post(serve)

    def dropped(self, port: Port, queue: Queue, count: int) -> None:
        """Count and record messages that a full queue lost."""
        with self._lock:
            self._note_loss(port, queue, count)

    def most_waiting(self, port: SubscriberPort) -> int:
        """Return the most messages that waited at once, here or in a history, since the last call."""
        with self._lock:
            most, self._most[port] = self._most[port], self._arriving[port]
        transport = self._traffic.transport
        return most if transport is None else max(most, transport.most_waiting(port))

    def waited(self, port: SubscriberPort) -> float:
        """Return how many seconds the last message had waited in the middleware, if known."""
        transport = self._traffic.transport
        return 0.0 if transport is None else transport.waited(port)

    def held(self, port: SubscriberPort) -> int:
        """Return the number of messages that wait for room on their place."""
        return len(self._held[port])

    def _note_loss(self, port: Port, queue: Queue, count: int) -> None:
        """Schedule the record of a loss, in order; losses of one queue until then become one record."""
        if not self._losses:
            self._post(self._record_losses)
        self._losses[port, queue] = self._losses.get((port, queue), 0) + count

    # Called on the thread of the loop.

    def let_in(self) -> bool:
        """Put messages that wait for room onto places that have room now; return whether there were any."""
        places = frozenset(self._engine.opened)
        self._engine.opened.clear()
        did = self._exchange.let_in(places)
        for port, held in self._held.items():
            subscriber = self._subscribers[port]
            if subscriber.place in places:
                while held and subscriber.has_room():
                    self._take(port, *held.popleft())
                    did = True
                self._tell_open(port)
        return did

    def _place(self, port: SubscriberPort, message: Message, lost: int) -> None:
        if self._held[port] or not self._subscribers[port].has_room():
            self._held[port].append((message, lost))
        else:
            self._take(port, message, lost)
            self._tell_open(port)

    def _take(self, port: SubscriberPort, message: Message, lost: int) -> None:
        with self._lock:
            self._arriving[port] -= 1
        self._record_losses()  # before the take that makes room: the queues were full until then
        self._subscribers[port].arrived(message, lost)

    def _tell_open(self, port: SubscriberPort) -> None:
        transport = self._traffic.transport
        if self._has_histories and transport is not None and self.is_open(port):
            transport.opened(port)

    def _record_losses(self) -> None:
        with self._lock:
            losses, self._losses = self._losses, {}
        for (port, queue), count in losses.items():
            self._exchange.lost(port, queue, count)
