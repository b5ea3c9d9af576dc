"""The action clients and action servers of a node, driven by its `Exchange`."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any, cast

from dineros.runtime.channels.action_clients import ActionClient, GoalUnderWay
from dineros.runtime.channels.action_servers import ActionServer, Slot
from dineros.runtime.channels.goals import ActionEvent, CancelArrived, GoalArrived
from dineros.runtime.channels.traffic import Traffic, known_port
from dineros.runtime.firing.cancels import CancelRequest
from dineros.runtime.journal.saved import GoalResult, GoalState, PendingGoal, SavedState, SlotGoal
from dineros.runtime.nets.ports import (
    ActionClientPort,
    ActionPort,
    ActionServerPort,
    Data,
    Message,
)
from dineros.runtime.nets.structure import Structure


class Actions:
    """The action ports of one node.

    Parameters
    ----------
    traffic : Traffic
            Shared by all ports of the node.
    accepts : callable
            Decides whether an action server (by channel) accepts a goal with this data.
    """

    def __init__(self, traffic: Traffic, accepts: Callable[[str, Data], bool]) -> None:
        structure = traffic.engine.structure
        self._traffic = traffic
        self._accepts = accepts
        self.clients = {port: ActionClient(traffic, port) for port in structure.ports.action_clients}
        self.servers = {port: self._server(port) for port in structure.ports.action_servers}
        self._slots = _slots_of_transitions(structure, self.servers.values())

    def _server(self, port: ActionServerPort) -> ActionServer:
        return ActionServer(self._traffic, port, lambda goal: self._accepts(port.channel, goal))

    @property
    def waiting_goals(self) -> int:
        """Number of goals that wait for a slot."""
        return sum(len(server.waiting) for server in self.servers.values())

    def cancel_of(self, transition: int) -> CancelRequest | None:
        """Return the cancel request that the handlers of a transition see; None: it belongs to no goal."""
        slot = self._slots.get(transition)
        return None if slot is None else slot.request

    def begin(self) -> None:
        """Continue with the goals from before a restart, then release the other departures."""
        for server in self.servers.values():
            server.begin()
        for client in self.clients.values():
            client.begin()

    def take(self, port: ActionPort, event: ActionEvent) -> None:
        """Handle an event about a goal."""
        if isinstance(event, (GoalArrived, CancelArrived)):
            self.servers[cast("ActionServerPort", port)].take(event)
        else:
            self.clients[cast("ActionClientPort", port)].take(event)

    def let_in(self, places: Collection[int]) -> None:
        """Handle what waits for room on these places."""
        for client in self.clients.values():
            if not client.places.isdisjoint(places):
                client.let_in()
        for server in self.servers.values():
            if any(slot.entry in places or slot.cancel in places for slot in server.slots):
                server.let_in()

    # Continuing after a restart.

    def save(self) -> GoalState:
        """Return the state of all goals."""
        places = self._traffic.engine.structure.places
        goals = {
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
        slots = {
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
        results: dict[str, dict[str, GoalResult]] = {
            port.channel: {
                goal: {"outcome": outcome, "data": dict(data)}
                for goal, (outcome, data) in server.results.items()
            }
            for port, server in self.servers.items()
            if server.results
        }
        return {"goals": goals, "slots": slots, "results": results}

    def restore(self, checkpoint: SavedState) -> None:
        """Restore the state of goals from a checkpoint, before `begin`.

        Raises
        ------
        DinerosError
            The checkpoint has ports that the model does not have.
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
