"""The actions of a ROS node: both ends of goals, through `rclpy.action`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from dineros.runtime.channels.goals import KnownGoal
from dineros.runtime.channels.transport import Receiver
from dineros.runtime.nets.ports import (
    ActionClientPort,
    ActionPort,
    ActionServerPort,
    Check,
    Data,
    Message,
    OutcomeKind,
    Ports,
)
from dineros.runtime.ros.channels.action_clients import GoalClient
from dineros.runtime.ros.channels.action_servers import GoalServer
from dineros.runtime.ros.conversion.codecs import ActionCodecs, Codecs
from dineros.runtime.ros.process.session import made_in_ros


class GoalCarrier:
    """The part of a transport that carries goals."""

    def __init__(self) -> None:
        self._goal_clients: dict[ActionPort, GoalClient] = {}
        self._goal_servers: dict[ActionPort, GoalServer] = {}
        self._goal_codecs: dict[ActionPort, ActionCodecs] = {}

    def open_goals(self, node: Any, ports: Ports, codecs: Codecs, receiver: Receiver, timeout: float) -> None:
        """Make clients and servers.

        Parameters
        ----------
        node : rclpy.node.Node
            The ROS node.
        ports : Ports
            Theirs.
        codecs : Codecs
            Of all ports.
        receiver : Receiver
            Told of goals.
        timeout : float
            Seconds that an answer to a goal or a request to cancel may take.

        Raises
        ------
        RosError
            ROS refuses a name.
        InterfaceError
            An interface is not installed, or does not fit the model.
        """
        for server in ports.action_servers:
            found = self._goal_codecs[server] = codecs.action(server)
            with made_in_ros(f"the action {server.action!r}"):
                self._goal_servers[server] = GoalServer(node, server, found, receiver)
        for client in ports.action_clients:
            found = self._goal_codecs[client] = codecs.action(client)
            with made_in_ros(f"the action {client.action!r}"):
                self._goal_clients[client] = GoalClient(node, client, found, receiver, timeout)

    def check_goal(self, port: ActionPort, part: str) -> Check | None:
        """Return what raises for data that cannot be sent: for a server, of the part that is named."""
        codec = getattr(self._goal_codecs[port], part or "goal")
        return None if codec is None else codec.check

    def close_goals(self) -> None:
        """Take clients and servers down."""
        ends: list[GoalClient | GoalServer] = [*self._goal_clients.values(), *self._goal_servers.values()]
        for end in ends:
            end.close()
        self._goal_clients.clear()
        self._goal_servers.clear()

    def restore_goals(self, port: ActionServerPort, goals: Sequence[KnownGoal]) -> None:
        """Know the goals of an earlier life again."""
        self._goal_servers[port].restore(goals)

    def send_goal(self, port: ActionClientPort, message: Message) -> None:
        """Send a goal, as soon as its server is there; that nobody answers is told to the receiver."""
        self._goal_clients[port].send(message)

    def follow_goal(self, port: ActionClientPort, message: Message) -> None:
        """Ask for the result of a goal of an earlier life."""
        self._goal_clients[port].send(message, is_accepted=True)

    def cancel_goal(self, port: ActionClientPort, goal: str) -> None:
        """Ask to cancel a goal."""
        self._goal_clients[port].cancel(goal)

    def give_feedback(self, port: ActionServerPort, goal: str, number: int, data: Data) -> None:
        """Publish feedback on a goal."""
        self._goal_servers[port].feedback(goal, number, data)

    def finish_goal(self, port: ActionServerPort, goal: str, outcome: OutcomeKind, data: Data) -> None:
        """End a goal, and send its result to those who ask for it."""
        self._goal_servers[port].finish(goal, outcome, data)
