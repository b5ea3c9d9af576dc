"""The actions of a ROS node: both ends of goals, through `rclpy.action`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
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
from dineros.runtime.ros.process.session import RosError


class RosActions:
    """The clients and servers of actions of a ROS node.

    Parameters
    ----------
    node : rclpy.node.Node
        The ROS node.
    receiver : Receiver
        Told of goals.
    timeout : float
        Seconds that an answer to a goal or a request to cancel may take.

    Attributes
    ----------
    clients, servers : dict
        By their ports.
    """

    def __init__(self, node: Any, receiver: Receiver, timeout: float) -> None:
        self._node, self._receiver, self._timeout = node, receiver, timeout
        self.clients: dict[ActionPort, GoalClient] = {}
        self.servers: dict[ActionPort, GoalServer] = {}
        self._codecs: dict[ActionPort, ActionCodecs] = {}

    def open(self, ports: Ports, codecs: Codecs) -> None:
        """Make all of them.

        Raises
        ------
        RosError
            ROS refuses a name.
        InterfaceError
            An interface is not installed, or does not fit the model.
        """
        for server in ports.action_servers:
            found = self._codecs[server] = codecs.action(server)
            with _made(server):
                self.servers[server] = GoalServer(self._node, server, found, self._receiver)
        for client in ports.action_clients:
            found = self._codecs[client] = codecs.action(client)
            with _made(client):
                self.clients[client] = GoalClient(self._node, client, found, self._receiver, self._timeout)

    def check(self, port: ActionPort, part: str) -> Check | None:
        """Return what raises for data that cannot be sent: for a server, of the part that is named."""
        codec = getattr(self._codecs[port], part or "goal")
        return None if codec is None else codec.check

    def close(self) -> None:
        """Take all of them down."""
        for client in self.clients.values():
            client.close()
        for server in self.servers.values():
            server.close()
        self.clients.clear()
        self.servers.clear()


class GoalCarrier:
    """The part of a transport that carries goals."""

    def __init__(self) -> None:
        self._actions: RosActions | None = None

    @property
    def goals(self) -> RosActions:
        """The actions, while they are open."""
        assert self._actions is not None
        return self._actions

    def open_goals(self, actions: RosActions, ports: Ports, codecs: Codecs) -> None:
        """Make clients and servers."""
        self._actions = actions
        actions.open(ports, codecs)

    def close_goals(self) -> None:
        """Take them down."""
        if self._actions is not None:
            self._actions.close()

    def restore_goals(self, port: ActionServerPort, goals: Sequence[KnownGoal]) -> None:
        """Know the goals of an earlier life again."""
        self.goals.servers[port].restore(goals)

    def send_goal(self, port: ActionClientPort, message: Message) -> None:
        """Send a goal, as soon as its server is there; that nobody answers is told to the receiver."""
        self.goals.clients[port].send(message)

    def follow_goal(self, port: ActionClientPort, message: Message) -> None:
        """Ask for the result of a goal of an earlier life."""
        self.goals.clients[port].send(message, is_accepted=True)

    def cancel_goal(self, port: ActionClientPort, goal: str) -> None:
        """Ask to cancel a goal."""
        self.goals.clients[port].cancel(goal)

    def give_feedback(self, port: ActionServerPort, goal: str, number: int, data: Data) -> None:
        """Publish feedback on a goal."""
        self.goals.servers[port].feedback(goal, number, data)

    def finish_goal(self, port: ActionServerPort, goal: str, outcome: OutcomeKind, data: Data) -> None:
        """End a goal, and send its result to those who ask for it."""
        self.goals.servers[port].finish(goal, outcome, data)


@contextmanager
def _made(port: ActionPort) -> Iterator[None]:
    """Say which action ROS refuses."""
    try:
        yield
    except Exception as error:
        text = str(error).strip().partition("\n")[0] or type(error).__name__
        raise RosError(f"the action {port.action!r} cannot be made in ROS: {text}") from error
