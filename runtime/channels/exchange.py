"""All ports of a node: what departs and where what arrives goes, on the thread of the node's loop."""

from __future__ import annotations

from collections.abc import Collection
from typing import cast

from dineros.metamodel.lifecycles.states import State
from dineros.metamodel.message_ids import Senders
from dineros.metamodel.records.schema import requests_of
from dineros.metamodel.token_data import Value
from dineros.runtime.channels.actions import Actions, action_departures
from dineros.runtime.channels.clients import Client
from dineros.runtime.channels.services import Instance, Server
from dineros.runtime.channels.topics import Publisher, Subscriber, Writer
from dineros.runtime.channels.traffic import SendError, Traffic, known_port
from dineros.runtime.channels.transport import Transport, check_of
from dineros.runtime.firing.observing import Observer
from dineros.runtime.journal.saved import PendingRequest, SavedState
from dineros.runtime.nets.engine import Engine
from dineros.runtime.nets.ports import (
    ActionServerPort,
    Check,
    ClientPort,
    Data,
    Message,
    Port,
    PublisherPort,
    Queue,
    ServerPort,
    SubscriberPort,
)
from dineros.runtime.nets.structure import Structure
from dineros.runtime.scheduling.loop import Loop

RETRY_DELAY = 1.0


def departures_of(structure: Structure) -> list[int]:
    """Return the places whose tokens depart: of publishers, clients, server instances, actions."""
    number = {id: index for index, id in enumerate(structure.places)}
    ports = structure.ports
    return [
        *(number[place] for port in ports.publishers for place in port.places),
        *(number[port.request] for port in ports.clients),
        *(number[place] for port in ports.servers for place in port.exits),
        *(number[place] for place in action_departures(ports)),
    ]


class Exchange:
    """The ports of one node.

    Parameters
    ----------
    engine : Engine
        Its departures are those of `departures_of`.
    loop : Loop
        The node's.
    observer : Observer
        Told what is sent and received.
    run : str
        Goes into the ids of messages after the node's id.
    request_timeout : float, optional
        Seconds after which a request is sent again.

    Attributes
    ----------
    traffic : Traffic
        What the ports share.
    subscribers, clients, servers : dict
        What does the work of these ports, by the port.
    actions : Actions
        Its clients and servers of goals.
    """

    def __init__(
        self,
        engine: Engine,
        loop: Loop,
        observer: Observer,
        *,
        run: str = "",
        request_timeout: float | None = None,
    ) -> None:
        self._engine = engine
        self._loop = loop
        self._is_there = True
        self.traffic = traffic = Traffic(engine, loop, observer, run)
        places = {id: number for number, id in enumerate(engine.structure.places)}
        ports = engine.structure.ports
        self._writers = [Writer(traffic, port) for port in ports.publishers]
        self._publishers = [
            Publisher(traffic, writer, places[place])
            for writer in self._writers
            for place in writer.port.places
        ]
        self.subscribers = {port: Subscriber(traffic, port, places[port.place]) for port in ports.subscribers}
        self.clients: dict[ClientPort, Client] = {}
        for departure, client in enumerate(ports.clients, len(self._publishers)):
            told = None if client.timed_out is None else places[client.timed_out]
            ends = places[client.request], places[client.response], told
            self.clients[client] = Client(traffic, client, ends, departure, request_timeout)
        self.servers = {port: Server(traffic, port) for port in ports.servers}
        self._instances: list[Instance] = []
        for port, server in self.servers.items():
            for number, (entry, exit_) in enumerate(zip(port.entries, port.exits, strict=True)):
                departure = len(self._publishers) + len(self.clients) + len(self._instances)
                instance = Instance(server, number, places[entry], places[exit_], departure)
                server.instances.append(instance)
                self._instances.append(instance)
        callers: list[Publisher | Client | Instance] = [
            *self._publishers,
            *self.clients.values(),
            *self._instances,
        ]
        self.actions = Actions(traffic, len(callers))
        self._senders = [*(each.send for each in callers), *self.actions.senders]

    @property
    def waiting_requests(self) -> int:
        """How many requests wait for a server instance, and goals for a slot."""
        waiting = sum(len(server.waiting) for server in self.servers.values())
        return waiting + self.actions.waiting_goals

    def begin(self, transport: Transport) -> None:
        """Let tokens depart; what was sent or asked before a restart is sent or asked again."""
        self.traffic.transport = transport
        for port, server in self.servers.items():
            server.check = check_of(transport, port)
        for writer in self._writers:
            self._send_again(writer)
        for departure in range(len(self._publishers)):
            self._engine.unhold_departure(departure)
        for client in self.clients.values():
            client.begin()
        self.actions.begin(transport)

    def _send_again(self, writer: Writer) -> None:
        try:
            writer.send_again()
        except SendError as error:
            self.traffic.log_error(str(error), "retry", error.__cause__)
            self._loop.steady_timers.call_later(RETRY_DELAY, lambda: self._send_again(writer))

    def checks(self, transport: Transport) -> dict[int, Check]:
        """Return what checks the data that comes onto places whose tokens are sent: place -> check."""
        found = [(each.place, check_of(transport, each.port)) for each in self._publishers]
        found += [(each.request, check_of(transport, port)) for port, each in self.clients.items()]
        found += [(each.exit, check_of(transport, each.server.port)) for each in self._instances]
        known = {place: check for place, check in found if check is not None}
        return known | self.actions.checks(transport)

    def obey(self, state: State) -> None:
        """Let tokens depart as the state of a managed node says."""
        self._is_there = state in ("inactive", "active")
        self.traffic.is_active = state == "active"

    def depart(self) -> bool:
        """Send all tokens that are due; return whether there were any."""
        due = self._engine.due
        if not due or not self._is_there:
            return False
        first = self._engine.first_departure
        while due:
            number = due[0] - first
            try:
                self._senders[number]()
            except SendError as error:
                self._postpone(number, error)
        return True

    def _postpone(self, number: int, error: SendError) -> None:
        """Try again later what the transport did not take."""
        self.traffic.log_error(str(error), "retry", error.__cause__)
        self._engine.hold_departure(number)
        self._loop.steady_timers.call_later(RETRY_DELAY, lambda: self._engine.unhold_departure(number))

    def let_in(self, places: Collection[int]) -> bool:
        """Take what waits for room on some places; return whether there was anything."""
        before = self._engine.next_token
        for client in self.clients.values():
            if client.response in places or client.timed_out in places:
                client.let_in()
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
        """Count something that came and is no message; the first is recorded."""
        match port:
            case SubscriberPort():
                name = port.topic
            case ServerPort():
                name = port.service
            case ActionServerPort():
                name = port.action
        self.traffic.refuse(port.channel, name, error)

    # Going on after a restart.

    def save(self, checkpoint: SavedState) -> None:
        """Write what is known of channels into a checkpoint."""
        places = self._engine.structure.places
        checkpoint["run"] = self.traffic.run
        checkpoint["numbers"] = dict(self.traffic.numbers)
        checkpoint["queues"] = {each.port.place: each.history.maxlen or 1 for each in self._writers}
        checkpoint["history"] = {
            writer.port.place: [[_number(message), _plain(message.data)] for message in writer.history]
            for writer in self._writers
            if writer.history
        }
        for port, subscriber in self.subscribers.items():
            seen, apart = subscriber.seen.saved()
            if subscriber.missing:
                checkpoint["missing"][f"{port.channel}/{port.place}"] = subscriber.missing
            if seen:
                checkpoint["seen"][f"{port.channel}/{port.place}"] = seen
            if apart:
                checkpoint["seen_apart"][f"{port.channel}/{port.place}"] = apart
        now = self._loop.clock()
        checkpoint["requests"] = {
            f"{port.channel}/{port.client}": [
                PendingRequest(
                    message=id, data=_plain(call.message.data), attempts=call.attempts, age=now - call.asked
                )
                for id, call in client.calls.items()
            ]
            for port, client in self.clients.items()
            if client.calls
        }
        checkpoint["serving"] = {
            places[instance.entry]: instance.message
            for instance in self._instances
            if instance.message is not None
        }
        checkpoint["responses"] = {
            port.channel: {
                id: _plain(kept.data)
                for responses in server.responses.values()
                for id, kept in responses.items()
            }
            for port, server in self.servers.items()
            if server.responses
        }
        checkpoint["kept_responses"] = {
            port.channel: server.kept for port, server in self.servers.items() if server.kept > 1
        }
        self.actions.save(checkpoint)

    def restore(self, checkpoint: SavedState) -> None:
        """Take over what is known of channels from a checkpoint, before `begin`.

        Raises
        ------
        DinerosError
            It speaks of ports that the model does not have.
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
            self._engine.unhold_departure(instance.departure)
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
