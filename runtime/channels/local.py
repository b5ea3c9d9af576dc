"""Channels between the nodes of one process: for simulation, tests and `dineros run --local`.

The queues are those of the paper, with the model's limits; each node keeps the queues of its subscribers
itself. If the middleware of the model is ROS 2, the queues are histories. Requests and responses are moved
one by one. Nothing moves automatically: `step` makes one move, drawn with the seed; `start` runs a thread
that makes moves.
"""

from __future__ import annotations

import random
import threading
from collections.abc import Callable, Sequence

from dineros.metamodel.errors import DinerosError
from dineros.runtime.channels.goals import KnownGoal
from dineros.runtime.channels.local_actions import LocalAction
from dineros.runtime.channels.local_services import LocalClient, LocalService
from dineros.runtime.channels.local_topics import HistoryTopic, LocalTopic, QueueTopic
from dineros.runtime.channels.transport import Answer, Receiver, Transport
from dineros.runtime.nets.ports import (
    ActionClientPort,
    ActionPort,
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


class LocalNetwork:
    """The channels of one application.

    Parameters
    ----------
    seed : int, optional
        Seed that draws the move which `step` makes.

    Attributes
    ----------
    changed : threading.Condition
        Lock for reading or changing the channels.
    topics : dict of str to LocalTopic
        By channel.
    """

    def __init__(self, seed: int | None = None) -> None:
        self._random = random.Random(seed)
        self.changed = threading.Condition()
        self.topics: dict[str, LocalTopic] = {}
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
        with self.changed:
            moves = self._moves()
            if not moves:
                return False
            moves[int(self._random.random() * len(moves))]()
            return True

    def _moves(self) -> list[Callable[[], None]]:
        moves = [move for topic in self.topics.values() for move in topic.moves()]
        moves += [move for service in self._services.values() for move in service.moves()]
        moves += [client.respond for client in self._clients.values() if client.waiting]
        moves += [move for action in self._actions.values() for move in action.moves()]
        return moves

    # A thread that moves.

    def start(self) -> None:
        """Start a thread that makes moves while there are any."""
        self._is_ending = False
        self._thread = threading.Thread(target=self._run, name="dineros network", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        with self.changed:
            while not self._is_ending:
                if not self.step():
                    self.changed.wait()

    def stop(self) -> None:
        """End the thread; messages under way stay in their queues."""
        with self.changed:
            self._is_ending = True
            self.changed.notify()
        join(self._thread)
        self._thread = None

    # Called by transports.

    def join(self, ports: Ports, receiver: Receiver) -> None:
        """Connect a node.

        Raises
        ------
        DinerosError
            Another node serves one of its services; the node is not connected.
        """
        has_histories = ports.middleware == "ros2"
        with self.changed:
            for server in ports.servers:
                if self.service(server).has_server:
                    raise DinerosError(f"two nodes serve {server.service!r}")
            for action in ports.action_servers:
                if self.action(action).has_server:
                    raise DinerosError(f"two nodes serve {action.action!r}")
            for port in (*ports.publishers, *ports.subscribers):
                self.topics.setdefault(port.channel, HistoryTopic() if has_histories else QueueTopic())
            for publisher in ports.publishers:
                self.topics[publisher.channel].add_writer(_place_key(ports, publisher), publisher)
            for subscriber in ports.subscribers:
                self.topics[subscriber.channel].add_reader(ports.node, receiver, subscriber)
            for client in ports.clients:
                self._clients[_client_key(client)] = LocalClient(receiver, client)
            for server in ports.servers:
                self.service(server).serve(receiver, server, server.depth if has_histories else None)
            for action_client in ports.action_clients:
                self.action(action_client).add_client(receiver, action_client)
            for action in ports.action_servers:
                self.action(action).add_server(receiver, action)
            self.changed.notify()

    def service(self, port: ClientPort | ServerPort) -> LocalService:
        """Return the service of a port."""
        if port.channel not in self._services:
            self._services[port.channel] = LocalService(self.change, self._clients)
        return self._services[port.channel]

    def action(self, port: ActionPort) -> LocalAction:
        """Return the action of a port."""
        if port.channel not in self._actions:
            self._actions[port.channel] = LocalAction(self.change)
        return self._actions[port.channel]

    def leave(self, ports: Ports, receiver: Receiver) -> None:
        """Disconnect a node; its messages and requests under way stay in their queues."""
        with self.changed:
            for action in self._actions.values():
                action.remove(receiver)
            for topic in self.topics.values():
                topic.remove(ports.node)
            for client in ports.clients:
                self._clients.pop(_client_key(client), None)
            for server in ports.servers:
                self.service(server).leave()

    def change(self, action: Callable[[], None]) -> None:
        """Run an action that changes the channels, then notify waiting threads; from any thread."""
        with self.changed:
            action()
            self.changed.notify()


class LocalTransport(Transport):
    """One node's end of a `LocalNetwork`."""

    keeps_requests = True

    def __init__(self, network: LocalNetwork) -> None:
        self._network = network
        self._joined: tuple[Ports, Receiver] | None = None

    def open(self, ports: Ports, receiver: Receiver) -> None:
        """Join the channels."""
        self._network.join(ports, receiver)
        self._joined = (ports, receiver)

    def _topic(self, port: PublisherPort) -> tuple[LocalTopic, str]:
        """Return the topic of a port and the key of the port in that topic."""
        assert self._joined is not None
        return self._network.topics[port.channel], _place_key(self._joined[0], port)

    def publish(self, port: PublisherPort, message: Message) -> bool:
        """Send a message; False: the publisher's queue is full."""
        topic, key = self._topic(port)
        with self._network.changed:
            is_sent = topic.publish(key, message)
            self._network.changed.notify()
        return is_sent

    def publish_again(self, port: PublisherPort, message: Message) -> None:
        """Send a message that was sent before a restart."""
        topic, key = self._topic(port)
        self._network.change(lambda: topic.publish_again(key, message))

    def opened(self, port: SubscriberPort) -> None:
        """Check the messages of a topic again: the node takes messages again."""
        self._network.change(lambda: None)

    def request(self, port: ClientPort, message: Message) -> None:
        """Send a request."""
        self._network.change(lambda: self._network.service(port).ask(_client_key(port), message))

    def restore_goals(self, port: ActionServerPort, goals: Sequence[KnownGoal]) -> None:
        """Restore the goals from before a restart."""
        self._network.change(lambda: self._network.action(port).restore(goals))

    def send_goal(self, port: ActionClientPort, message: Message) -> None:
        """Send a goal."""
        self._network.change(lambda: self._network.action(port).send(port, message))

    def follow_goal(self, port: ActionClientPort, message: Message) -> None:
        """Ask for the result of a goal that was sent before a restart."""
        self._network.change(lambda: self._network.action(port).follow(port, message))

    def cancel_goal(self, port: ActionClientPort, goal: str) -> None:
        """Ask to cancel a goal."""
        self._network.change(lambda: self._network.action(port).cancel(goal))

    def give_feedback(self, port: ActionServerPort, goal: str, number: int, data: Data) -> None:
        """Send feedback."""
        depth = port.depth
        self._network.change(lambda: self._network.action(port).give_feedback(goal, number, data, depth))

    def finish_goal(self, port: ActionServerPort, goal: str, outcome: OutcomeKind, data: Data) -> None:
        """Send the result of a goal."""
        self._network.change(lambda: self._network.action(port).finish(goal, outcome, data))

    def take_request(self, port: ServerPort) -> tuple[list[str], tuple[Message, Answer] | None]:
        """Return the requests lost by a full history, and the oldest request that waits for the server."""
        with self._network.changed:
            service = self._network.service(port)
            return service.lost(), service.take()

    def lost_requests(self, port: ServerPort) -> list[str]:
        """Return the ids of the requests that a full history has lost since the last call."""
        with self._network.changed:
            return self._network.service(port).lost()

    def forget(self, port: ClientPort, message_id: str) -> None:
        """Discard a request that its client has given up, so that no restarted server receives it."""
        with self._network.changed:
            self._network.service(port).forget(_client_key(port), message_id)

    def close(self) -> None:
        """Leave the channels."""
        if self._joined is not None:
            self._network.leave(*self._joined)
            self._joined = None


def _place_key(ports: Ports, port: PublisherPort) -> str:
    return f"{ports.node}/{port.place}"


def _client_key(port: ClientPort) -> str:
    return f"{port.channel}/{port.client}"
