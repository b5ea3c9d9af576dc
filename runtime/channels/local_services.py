"""Services between the nodes of one process: requests and responses, one by one.

Under the rules of ROS 2, requests stay in the history of their service until its server takes them; a full
history loses its oldest request.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial

from dineros.runtime.channels.transport import Answer, Receiver
from dineros.runtime.nets.ports import ClientPort, Message, ServerPort

Request = tuple[str, Message]
"""The key of the client, and the request."""


@dataclass
class LocalClient:
    """The receiver of a client's responses, and the responses under way to it."""

    receiver: Receiver
    port: ClientPort
    waiting: deque[Message] = field(default_factory=deque)

    def respond(self) -> None:
        """Deliver the oldest response."""
        self.receiver.response_arrived(self.port, self.waiting.popleft())


class LocalService:
    """Requests under way to a server, and requests that it has not answered.

    Parameters
    ----------
    changed : callable
            Runs an action that changes the channels and notifies waiting threads; from any thread.
    clients : mapping of str to LocalClient
            All clients, by key.
    """

    def __init__(
        self, changed: Callable[[Callable[[], None]], None], clients: Mapping[str, LocalClient]
    ) -> None:
        self._changed = changed
        self._clients = clients
        self._server: tuple[Receiver, ServerPort] | None = None
        self._depth: int | None = None  # most requests that may wait; None: any number, delivered one by one
        self._waiting: deque[Request] = deque()
        self._again: deque[Request] = deque()  # repeated requests that the server has taken: use no room
        self._unanswered: dict[tuple[str, str], Message] = {}  # for a server that restarts
        self._lost: list[str] = []  # not yet reported to the server
        self._is_told = True  # the server was notified of requests or losses and will fetch them

    @property
    def has_server(self) -> bool:
        """Whether a node serves it."""
        return self._server is not None

    def serve(self, receiver: Receiver, port: ServerPort, depth: int | None) -> None:
        """Join a server; requests that an earlier server had not answered are sent to it."""
        self._server, self._depth = (receiver, port), depth
        again = [(key, message) for (key, _), message in self._unanswered.items()]
        self._waiting.extendleft(reversed(again))
        self._unanswered.clear()
        waiting, self._waiting = self._waiting, deque()
        for request in waiting:
            self._put(request)
        self._is_told = False
        self._forget_oldest()

    def leave(self) -> None:
        """Remove the server; requests under way stay in their queue."""
        self._server = None

    def moves(self) -> list[Callable[[], None]]:
        """Return the possible moves."""
        if self._server is None:
            return []
        moves: list[Callable[[], None]] = [partial(self._hand_on, self._again)] if self._again else []
        if self._depth is not None and not self._is_told:
            moves.append(self._tell)
        elif self._depth is None and self._waiting:
            moves.append(partial(self._hand_on, self._waiting))
        return moves

    def ask(self, key: str, message: Message) -> None:
        """Queue a request; one that waits already uses no more room."""
        if (key, message) not in self._waiting:
            self._put((key, message))
        self._is_told = False
        self._forget_oldest()

    def take(self) -> tuple[Message, Answer] | None:
        """Return the oldest request that waits, and the function that sends its response."""
        return self._taken(self._waiting) if self._waiting else None

    def lost(self) -> list[str]:
        """Return the ids of the requests that a full history has lost since the last call."""
        lost, self._lost = self._lost, []
        return lost

    def forget(self, key: str, message_id: str) -> None:
        """Discard a request that its client has given up, so that no restarted server receives it."""
        self._unanswered.pop((key, message_id), None)

    def _put(self, request: Request) -> None:
        is_known = False
        if self._server is not None and self._depth is not None:
            receiver, port = self._server
            is_known = receiver.knows_request(port, request[1].id)
        (self._again if is_known else self._waiting).append(request)

    def _forget_oldest(self) -> None:
        while self._depth is not None and len(self._waiting) > self._depth:
            _, message = self._waiting.popleft()
            self._lost.append(message.id)

    def _tell(self) -> None:
        """Notify the server that requests wait."""
        assert self._server is not None
        self._is_told = True
        receiver, port = self._server
        receiver.requests_wait(port)

    def _hand_on(self, requests: deque[Request]) -> None:
        assert self._server is not None
        receiver, port = self._server
        receiver.request_arrived(port, *self._taken(requests))

    def _taken(self, requests: deque[Request]) -> tuple[Message, Answer]:
        key, message = requests.popleft()
        self._unanswered[key, message.id] = message

        def respond(response: Message) -> None:
            if self._unanswered.get((key, message.id)) is message:
                del self._unanswered[key, message.id]
            client = self._clients.get(key)
            if client is not None:
                client.waiting.append(response)

        return message, lambda response: self._changed(lambda: respond(response))
