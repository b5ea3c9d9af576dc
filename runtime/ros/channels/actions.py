"""The action clients and action servers of a ROS node, through `rclpy.action`."""

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
        """Create clients and servers; an answer to a goal or a cancel request may take `timeout` seconds.

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
        """Return a function that raises for data that cannot be sent; `part` names the part of a server."""
        codec = getattr(self._goal_codecs[port], part or "goal")
        return None if codec is None else codec.check

    def close_goals(self) -> None:
        """Destroy clients and servers."""
        ends: list[GoalClient | GoalServer] = [*self._goal_clients.values(), *self._goal_servers.values()]
        for end in ends:
            end.close()
        self._goal_clients.clear()
        self._goal_servers.clear()

    def restore_goals(self, port: ActionServerPort, goals: Sequence[KnownGoal]) -> None:
        """Restore the goals from before a restart."""
        self._goal_servers[port].restore(goals)

    def send_goal(self, port: ActionClientPort, message: Message) -> None:
        """Send a goal once its server is available; the receiver is notified if there is no answer."""
        self._goal_clients[port].send(message)

    def follow_goal(self, port: ActionClientPort, message: Message) -> None:
        """Ask for the result of a goal that was sent before a restart."""
        self._goal_clients[port].send(message, is_accepted=True)

    def cancel_goal(self, port: ActionClientPort, goal: str) -> None:
        """Ask to cancel a goal."""
        self._goal_clients[port].cancel(goal)

    def give_feedback(self, port: ActionServerPort, goal: str, number: int, data: Data) -> None:
        """Publish feedback on a goal."""
        self._goal_servers[port].feedback(goal, number, data)

    def finish_goal(self, port: ActionServerPort, goal: str, outcome: OutcomeKind, data: Data) -> None:
        """End a goal, and send its result to the clients that wait for it."""
        self._goal_servers[port].finish(goal, outcome, data)
