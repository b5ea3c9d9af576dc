"""Actions between the nodes of one process: goals, cancel requests, feedback and results, one by one."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

from dineros.runtime.channels.goals import (
    CancelAnswered,
    CancelArrived,
    ClientEvent,
    FeedbackArrived,
    GoalAnswered,
    GoalArrived,
    GoalEnded,
    GoalUnknown,
    KnownGoal,
)
from dineros.runtime.channels.transport import Receiver
from dineros.runtime.journal.goals import KEPT_RESULTS
from dineros.runtime.nets.ports import ActionClientPort, ActionServerPort, Data, Message, OutcomeKind


@dataclass(eq=False)
class _Client:
    """A client and the events under way to it."""

    receiver: Receiver
    port: ActionClientPort
    waiting: deque[ClientEvent] = field(default_factory=deque)
    feedback: deque[FeedbackArrived] = field(default_factory=deque)


class LocalAction:
    """An action channel.

    Parameters
    ----------
    changed : callable
        Runs an action that changes the channels and notifies waiting threads.
    """

    def __init__(self, changed: Callable[[Callable[[], None]], None]) -> None:
        self._changed = changed
        self._server: tuple[Receiver, ActionServerPort] | None = None
        self._clients: dict[str, _Client] = {}
        self._goals: deque[Message] = deque()  # under way to the server
        self._asked: dict[str, Message] = {}  # received by the server, not answered yet
        self._cancels: deque[str] = deque()
        self._owners: dict[str, str] = {}
        self._active: set[str] = set()
        self._results: dict[str, tuple[OutcomeKind, Data]] = {}

    @property
    def has_server(self) -> bool:
        """Whether a node serves it."""
        return self._server is not None

    # Clients and servers.

    def add_client(self, receiver: Receiver, port: ActionClientPort) -> None:
        """Join a client."""
        self._clients[port.client] = _Client(receiver, port)

    def add_server(self, receiver: Receiver, port: ActionServerPort) -> None:
        """Join a server; goals that an earlier server had not answered are sent to it."""
        self._server = (receiver, port)
        self._goals.extendleft(reversed(self._asked.values()))
        self._asked.clear()

    def remove(self, receiver: Receiver) -> None:
        """Remove the clients and servers of a node; messages under way stay in their queues."""
        if self._server is not None and self._server[0] is receiver:
            self._server = None
        self._clients = {id: each for id, each in self._clients.items() if each.receiver is not receiver}

    def restore(self, goals: Sequence[KnownGoal]) -> None:
        """Restore the goals with which a server continues; clients are informed of goals that it lost."""
        lost = self._active - {goal.message.id for goal in goals}
        self._active = {goal.message.id for goal in goals if goal.outcome is None}
        self._results |= {g.message.id: (g.outcome, g.message.data) for g in goals if g.outcome is not None}
        for goal in lost:
            self._tell(goal, GoalUnknown(goal))

    # Messages that nodes send.

    def send(self, port: ActionClientPort, message: Message) -> None:
        """Queue a goal."""
        self._owners[message.id] = port.client
        self._goals.append(message)

    def follow(self, port: ActionClientPort, message: Message) -> None:
        """Have a restarted client informed of how its goal ended, or of its end later."""
        goal = message.id
        self._owners[goal] = port.client
        if goal in self._results:
            self._tell(goal, GoalEnded(goal, *self._results[goal]))
        elif goal not in self._active and self._server is not None:
            self._tell(goal, GoalUnknown(goal))

    def cancel(self, goal: str) -> None:
        """Queue a cancel request."""
        self._cancels.append(goal)

    def give_feedback(self, goal: str, number: int, data: Data, depth: int) -> None:
        """Queue feedback; the oldest feedback is lost if more than `depth` messages wait."""
        client = self._clients.get(self._owners.get(goal, ""))
        if client is not None:
            client.feedback.append(FeedbackArrived(goal, number, data))
            while len(client.feedback) > max(1, depth):
                client.feedback.popleft()

    def finish(self, goal: str, outcome: OutcomeKind, data: Data) -> None:
        """Queue a result, and keep it."""
        self._active.discard(goal)
        self._results[goal] = (outcome, data)
        while len(self._results) > KEPT_RESULTS:
            forgotten = next(iter(self._results))
            del self._results[forgotten]
            self._owners.pop(forgotten, None)
        self._tell(goal, GoalEnded(goal, outcome, data))

    def _tell(self, goal: str, event: ClientEvent) -> None:
        client = self._clients.get(self._owners.get(goal, ""))
        if client is not None:
            client.waiting.append(event)

    # Moves.

    def moves(self) -> list[Callable[[], None]]:
        """Return the possible moves."""
        moves: list[Callable[[], None]] = []
        if self._server is not None and self._goals:
            moves.append(partial(self._ask, *self._server))
        if self._server is not None and self._cancels:
            moves.append(partial(self._ask_to_cancel, *self._server))
        for client in self._clients.values():
            if client.feedback:
                moves.append(partial(self._deliver, client, client.feedback))
            elif client.waiting:  # a result is delivered after all feedback
                moves.append(partial(self._deliver, client, client.waiting))
        return moves

    def _ask(self, receiver: Receiver, port: ActionServerPort) -> None:
        message = self._goals.popleft()
        self._asked[message.id] = message

        def answer(is_accepted: bool) -> None:
            def tell() -> None:
                self._asked.pop(message.id, None)
                if is_accepted and message.id not in self._results:
                    self._active.add(message.id)
                self._tell(message.id, GoalAnswered(message.id, is_accepted))
                if message.id in self._results:
                    self._tell(message.id, GoalEnded(message.id, *self._results[message.id]))

            self._changed(tell)

        receiver.action_event(port, GoalArrived(message, answer))

    def _ask_to_cancel(self, receiver: Receiver, port: ActionServerPort) -> None:
        goal = self._cancels.popleft()

        def answer(canceling: Sequence[str]) -> None:
            self._changed(lambda: self._tell(goal, CancelAnswered(goal, goal in canceling)))

        receiver.action_event(port, CancelArrived((goal,), answer))

    @staticmethod
    def _deliver(client: _Client, queue: deque[ClientEvent] | deque[FeedbackArrived]) -> None:
        client.receiver.action_event(client.port, queue.popleft())
