"""What all ports of a node share: the transport, the ids of messages, the tokens of what arrives.

A message is sent before it is recorded, with an id that the records determine: a node that is killed in
between sends it again with the same id, and whoever had it ignores it. What arrives is recorded before
anything depends on it.
"""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Mapping
from typing import TypeVar

from dineros.metamodel.errors import DinerosError, FeatureValueError
from dineros.metamodel.message_ids import MessageIdError, parse_id
from dineros.runtime.channels.transport import Transport
from dineros.runtime.firing.observing import Observer
from dineros.runtime.nets.engine import Engine
from dineros.runtime.nets.ports import Data, Port, PublisherPort, Queue, SubscriberPort
from dineros.runtime.nets.tokens import Token
from dineros.runtime.scheduling.loop import Loop

LOG = logging.getLogger("dineros.runtime")
T = TypeVar("T")


class SendError(DinerosError):
    """The transport did not take a message."""


class Traffic:
    """What the ports of one node share.

    Attributes
    ----------
    transport : Transport or None
        None until the node is open.
    is_active : bool
        Whether publishers send; those of a managed node lose what is published while it is not active.
    run : str
        Goes into the ids of messages after the node's id.
    numbers : dict of str to int
        Place of a publisher's or client's port -> number of its last message.
    drops : Counter
        Messages lost, by channel and queue.
    refused : Counter
        Messages that were not taken, by channel: no plausible id, or an announcement of none.
    """

    def __init__(self, engine: Engine, loop: Loop, observer: Observer, run: str) -> None:
        self.engine = engine
        self.loop = loop
        self.observer = observer
        self.transport: Transport | None = None
        self.is_active = True
        self.run = run
        self.numbers: dict[str, int] = {}
        self.drops: Counter[tuple[str, str]] = Counter()
        self.refused: Counter[str] = Counter()

    @property
    def joined(self) -> Transport:
        """The transport, once there is one."""
        assert self.transport is not None, "nothing departs before the node is open"
        return self.transport

    def next_id(self, place: str) -> str:
        """Return the id of the next message of a port's place; `count_sent` makes it used."""
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
        """Return whether a message has a plausible id, or none; others are refused."""
        try:
            parse_id(message_id)
        except MessageIdError as error:
            self.refuse(channel, name, error)
            return False
        return True

    def refuse(self, channel: str, name: str, error: Exception) -> None:
        """Count a message that is not taken; the first is said.

        Whoever sends one such message can send millions: no more than one line and record tells of them.
        """
        self.refused[channel] += 1
        if self.refused[channel] == 1:
            text = f"a message of {name} is dropped: {error}; others like it are only counted"
            LOG.error("%s", text)
            self.tell_error(text, None)

    def arriving(self, name: str, place: int, data: Data) -> Token | None:
        """Return the token of what arrives for a place; None: it does not fit its type, which is recorded."""
        engine = self.engine
        try:
            return engine.new_token(engine.checkers[place].complete(data))
        except FeatureValueError as error:
            text = f"a message of {name} does not fit the token type: {error}"
            LOG.error("%s", text)
            self.tell_error(text, None)
            return None

    def tell_error(self, text: str, policy: str | None) -> None:
        """Record that a message could not be sent or taken."""
        self.observer.emit("error", transition=None, handler=None, error=text, attempt=1, policy=policy)

    def lost(self, port: Port, queue: Queue, count: int) -> None:
        """Count and record messages that a full queue lost."""
        self.drops[port.channel, queue] += count
        place = port.place if isinstance(port, (PublisherPort, SubscriberPort)) else None
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
            f"the node cannot go on: the model has no {kind} {key!r}",
            hint="go on with the model of the first run, or start anew",
        )
    return table[key]
