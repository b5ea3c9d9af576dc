"""The actions of a node: its clients and servers of goals, as its exchange drives them."""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import partial
from typing import Any, cast

from dineros.runtime.channels.action_clients import ActionClient, GoalUnderWay
from dineros.runtime.channels.action_servers import ActionServer, Slot
from dineros.runtime.channels.goals import ActionEvent, CancelArrived, GoalArrived
from dineros.runtime.channels.traffic import Traffic, known_port
from dineros.runtime.channels.transport import Transport, check_of
from dineros.runtime.firing.cancels import CancelRequest
from dineros.runtime.journal.saved import PendingGoal, SavedState, SlotGoal
from dineros.runtime.nets.ports import (
    ActionClientPort,
    ActionPort,
    ActionServerPort,
    Check,
    Data,
    Message,
    Ports,
)
from dineros.runtime.nets.structure import Structure


def action_departures(ports: Ports) -> list[str]:
    """Return the places whose tokens depart through actions, in the order of the departures."""
    found = []
    for client in ports.action_clients:
        found += [client.goal, *([] if client.cancel is None else [client.cancel])]
    for server in ports.action_servers:
        for number in range(server.slots):
            found += [places[number] for places in server.outcomes.values()]
            found += server.feedbacks[number : number + 1]
    return found


class Actions:
    """The ports of actions of one node.

    Parameters
    ----------
    traffic : Traffic
        What all ports share.
    first : int
        Number of the first departure of actions.

    Attributes
    ----------
    senders : list of callable
        What sends the oldest token of each departure, in order.
    accepts : callable
        Tells whether a goal of an action's channel is accepted, from its data.
    """

    def __init__(self, traffic: Traffic, first: int) -> None:
        structure = traffic.engine.structure
        self._traffic = traffic
        self._places = {id: number for number, id in enumerate(structure.places)}
        self.senders: list[Callable[[], None]] = []
        self.accepts: Callable[[str, Data], bool] = lambda action, goal: True
        self.clients: dict[ActionClientPort, ActionClient] = {}
        self.servers: dict[ActionServerPort, ActionServer] = {}
        for port in structure.ports.action_clients:
            self.clients[port] = self._client(port, first)
        for server_port in structure.ports.action_servers:
            self.servers[server_port] = self._server(server_port, first)
        self._slots = _slots_of_transitions(structure, self.servers.values())

    def _client(self, port: ActionClientPort, first: int) -> ActionClient:
        number = first + len(self.senders)
        departures = (number,) if port.cancel is None else (number, number + 1)
        client = ActionClient(self._traffic, port, self._places, departures)
        self.senders += [client.send, client.send_cancel][: len(departures)]
        return client

    def _server(self, port: ActionServerPort, first: int) -> ActionServer:
        server = ActionServer(self._traffic, port, lambda goal: self.accepts(port.channel, goal))
        for number, entry in enumerate(port.entries):
            cancel = self._places[port.cancels[number]] if port.cancels else None
            slot = Slot(server, number, self._places[entry], cancel)
            for outcome, places in port.outcomes.items():
                slot.exits[outcome] = self._places[places[number]]
                slot.departures[outcome] = first + len(self.senders)
                self.senders.append(partial(server.finish, slot, outcome))
            if port.feedbacks:
                slot.feedback = self._places[port.feedbacks[number]]
                slot.departures["feedback"] = first + len(self.senders)
                self.senders.append(partial(server.send_feedback, slot))
            server.slots.append(slot)
        return server

    @property
    def waiting_goals(self) -> int:
        """How many goals wait for a slot."""
        return sum(len(server.waiting) for server in self.servers.values())

    def cancel_of(self, transition: int) -> CancelRequest | None:
        """Return what the handlers of a transition learn of requests to cancel; None: it is of no goal."""
        slot = self._slots.get(transition)
        return None if slot is None else slot.request

    def begin(self, transport: Transport) -> None:
        """Go on with the goals of an earlier life, and let others come and depart."""
        checks = self.checks(transport)
        for server in self.servers.values():
            server.checks = checks
            server.begin()
        for client in self.clients.values():
            client.begin()

    def checks(self, transport: Transport) -> dict[int, Check]:
        """Return what checks the data that comes onto places whose tokens are sent: place -> check."""
        found = [(client.goal, check_of(transport, port)) for port, client in self.clients.items()]
        for port, server in self.servers.items():
            result, feedback = check_of(transport, port, "result"), check_of(transport, port, "feedback")
            for slot in server.slots:
                found += [(place, result) for place in slot.exits.values()]
                found += [] if slot.feedback is None else [(slot.feedback, feedback)]
        return {place: check for place, check in found if check is not None}

    def take(self, port: ActionPort, event: ActionEvent) -> None:
        """Learn of a goal."""
        if isinstance(event, (GoalArrived, CancelArrived)):
            self.servers[cast("ActionServerPort", port)].take(event)
        else:
            self.clients[cast("ActionClientPort", port)].take(event)

    def let_in(self, places: Collection[int]) -> None:
        """Take what waits for room on some places."""
        for client in self.clients.values():
            if not client.places.isdisjoint(places):
                client.let_in()
        for server in self.servers.values():
            if any(slot.entry in places or slot.cancel in places for slot in server.slots):
                server.let_in()

    # Going on after a restart.

    def save(self, checkpoint: SavedState) -> None:
        """Write what is known of goals into a checkpoint."""
        places = self._traffic.engine.structure.places
        checkpoint["goals"] = {
            f"{port.channel}/{port.client}": [
                PendingGoal(
                    message=goal.message.id,
                    data=dict(goal.message.data),
                    accepted=goal.is_accepted,
                    canceled=goal.is_canceled,
                    heard=goal.heard,
                    attempts=goal.attempts,
                )
                for goal in client.goals.values()
            ]
            for port, client in self.clients.items()
            if client.goals
        }
        checkpoint["slots"] = {
            places[slot.entry]: SlotGoal(
                message=slot.goal.id,
                data=dict(slot.goal.data),
                canceling=slot.is_canceling,
                sent=slot.sent,
                feedback=[[number, dict(data)] for number, data in slot.history],
                depth=slot.history.maxlen or 1,
            )
            for server in self.servers.values()
            for slot in server.slots
            if slot.goal is not None
        }
        checkpoint["results"] = {
            port.channel: {
                goal: {"outcome": outcome, "data": dict(data)}
                for goal, (outcome, data) in server.results.items()
            }
            for port, server in self.servers.items()
            if server.results
        }

    def restore(self, checkpoint: SavedState) -> None:
        """Take over what is known of goals from a checkpoint, before `begin`.

        Raises
        ------
        DinerosError
            It speaks of ports that the model does not have.
        """
        clients = {f"{port.channel}/{port.client}": each for port, each in self.clients.items()}
        for key, goals in checkpoint.get("goals", {}).items():
            client = known_port(clients, key, "client of an action")
            for each in goals:
                client.goals[each["message"]] = GoalUnderWay(
                    Message(each["message"], each["data"]),
                    each["accepted"],
                    each["canceled"],
                    each["heard"],
                    each["attempts"],
                )
        places = self._traffic.engine.structure.places
        slots = {places[slot.entry]: slot for server in self.servers.values() for slot in server.slots}
        for entry, kept in checkpoint.get("slots", {}).items():
            slot = known_port(slots, entry, "slot at")
            history = [(int(str(number)), cast("Any", data)) for number, data in kept["feedback"]]
            goal = Message(kept["message"], kept["data"])
            slot.server.restore(slot, goal, kept["canceling"], kept["sent"], history)
        servers = {port.channel: each for port, each in self.servers.items()}
        for channel, results in checkpoint.get("results", {}).items():
            server = known_port(servers, channel, "action")
            for id, result in results.items():
                server.keep(id, result["outcome"], result["data"])


def _slots_of_transitions(structure: Structure, servers: Collection[ActionServer]) -> dict[int, Slot]:
    slots = {(server.port.channel, slot.number + 1): slot for server in servers for slot in server.slots}
    owners = enumerate(zip(structure.channels, structure.instances, strict=True))
    return {
        transition: slot
        for transition, (channel, number) in owners
        if (slot := slots.get((channel or "", number or 0))) is not None
    }
