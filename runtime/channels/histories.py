"""Topics of ROS 2 between the nodes of one process: a history for each writer and reader (rules R1 to R4).

A message goes into the writer history of each subscription that matches its publisher, from there into the
reader history, and to the node when that takes it. A full history loses its oldest message; as on ROS, the
reader sees that by the gap in the publisher's numbers. Nothing is lost on the way, best effort or not.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from dineros.metamodel.matching import unmet
from dineros.runtime.channels.transport import Receiver
from dineros.runtime.nets.ports import Message, PublisherPort, SubscriberPort


@dataclass(eq=False)
class _Reader:
    """A subscription, and its reader history."""

    node: str
    receiver: Receiver
    port: SubscriberPort
    history: deque[tuple[_Pair, int, Message]] = field(default_factory=deque)

    @property
    def is_due(self) -> bool:
        return bool(self.history) and self.receiver.is_open(self.port)

    def deliver(self) -> None:
        """Hand the oldest message to the node, with how many of its publisher are missing before it."""
        pair, number, message = self.history.popleft()
        lost, pair.last = max(0, number - pair.last - 1), max(pair.last, number)
        if pair.is_new:  # what was under way when both ends stopped is missing, too
            lost = max(lost, self.receiver.messages_skipped(self.port, message))
            pair.is_new = False
        self.receiver.message_arrived(self.port, message, lost)


@dataclass(eq=False)
class _Pair:
    """What a publisher has written for one subscription.

    Attributes
    ----------
    last : int
        Number of its last message that the subscription got.
    is_new : bool
        Whether it got none yet.
    """

    depth: int
    reader: _Reader
    last: int
    history: deque[tuple[int, Message]] = field(default_factory=deque)
    is_new: bool = True

    def write(self, number: int, message: Message) -> None:
        if len(self.history) >= self.depth:
            self.history.popleft()
        self.history.append((number, message))

    def pass_on(self) -> None:
        """Take the oldest message into the reader history."""
        number, message = self.history.popleft()
        waiting = self.reader.history
        if len(waiting) >= max(1, self.reader.port.limit):
            waiting.popleft()
        waiting.append((self, number, message))


class _Writer:
    """A publisher.

    Attributes
    ----------
    number : int
        Of its last message, with those that it sends again.
    again : int
        How many those are: of an earlier life, for all subscriptions, however late.
    kept : deque
        Its last messages with their numbers: those, and, where late subscriptions get them, its own.
    """

    def __init__(self, port: PublisherPort) -> None:
        self.port = port
        self.depth = max(1, port.limit)
        self.number = self.again = 0
        self.pairs: list[_Pair] = []
        self.kept: deque[tuple[int, Message]] = deque(maxlen=self.depth)

    def match(self, reader: _Reader) -> None:
        """Write for a subscription from now on, if it matches; what is kept for it comes first."""
        if unmet(self.port.quality, reader.port.quality) is not None:
            return
        kept = [each for each in self.kept if reader.port.is_kept or each[0] <= self.again]
        first = kept[0][0] if kept else self.number + 1
        pair = _Pair(self.depth, reader, first - 1)
        self.pairs.append(pair)
        for number, message in kept:
            pair.write(number, message)


class HistoryTopic:
    """A topic channel."""

    def __init__(self) -> None:
        self._writers: dict[str, _Writer] = {}
        self._readers: list[_Reader] = []

    def add_writer(self, key: str, port: PublisherPort) -> None:
        """Join a publisher; one that was there before goes on."""
        if key not in self._writers:
            writer = self._writers[key] = _Writer(port)
            for reader in self._readers:
                writer.match(reader)

    def add_reader(self, node: str, receiver: Receiver, port: SubscriberPort) -> None:
        """Join a subscription of a node."""
        reader = _Reader(node, receiver, port)
        self._readers.append(reader)
        for writer in self._writers.values():
            writer.match(reader)

    def remove(self, node: str) -> None:
        """Take the subscriptions of a node away, and what waits for them."""
        self._readers = [reader for reader in self._readers if reader.node != node]
        for writer in self._writers.values():
            writer.pairs = [pair for pair in writer.pairs if pair.reader.node != node]

    def publish(self, key: str, message: Message) -> None:
        """Write a message for all subscriptions that match."""
        writer = self._writers[key]
        writer.number += 1
        for pair in writer.pairs:
            pair.write(writer.number, message)
        if writer.port.is_kept:
            writer.kept.append((writer.number, message))

    def publish_again(self, key: str, message: Message) -> None:
        """Write a message of an earlier life, also for subscriptions that come later."""
        writer = self._writers[key]
        writer.number = writer.again = writer.number + 1
        for pair in writer.pairs:
            pair.write(writer.number, message)
        writer.kept.append((writer.number, message))

    def moves(self) -> list[Callable[[], None]]:
        """Return what can happen now: a message goes on to a reader history, or to a node."""
        pairs = [pair for writer in self._writers.values() for pair in writer.pairs]
        return [
            *(pair.pass_on for pair in pairs if pair.history),
            *(reader.deliver for reader in self._readers if reader.is_due),
        ]
