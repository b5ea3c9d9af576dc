"""Calls whose server does not know the client: requests without ids, as with an existing service type.

The client that a server instance serves is decided as late as possible. The server's own places do not depend
on that decision; only a response shows that its client was served before, by an instance that got its request
after that client had sent it. Until then, a call is assigned to some client: requests to calls in order,
which fits if any assignment fits. A response is assigned to the earliest call that fits, which leaves most
freedom for the others.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import islice

from dineros.analysis.conformance.player import Player
from dineros.metamodel.records import Record, Reply, Serve


def is_nameless(record: Record) -> bool:
    """Return whether a record belongs to a server that does not know the client of the request."""
    return isinstance(record, (Serve, Reply)) and not record.message and not record.client


_Ask = tuple[str, str]
"""Client and message of a request."""


@dataclass(eq=False)
class _Call:
    """A call that is served or was answered: its instance, and the positions of its firings."""

    instance: int
    served: int
    answered: int | None = None


class NamelessCalls:
    """The calls of one service channel.

    Parameters
    ----------
    player : Player
        Its marking and firings are changed when a call is reassigned to another client.
    channel : str
        Id of the service channel.
    """

    def __init__(self, player: Player, channel: str) -> None:
        self._net, self._marking, self._firings = player.net, player.marking, player.firings
        self._channel = channel
        self._asking: dict[_Ask, int] = {}  # request -> number of the firing, the oldest request first
        self._calls: list[_Call] = []  # not assigned permanently, the oldest first
        self._are_there = False

    @property
    def are_ambiguous(self) -> bool:
        """Whether there were such calls of several clients: then the order of requests matters."""
        return self._are_there and len(self._net.clients_of(self._channel)) > 1

    @property
    def has_answers(self) -> bool:
        """Whether an answered call has not been matched with its response."""
        return any(call.answered is not None for call in self._calls)

    def asks(self, client: str, message: str, firing: int) -> None:
        """Record a client's request."""
        self._asking[client, message] = firing

    def forget(self, client: str, message: str) -> bool:
        """Remove a request that is given up; False: it is unknown whether it is served."""
        if self._calls:
            return False
        self._asking.pop((client, message), None)
        return True

    def next_client(self) -> str | None:
        """Return the client to which the next call is assigned first; None: no request waits."""
        ask = next(islice(self._asking, len(self._calls), None), None)
        return None if ask is None else ask[0]

    def served(self, instance: int, firing: int) -> None:
        """Record that an instance serves the next client."""
        self._calls.append(_Call(instance, firing))
        self._are_there = True

    def client_at(self, instance: int) -> str | None:
        """Return the client that an instance serves, as far as it is known; None: it is idle."""
        call = self._open_at(instance)
        return None if call is None else self._ascribed(self._calls, self._asking)[call][0]

    def answered(self, instance: int, firing: int) -> None:
        """Record that an instance has answered."""
        call = self._open_at(instance)
        assert call is not None
        call.answered = firing

    def respond(self, client: str, message: str) -> bool:
        """Assign an answered call permanently to a client's request, if there is one that fits."""
        since = self._asking.get((client, message))
        if since is None:
            return False
        fitting = (call for call in self._calls if call.answered is not None and call.served > since)
        return self._settle((client, message), next(fitting, None))

    def claim(self, client: str, message: str) -> bool:
        """Remove a request whose call turns out to have an id, if the others can account for all calls."""
        ask = client, message
        return ask not in self._asking or self._settle(ask, None, is_known=True)

    def _settle(self, ask: _Ask, call: _Call | None, is_known: bool = False) -> bool:
        if call is None and not is_known:
            return False
        asking = {other: since for other, since in self._asking.items() if other != ask}
        calls = [other for other in self._calls if other is not call]
        after = self._ascribed(calls, asking)
        if len(after) < len(calls) or any(call.served < asking[other] for call, other in after.items()):
            return False
        before = self._ascribed(self._calls, self._asking)
        if call is not None:
            after[call] = ask
        for changed, (owner, _) in after.items():
            if before[changed][0] != owner:
                self._ascribe(changed, before[changed][0], owner)
        self._asking, self._calls = asking, calls
        return True

    def _ascribe(self, call: _Call, old: str, new: str) -> None:
        """Reassign a call to another client, in the marking and in the firings."""
        for kind, firing in ((Serve, call.served), (Reply, call.answered)):
            if firing is None:
                continue
            wrong, right = (self._transition(kind, client, call.instance) for client in (old, new))
            for transition, sign in ((wrong, -1), (right, 1)):
                for place, tokens in self._net.net.delta[transition].items():
                    self._marking[place] += sign * tokens
            if self._firings is not None:
                self._firings[firing] = right

    def _open_at(self, instance: int) -> _Call | None:
        return next((c for c in self._calls if c.instance == instance and c.answered is None), None)

    @staticmethod
    def _ascribed(calls: Iterable[_Call], asking: Mapping[_Ask, int]) -> dict[_Call, _Ask]:
        return dict(zip(calls, asking, strict=False))

    def _transition(self, kind: type[Serve | Reply], client: str, instance: int) -> int:
        transition = self._net.service(kind, self._channel, client, instance)
        assert transition is not None, (self._channel, client, instance)
        return transition
