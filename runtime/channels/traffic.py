"""The state that all ports of a node share: the transport, message ids, and tokens of received messages.

A message is sent before it is recorded, with an id determined by the records. A node that is killed in
between sends the message again with the same id, and a receiver that has it ignores the copy. A received
message is recorded before anything depends on it.
"""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable, Mapping
from typing import TypeVar

from dineros.metamodel.errors import DinerosError, FeatureValueError
from dineros.metamodel.message_ids import MessageIdError, parse_id
from dineros.runtime.channels.transport import Transport
from dineros.runtime.firing.observing import FiringObserver
from dineros.runtime.nets.engine import Engine
from dineros.runtime.nets.ports import Check, Data, Port, Queue
from dineros.runtime.nets.tokens import Token
from dineros.runtime.scheduling.loop import Loop

LOG = logging.getLogger("dineros.runtime")
T = TypeVar("T")


class SendError(DinerosError):
    """The transport did not accept a message."""


class Traffic:
    """The state shared by the ports of one node.

    Attributes
    ----------
    transport : Transport or None
        None until the node is open.
    is_active : bool
            Whether publishers send; a managed node that is not active loses its messages.
    run : str
            Part of the ids of messages, after the node's id.
    places : dict of str to int
        Numbers of the node's places, by id.
    senders : dict of int to callable
            The function that sends the oldest token of each departure.
    departures : dict of int to (str, str or None)
            For each departure, the id of its place, and its channel if the data passes a port.
    checks : dict of int to callable
            Place -> function that raises for data that cannot be sent from there; empty until the node is
            open.
    numbers : dict of str to int
        Place of a publisher's or client's port -> number of its last message.
    drops : Counter
            Number of messages lost, by channel and queue.
    refused : Counter
            Number of messages refused, by channel: an implausible id, or an announcement without a message.
    """

    def __init__(self, engine: Engine, loop: Loop, observer: FiringObserver, run: str) -> None:
        self.engine = engine
        self.loop = loop
        self.observer = observer
        self.transport: Transport | None = None
        self.is_active = True
        self.run = run
        self.places = {id: number for number, id in enumerate(engine.structure.places)}
        self.senders: dict[int, Callable[[], None]] = {}
        self.departures: dict[int, tuple[str, str | None]] = {}
        self.checks: dict[int, Check] = {}
        self._sending: list[tuple[int, Port, str]] = []
        self.numbers: dict[str, int] = {}
        self.drops: Counter[tuple[str, str]] = Counter()
        self.refused: Counter[str] = Counter()

    @property
    def joined(self) -> Transport:
        """The transport; asserts that there is one."""
        assert self.transport is not None, "no message is sent before the node is open"
        return self.transport

    def add_departure(
        self, place: int, send: Callable[[], None], port: Port | None = None, part: str = ""
    ) -> int:
        """Register a place whose tokens are sent.

        Parameters
        ----------
        place : int
            The place.
        send : callable
            Sends its oldest token; if the transport fails, it raises `SendError` and the token stays there.
        port, part : Port and str, optional
            The port through which the token's data passes, so that the transport can check it.

        Returns
        -------
        int
            The number of the departure, which is on hold at first.
        """
        number = self.engine.add_departure(place)
        self.senders[number] = send
        self.departures[number] = self.engine.structure.places[place], port.channel if port else None
        if port is not None:
            self._sending.append((place, port, part))
        return number

    def join(self, transport: Transport) -> None:
        """Use this transport from now on."""
        self.transport = transport
        found = {place: transport.check(port, part) for place, port, part in self._sending}
        self.checks = {place: check for place, check in found.items() if check is not None}

    def check(self, place: int, data: Data) -> None:
        """Raise an error for data that cannot be sent from a place."""
        if (check := self.checks.get(place)) is not None:
            check(data)

    def next_id(self, place: str) -> str:
        """Return the id of the next message of a port's place; `count_sent` marks it as used."""
        return self.id_of(place, self.numbers.get(place, 0) + 1)

    def id_of(self, place: str, number: int) -> str:
        """Return the id of a message of a port's place."""
        node = self.engine.structure.ports.node
        sender = f"{node}@{self.run}" if self.run else node
        return f"{sender}/{place}/{number}"

    def count_sent(self, place: str) -> None:
        """Count a message of a port's place."""
        self.numbers[place] = self.numbers.get(place, 0) + 1

    def plausible(self, channel: str, name: str, message_id: str) -> bool:
        """Return whether a message has a plausible id or no id; other messages are refused."""
        try:
            parse_id(message_id)
        except MessageIdError as error:
            self.refuse(channel, name, error)
            return False
        return True

    def refuse(self, channel: str, name: str, error: Exception) -> None:
        """Count a message that is refused, and log and record the first one.

        A sender may send millions of such messages; one line and one record suffice.
        """
        self.refused[channel] += 1
        if self.refused[channel] == 1:
            self.log_error(f"a message of {name} is dropped: {error}; further ones are only counted")

    def arriving(self, name: str, place: int, data: Data) -> Token | None:
        """Return the token of received data for a place; None: the data is refused by its type."""
        engine = self.engine
        try:
            return engine.new_token(engine.passing.checkers[place].complete(data))
        except FeatureValueError as error:
            self.refuse(name, name, DinerosError(f"it does not fit the token type: {error}"))
            return None

    def log_error(self, text: str, policy: str | None = None, cause: BaseException | None = None) -> None:
        """Log and record that a message could not be sent or received."""
        LOG.error("%s", text, exc_info=cause)
        self.observer.tell_error(text, policy)

    def came(
        self, event: str, about: Mapping[str, object], place: str, token: Token, message: str | None
    ) -> None:
        """Record that a message put a token onto a place; call only if there is an observer."""
        self.observer.emit(
            event,
            **about,
            place=place,
            token=token.id,
            message=message,
            data=token.data,
            change={place: 1},
        )

    def left(self, event: str, about: Mapping[str, object], place: str, token: Token, message: str) -> None:
        """Record that a token left a place as a message; call only if there is an observer."""
        change = {place: -1}
        self.observer.emit(event, **about, place=place, token=token.id, message=message, change=change)

    def lost(self, port: Port, queue: Queue, count: int, place: str | None = None) -> None:
        """Count and record messages that a full queue lost before they reached a place."""
        self.drops[port.channel, queue] += count
        self.observer.emit("drop", channel=port.channel, queue=queue, place=place, count=count, change={})


def known_port(table: Mapping[str, T], key: str, kind: str) -> T:
    """Return the port of a key in a checkpoint.

    Raises
    ------
    DinerosError
        The model has none.
    """
    if key not in table:
        raise DinerosError(
            f"the node cannot continue: the model has no {kind} {key!r}",
            hint="continue with the model of the first run, or start again",
        )
    return table[key]
