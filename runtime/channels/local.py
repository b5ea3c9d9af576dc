"""Channels between the nodes of one process: for simulation, tests and `dineros run --local`.

The queues are those of the paper (Fig. 8 and 9), with the model's limits: a publisher's, one dispatcher's
per subscribing node, and the subscriber's, which the node itself keeps. Full queues drop the newest
message. Where the model's middleware is ROS 2, they are histories instead. Requests and responses travel one
by one. Nothing moves by itself: `step` makes one move, by the seed; `start` has a thread make them.
"""

from __future__ import annotations

import random
import threading
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

from dineros.metamodel.errors import DinerosError
from dineros.runtime.channels.goals import KnownGoal
from dineros.runtime.channels.histories import HistoryTopic
from dineros.runtime.channels.local_actions import LocalAction
from dineros.runtime.channels.local_services import LocalClient, LocalService
from dineros.runtime.channels.transport import Answer, Receiver
from dineros.runtime.nets.ports import (
    ActionClientPort,
    ActionServerPort,
    ClientPort,
    Data,
    Message,
    OutcomeKind,
    Ports,
    PublisherPort,
    ServerPort,
    SubscriberPort,
)
from dineros.runtime.scheduling.threads import join

Move = Callable[[], None]


@dataclass
class _PublisherQueue:
    """Messages that left their node.

    Attributes
    ----------
    history : deque of Message
        What a late subscriber gets of a transient-local topic.
    again : deque of Message
        What the publisher had sent in an earlier life.
    """

    port: PublisherPort
    waiting: deque[Message] = field(default_factory=deque)
    history: deque[Message] = field(default_factory=deque)
    again: deque[Message] = field(default_factory=deque)

    def __post_init__(self) -> None:
        self.again = deque(maxlen=max(1, self.port.limit))


@dataclass
class _Dispatcher:
    """Messages of one topic for the subscribers of one node."""

    receiver: Receiver
    ports: list[SubscriberPort]
    waiting: deque[Message] = field(default_factory=deque)
    history: deque[Message] = field(default_factory=deque)


class LocalNetwork:
    """The channels of one application.

    Parameters
    ----------
    seed : int, optional
        Which of the possible moves `step` makes.
    """

    def __init__(self, seed: int | None = None) -> None:
        self._random = random.Random(seed)
        self._changed = threading.Condition()
        self._publishers: dict[str, dict[str, _PublisherQueue]] = {}  # topic -> node/place
        self._dispatchers: dict[str, dict[str, _Dispatcher]] = {}  # topic -> node
        self._topics: dict[str, HistoryTopic] = {}  # those with histories
        self._services: dict[str, LocalService] = {}
        self._clients: dict[str, LocalClient] = {}
        self._actions: dict[str, LocalAction] = {}
        self._thread: threading.Thread | None = None
        self._is_ending = False

    def transport(self) -> LocalTransport:
        """Return a transport for one node."""
        return LocalTransport(self)

    # Moving messages.

    def step(self) -> bool:
        """Make one of the possible moves; False: there is none."""
        with self._changed:
            moves = self._moves()
            if not moves:
                return False
            moves[int(self._random.random() * len(moves))]()
            return True

    def _moves(self) -> list[Move]:
        moves: list[Move] = []
        for topic, publishers in self._publishers.items():
            moves += [partial(self._spread, topic, queue) for queue in publishers.values() if queue.waiting]
        for dispatchers in self._dispatchers.values():
            for dispatcher in dispatchers.values():
                if dispatcher.waiting or dispatcher.history:
                    moves.append(partial(self._dispatch, dispatcher))
        for with_histories in self._topics.values():
            moves += with_histories.moves()
        for service in self._services.values():
            moves += service.moves()
        moves += [client.respond for client in self._clients.values() if client.waiting]
        for action in self._actions.values():
            moves += action.moves()
        return moves

    def _spread(self, topic: str, queue: _PublisherQueue) -> None:
        """Take a message from a publisher's queue to the dispatcher of every subscribing node."""
        message = queue.waiting.popleft()
        if queue.port.is_kept:
            queue.history.append(message)
            while len(queue.history) > queue.port.limit:
                queue.history.popleft()
        for dispatcher in self._dispatchers.get(topic, {}).values():
            port = dispatcher.ports[0]
            if len(dispatcher.waiting) < port.dispatcher_limit:
                dispatcher.waiting.append(message)
            else:
                dispatcher.receiver.dropped(port, "dispatcher", 1)

    @staticmethod
    def _dispatch(dispatcher: _Dispatcher) -> None:
        """Hand a message to the subscribers of a node; what a late one missed comes first."""
        message = (dispatcher.history or dispatcher.waiting).popleft()
        for port in dispatcher.ports:
            dispatcher.receiver.message_arrived(port, message, 0)

    # A thread that moves.

    def start(self) -> None:
        """Have a thread make moves as long as there are any."""
        self._is_ending = False
        self._thread = threading.Thread(target=self._run, name="dineros network", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        with self._changed:
            while not self._is_ending:
                if not self.step():
                    self._changed.wait()

    def stop(self) -> None:
        """End the thread; what is on its way stays there."""
        with self._changed:
            self._is_ending = True
            self._changed.notify()
        join(self._thread)
        self._thread = None

    # What transports ask.

    def join(self, ports: Ports, receiver: Receiver) -> None:
        """Connect a node.

        Raises
        ------
        DinerosError
            Another node serves one of its services; the node is not connected.
        """
        with self._changed:
            for server in ports.servers:
                if self._service(server.channel).has_server:
                    raise DinerosError(f"two nodes serve {server.service!r}")
            for action in ports.action_servers:
                if self._action(action.channel).has_server:
                    raise DinerosError(f"two nodes serve {action.action!r}")
            if ports.middleware == "ros2":
                self._join_topics(ports, receiver)
            for publisher in ports.publishers if ports.middleware != "ros2" else ():
                known = self._publishers.setdefault(publisher.channel, {})
                known.setdefault(_place_key(ports, publisher), _PublisherQueue(publisher))
            for subscriber in ports.subscribers if ports.middleware != "ros2" else ():
                dispatchers = self._dispatchers.setdefault(subscriber.channel, {})
                if ports.node in dispatchers:
                    dispatchers[ports.node].ports.append(subscriber)
                    continue
                dispatcher = dispatchers[ports.node] = _Dispatcher(receiver, [subscriber])
                for queue in self._publishers.get(subscriber.channel, {}).values():
                    dispatcher.history.extend(queue.again)
                    if subscriber.is_kept:
                        dispatcher.history.extend(queue.history)
            for client in ports.clients:
                self._clients[_client_key(client)] = LocalClient(receiver, client)
            for server in ports.servers:
                depth = server.depth if ports.middleware == "ros2" else None
                self._service(server.channel).serve(receiver, server, depth)
            for action_client in ports.action_clients:
                self._action(action_client.channel).add_client(receiver, action_client)
            for action in ports.action_servers:
                self._action(action.channel).add_server(receiver, action)
            self._changed.notify()

    def _service(self, channel: str) -> LocalService:
        if channel not in self._services:
            self._services[channel] = LocalService(self.change, self._clients)
        return self._services[channel]

    def _action(self, channel: str) -> LocalAction:
        if channel not in self._actions:
            self._actions[channel] = LocalAction(self.change)
        return self._actions[channel]

    def _join_topics(self, ports: Ports, receiver: Receiver) -> None:
        for port in (*ports.publishers, *ports.subscribers):
            self._topics.setdefault(port.channel, HistoryTopic())
        for publisher in ports.publishers:
            self._topics[publisher.channel].add_writer(_place_key(ports, publisher), publisher)
        for subscriber in ports.subscribers:
            self._topics[subscriber.channel].add_reader(ports.node, receiver, subscriber)

    def leave(self, ports: Ports, receiver: Receiver) -> None:
        """Disconnect a node; what it has published and asked stays on its way."""
        with self._changed:
            for action in self._actions.values():
                action.remove(receiver)
            for topic in self._topics.values():
                topic.remove(ports.node)
            for subscriber in ports.subscribers if ports.middleware != "ros2" else ():
                self._dispatchers[subscriber.channel].pop(ports.node, None)
            for client in ports.clients:
                self._clients.pop(_client_key(client), None)
            for server in ports.servers:
                self._service(server.channel).leave()

    def publish(self, ports: Ports, port: PublisherPort, message: Message) -> bool:
        """Take a message into the publisher's queue or histories; False: the queue is full."""
        with self._changed:
            if port.channel in self._topics:
                self._topics[port.channel].publish(_place_key(ports, port), message)
                self._changed.notify()
                return True
            queue = self._publishers[port.channel][_place_key(ports, port)]
            if len(queue.waiting) >= port.limit:
                return False
            queue.waiting.append(message)
            self._changed.notify()
            return True

    def publish_again(self, ports: Ports, port: PublisherPort, message: Message) -> None:
        """Hand a message of an earlier life to all dispatchers, also those that come later."""
        with self._changed:
            if port.channel in self._topics:
                self._topics[port.channel].publish_again(_place_key(ports, port), message)
                self._changed.notify()
                return
            self._publishers[port.channel][_place_key(ports, port)].again.append(message)
            for dispatcher in self._dispatchers.get(port.channel, {}).values():
                dispatcher.history.append(message)
            self._changed.notify()

    def opened(self) -> None:
        """Look again for messages that a node takes."""
        with self._changed:
            self._changed.notify()

    def request(self, port: ClientPort, message: Message) -> None:
        """Take a request on its way."""
        self.change(lambda: self._service(port.channel).ask(_client_key(port), message))

    def action(self, channel: str) -> LocalAction:
        """Return an action, to be changed by `change` only."""
        with self._changed:
            return self._action(channel)

    def change(self, action: Callable[[], None]) -> None:
        """Have something put on its way; from any thread."""
        with self._changed:
            action()
            self._changed.notify()

    def take_request(self, port: ServerPort) -> tuple[list[str], tuple[Message, Answer] | None]:
        """Return what a full history lost before, and the oldest request that waits for a server then."""
        with self._changed:
            service = self._service(port.channel)
            return service.lost(), service.take()

    def lost_requests(self, port: ServerPort) -> list[str]:
        """Return the ids of the requests that a full history has lost since this was asked last."""
        with self._changed:
            return self._service(port.channel).lost()

    def forget(self, port: ClientPort, message_id: str) -> None:
        """Hand a request that its client has given up to no server that comes back."""
        with self._changed:
            self._service(port.channel).forget(_client_key(port), message_id)


class LocalTransport:
    """One node's end of a `LocalNetwork`."""

    def __init__(self, network: LocalNetwork) -> None:
        self._network = network
        self._joined: tuple[Ports, Receiver] | None = None

    def open(self, ports: Ports, receiver: Receiver) -> None:
        """Join the channels."""
        self._network.join(ports, receiver)
        self._joined = (ports, receiver)

    @property
    def _ports(self) -> Ports:
        assert self._joined is not None
        return self._joined[0]

    def publish(self, port: PublisherPort, message: Message) -> bool:
        """Send a message; False: the publisher's queue is full."""
        return self._network.publish(self._ports, port, message)

    def publish_again(self, port: PublisherPort, message: Message) -> None:
        """Send a message that was sent before a restart."""
        self._network.publish_again(self._ports, port, message)

    def opened(self, port: SubscriberPort) -> None:
        """Learn that the node takes messages of a topic again."""
        self._network.opened()

    def request(self, port: ClientPort, message: Message) -> None:
        """Send a request."""
        self._network.request(port, message)

    def restore_goals(self, port: ActionServerPort, goals: Sequence[KnownGoal]) -> None:
        """Know the goals of an earlier life again."""
        action = self._network.action(port.channel)
        self._network.change(lambda: action.restore(goals))

    def send_goal(self, port: ActionClientPort, message: Message) -> None:
        """Send a goal."""
        action = self._network.action(port.channel)
        self._network.change(lambda: action.send(port, message))

    def follow_goal(self, port: ActionClientPort, message: Message) -> None:
        """Ask for the result of a goal of an earlier life."""
        action = self._network.action(port.channel)
        self._network.change(lambda: action.follow(port, message))

    def cancel_goal(self, port: ActionClientPort, goal: str) -> None:
        """Ask to cancel a goal."""
        action = self._network.action(port.channel)
        self._network.change(lambda: action.cancel(goal))

    def give_feedback(self, port: ActionServerPort, goal: str, number: int, data: Data) -> None:
        """Send feedback."""
        action = self._network.action(port.channel)
        self._network.change(lambda: action.give_feedback(goal, number, data, port.depth))

    def finish_goal(self, port: ActionServerPort, goal: str, outcome: OutcomeKind, data: Data) -> None:
        """Send the result of a goal."""
        action = self._network.action(port.channel)
        self._network.change(lambda: action.finish(goal, outcome, data))

    def take_request(self, port: ServerPort) -> tuple[list[str], tuple[Message, Answer] | None]:
        """Return what a full history lost before, and the oldest request that waits for a server then."""
        return self._network.take_request(port)

    def lost_requests(self, port: ServerPort) -> list[str]:
        """Return the ids of the requests that a full history has lost since this was asked last."""
        return self._network.lost_requests(port)

    def forget(self, port: ClientPort, message_id: str) -> None:
        """Learn that the node has given a request up."""
        self._network.forget(port, message_id)

    def close(self) -> None:
        """Leave the channels."""
        if self._joined is not None:
            self._network.leave(*self._joined)
            self._joined = None


def _place_key(ports: Ports, port: PublisherPort) -> str:
    return f"{ports.node}/{port.place}"


def _client_key(port: ClientPort) -> str:
    return f"{port.channel}/{port.client}"
