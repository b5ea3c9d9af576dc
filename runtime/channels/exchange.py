"""All ports of a node: sends departing tokens and puts received messages, on the thread of its loop."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import cast

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.lifecycles.states import State
from dineros.metamodel.message_ids import Senders
from dineros.metamodel.records.schema import requests_of
from dineros.metamodel.token_data import Value
from dineros.runtime.channels.actions import Actions
from dineros.runtime.channels.clients import Client
from dineros.runtime.channels.services import Server
from dineros.runtime.channels.topics import Publisher, Subscriber, Writer
from dineros.runtime.channels.traffic import SendError, Traffic, known_port
from dineros.runtime.firing.observing import FiringObserver
from dineros.runtime.journal.saved import ChannelState, SavedState
from dineros.runtime.nets.engine import Engine
from dineros.runtime.nets.ports import (
    ActionServerPort,
    Data,
    Message,
    Port,
    PublisherPort,
    Queue,
    ServerPort,
    SubscriberPort,
)
from dineros.runtime.scheduling.loop import Loop

RETRY_DELAY = 1.0


class Exchange:
    """The ports of one node.

    Parameters
    ----------
    engine : Engine
            The node's engine, still without departures.
    loop : Loop
            The node's loop.
    observer : FiringObserver
            Receives a record of each message sent or received.
    accepts : callable
            Decides whether an action server (by channel) accepts a goal with this data.
    run : str
            Part of the ids of messages, after the node's id.
    request_timeout : float, optional
        Seconds after which a request is sent again.

    Attributes
    ----------
    traffic : Traffic
            Shared by the ports.
    subscribers, clients, servers : dict
            The object that works for each port, by port.
    actions : Actions
            The node's action clients and action servers.
    """

    def __init__(
        self,
        engine: Engine,
        loop: Loop,
        observer: FiringObserver,
        accepts: Callable[[str, Data], bool],
        *,
        run: str = "",
        request_timeout: float | None = None,
    ) -> None:
        self._engine = engine
        self._loop = loop
        self._is_there = True
        self.traffic = traffic = Traffic(engine, loop, observer, run)
        ports = engine.structure.ports
        self._writers = [Writer(traffic, port) for port in ports.publishers]
        self._publishers = [
            Publisher(traffic, writer, place) for writer in self._writers for place in writer.port.places
        ]
        self.subscribers = {port: Subscriber(traffic, port) for port in ports.subscribers}
        self.clients = {port: Client(traffic, port, request_timeout) for port in ports.clients}
        self.servers = {port: Server(traffic, port) for port in ports.servers}
        self._instances = [each for server in self.servers.values() for each in server.instances]
        self.actions = Actions(traffic, accepts)

    @property
    def waiting_requests(self) -> int:
        """Number of requests that wait for a server instance, and of goals that wait for a slot."""
        waiting = sum(len(server.waiting) for server in self.servers.values())
        return waiting + self.actions.waiting_goals

    def begin(self) -> None:
        """Release departures; what was sent or requested before a restart is sent again."""
        for writer in self._writers:
            self._send_again(writer)
        for publisher in self._publishers:
            self._engine.unhold(publisher.departure)
        for client in self.clients.values():
            client.begin()
        self.actions.begin()

    def _send_again(self, writer: Writer) -> None:
        try:
            writer.send_again()
        except SendError as error:
            self.traffic.log_error(str(error), "retry", error.__cause__)
            self._loop.steady_timers.call_later(RETRY_DELAY, lambda: self._send_again(writer))

    def obey(self, state: State) -> None:
        """Hold or release departures according to the lifecycle state of a managed node."""
        self._is_there = state in ("inactive", "active")
        self.traffic.is_active = state == "active"

    def depart(self) -> bool:
        """Send all tokens that can depart; return whether there were any."""
        due = self._engine.due
        if not due or not self._is_there:
            return False
        senders = self.traffic.senders
        while due:
            number = due[0]
            try:
                senders[number]()
            except SendError as error:
                self._postpone(number, error)
        return True

    def hold_departures(self) -> None:
        """Stop automatic departures; from now on, only `send_one` sends."""
        for number in self.traffic.senders:
            self._engine.hold(number)

    def send_one(self, channel: str, place: str) -> None:
        """Send the oldest token of a place whose departure is held by `hold_departures`.

        Raises
        ------
        DinerosError
            The place has no departure.
        SendError
            The transport failed; the token stays on its place.
        """
        for number, (from_, by) in self.traffic.departures.items():
            if from_ != place or by not in (channel, None):
                continue
            self._engine.unhold(number)
            try:
                if number in self._engine.due:
                    self.traffic.senders[number]()
                    return
            finally:
                self._engine.hold(number)
        raise DinerosError(f"{place} cannot send to {channel}")

    def lose_cancel(self, channel: str, place: str) -> None:
        """Drop the oldest cancel request of a place, as if there were no goal for it."""
        for port, client in self.actions.clients.items():
            if (port.channel, port.cancel) == (channel, place):
                client.lose_cancel()

    def _postpone(self, number: int, error: SendError) -> None:
        """Retry later after the transport failed to send."""
        self.traffic.log_error(str(error), "retry", error.__cause__)
        self._engine.hold(number)
        self._loop.steady_timers.call_later(RETRY_DELAY, lambda: self._engine.unhold(number))

    def let_in(self, places: Collection[int]) -> bool:
        """Handle what waits for room on these places; return whether there was anything."""
        before = self._engine.next_token
        for client in self.clients.values():
            if client.response in places or client.timed_out in places:
                client.let_in()
        for subscriber in self.subscribers.values():
            if subscriber.is_late:
                subscriber.miss()
        for instance in self._instances:
            if instance.entry in places:
                instance.server.serve()
        self.actions.let_in(places)
        return self._engine.next_token > before

    def lost(self, port: Port, queue: Queue, count: int) -> None:
        """Count and record messages that a full queue lost."""
        if isinstance(port, SubscriberPort):
            self.subscribers[port].lost(queue, count)
        else:
            place = port.place if isinstance(port, PublisherPort) else None
            self.traffic.lost(port, queue, count, place)

    def refuse(self, port: SubscriberPort | ServerPort | ActionServerPort, error: Exception) -> None:
        """Count received data that is not a valid message; the first case is recorded."""
        match port:
            case SubscriberPort():
                name = port.topic
            case ServerPort():
                name = port.service
            case ActionServerPort():
                name = port.action
        self.traffic.refuse(port.channel, name, error)

    # Continuing after a restart.

    def save(self) -> ChannelState:
        """Return the state of the channels."""
        places, now = self._engine.structure.places, self._loop.clock()
        heard = {f"{port.channel}/{port.place}": each for port, each in self.subscribers.items()}
        seen = {key: each.seen.saved() for key, each in heard.items()}
        return {
            "run": self.traffic.run,
            "numbers": dict(self.traffic.numbers),
            "queues": {each.port.place: each.history.maxlen or 1 for each in self._writers},
            "history": {
                writer.port.place: [[_number(message), _plain(message.data)] for message in writer.history]
                for writer in self._writers
                if writer.history
            },
            "seen": {key: numbers for key, (numbers, _) in seen.items() if numbers},
            "seen_apart": {key: ranges for key, (_, ranges) in seen.items() if ranges},
            "missing": {key: each.missing for key, each in heard.items() if each.missing},
            "requests": {
                f"{port.channel}/{port.client}": [
                    {
                        "message": id,
                        "data": _plain(call.message.data),
                        "attempts": call.attempts,
                        "age": now - call.asked,
                    }
                    for id, call in client.calls.items()
                ]
                for port, client in self.clients.items()
                if client.calls
            },
            "serving": {
                places[instance.entry]: instance.message
                for instance in self._instances
                if instance.message is not None
            },
            "responses": {
                port.channel: {
                    id: _plain(kept.data)
                    for responses in server.responses.values()
                    for id, kept in responses.items()
                }
                for port, server in self.servers.items()
                if server.responses
            },
            "kept_responses": {
                port.channel: server.kept for port, server in self.servers.items() if server.kept > 1
            },
            **self.actions.save(),
        }

    def restore(self, checkpoint: SavedState) -> None:
        """Restore the state of the channels from a checkpoint, before `begin`.

        Raises
        ------
        DinerosError
            The checkpoint has ports that the model does not have.
        """
        places = self._engine.structure.places
        writers = {each.port.place: each for each in self._writers}
        senders = {*places, *writers}
        self.traffic.run = checkpoint["run"]
        self.traffic.numbers = {
            known_port({place: place for place in senders}, place, "place"): number
            for place, number in checkpoint["numbers"].items()
        }
        for place, messages in checkpoint.get("history", {}).items():
            writer = known_port(writers, place, "publisher at")
            for number, data in messages:
                id = self.traffic.id_of(place, int(str(number)))
                writer.history.append(Message(id, cast("Data", data)))
        subscribers = {f"{port.channel}/{port.place}": each for port, each in self.subscribers.items()}
        seen, apart = checkpoint["seen"], checkpoint.get("seen_apart", {})
        for key in {**seen, **apart}:
            known_port(subscribers, key, "subscriber").seen = Senders(seen.get(key), apart.get(key))
        for key, missing in checkpoint.get("missing", {}).items():
            known_port(subscribers, key, "subscriber").missing = missing
        clients = {f"{port.channel}/{port.client}": each for port, each in self.clients.items()}
        for key, requests in checkpoint["requests"].items():
            client = known_port(clients, key, "client")
            for request in requests_of(requests):
                pending = Message(request["message"], request["data"])
                client.restore(pending, request["attempts"], request["age"])
        instances = {places[instance.entry]: instance for instance in self._instances}
        for entry, message in checkpoint["serving"].items():
            instance = known_port(instances, entry, "server instance at")
            instance.message = message
            self._engine.unhold(instance.departure)
        servers = {port.channel: each for port, each in self.servers.items()}
        for channel, responses in checkpoint["responses"].items():
            server = known_port(servers, channel, "server of")
            for id, data in responses.items():
                server.keep(Message(id, data))
        self.actions.restore(checkpoint)


def _number(message: Message) -> int:
    return int(message.id.rpartition("/")[2])


def _plain(data: Data) -> dict[str, Value]:
    return cast("dict[str, Value]", data) if isinstance(data, dict) else dict(data)
