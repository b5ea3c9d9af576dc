"""Topics between the nodes of one process: the queues of the paper, and the histories of ROS 2.

In the paper (Fig. 8 and 9), a message moves from the queue of its publisher to one dispatcher per subscribing
node, and from there to the subscribers of that node. Full queues drop the newest message.

Under ROS 2 (rules R1 to R4), each writer and each reader has a history. A message enters the writer history
of each subscription that matches its publisher, moves from there to the reader history, and moves to the node
when the node takes it. A full history loses its oldest message. As in ROS, the reader detects the loss by the
gap in the publisher's numbers. No message is lost between histories, not even with best effort.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

from dineros.metamodel.matching import unmet
from dineros.runtime.channels.transport import Receiver
from dineros.runtime.nets.ports import Message, PublisherPort, SubscriberPort


@dataclass
class _Queue:
    """Messages that have left their node.

    Attributes
    ----------
    history : deque of Message
            Messages that a late subscriber of a transient-local topic gets.
    again : deque of Message
            Messages that the publisher had sent before a restart.
    """

    port: PublisherPort
    waiting: deque[Message] = field(default_factory=deque)
    history: deque[Message] = field(default_factory=deque)
    again: deque[Message] = field(default_factory=deque)

    def __post_init__(self) -> None:
        self.again = deque(maxlen=max(1, self.port.limit))


@dataclass
class _Dispatcher:
    """Messages for the subscribers of one node."""

    receiver: Receiver
    ports: list[SubscriberPort]
    waiting: deque[Message] = field(default_factory=deque)
    history: deque[Message] = field(default_factory=deque)

    def dispatch(self) -> None:
        """Deliver a message to the subscribers; a late subscriber gets the messages that it missed first."""
        message = (self.history or self.waiting).popleft()
        for port in self.ports:
            self.receiver.message_arrived(port, message, 0)


class QueueTopic:
    """A topic channel of the paper."""

    def __init__(self) -> None:
        self._queues: dict[str, _Queue] = {}
        self._dispatchers: dict[str, _Dispatcher] = {}

    def add_writer(self, key: str, port: PublisherPort) -> None:
        """Join a publisher; a publisher of the same key continues."""
        self._queues.setdefault(key, _Queue(port))

    def add_reader(self, node: str, receiver: Receiver, port: SubscriberPort) -> None:
        """Join a subscription of a node."""
        if node in self._dispatchers:
            self._dispatchers[node].ports.append(port)
            return
        dispatcher = self._dispatchers[node] = _Dispatcher(receiver, [port])
        for queue in self._queues.values():
            dispatcher.history.extend(queue.again)
            if port.is_kept:
                dispatcher.history.extend(queue.history)

    def remove(self, node: str) -> None:
        """Remove the subscriptions of a node, with the messages that wait for them."""
        self._dispatchers.pop(node, None)

    def publish(self, key: str, message: Message) -> bool:
        """Accept a message of a publisher; False: its queue is full."""
        queue = self._queues[key]
        if len(queue.waiting) >= queue.port.limit:
            return False
        queue.waiting.append(message)
        return True

    def publish_again(self, key: str, message: Message) -> None:
        """Accept a message from before a restart; later subscriptions get it too."""
        self._queues[key].again.append(message)
        for dispatcher in self._dispatchers.values():
            dispatcher.history.append(message)

    def moves(self) -> list[Callable[[], None]]:
        """Return the possible moves: a message moves from one queue to the next, or to a node."""
        return [
            *(partial(self._spread, queue) for queue in self._queues.values() if queue.waiting),
            *(each.dispatch for each in self._dispatchers.values() if each.waiting or each.history),
        ]

    def _spread(self, queue: _Queue) -> None:
        """Move a message from a publisher's queue to the dispatcher of each subscribing node."""
        message = queue.waiting.popleft()
        if queue.port.is_kept:
            queue.history.append(message)
            while len(queue.history) > queue.port.limit:
                queue.history.popleft()
        for dispatcher in self._dispatchers.values():
            port = dispatcher.ports[0]
            if len(dispatcher.waiting) < port.dispatcher_limit:
                dispatcher.waiting.append(message)
            else:
                dispatcher.receiver.dropped(port, "dispatcher", 1)


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
        """Deliver the oldest message to the node, with the number of messages missing before it."""
        pair, number, message = self.history.popleft()
        lost, pair.last = max(0, number - pair.last - 1), max(pair.last, number)
        if pair.is_new:  # messages that were under way when both ends stopped are missing, too
            lost = max(lost, self.receiver.messages_skipped(self.port, message))
            pair.is_new = False
        self.receiver.message_arrived(self.port, message, lost)


@dataclass(eq=False)
class _Pair:
    """The messages that a publisher has written for one subscription.

    Attributes
    ----------
    last : int
            Number of the last message that the subscription got.
    is_new : bool
            Whether the subscription has got no message yet.
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
        """Move the oldest message into the reader history."""
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
            Number of its last message, repeated messages included.
    again : int
            Number of repeated messages from before a restart; all subscriptions get them, even late ones.
    kept : deque
            Its last messages with their numbers: the repeated ones and, if late subscriptions get them, new
            ones.
    """

    def __init__(self, port: PublisherPort) -> None:
        self.port = port
        self.depth = max(1, port.limit)
        self.number = self.again = 0
        self.pairs: list[_Pair] = []
        self.kept: deque[tuple[int, Message]] = deque(maxlen=self.depth)

    def match(self, reader: _Reader) -> None:
        """If a subscription matches, write the kept messages for it now, and new messages from now on."""
        if unmet(self.port.quality, reader.port.quality) is not None:
            return
        kept = [each for each in self.kept if reader.port.is_kept or each[0] <= self.again]
        first = kept[0][0] if kept else self.number + 1
        pair = _Pair(self.depth, reader, first - 1)
        self.pairs.append(pair)
        for number, message in kept:
            pair.write(number, message)

    def write(self, message: Message, *, is_again: bool = False) -> None:
        """Write a message for all matching subscriptions, and keep it for later ones."""
        self.number += 1
        if is_again:
            self.again = self.number
        for pair in self.pairs:
            pair.write(self.number, message)
        if is_again or self.port.is_kept:
            self.kept.append((self.number, message))


class HistoryTopic:
    """A topic channel of ROS 2."""

    def __init__(self) -> None:
        self._writers: dict[str, _Writer] = {}
        self._readers: list[_Reader] = []

    def add_writer(self, key: str, port: PublisherPort) -> None:
        """Join a publisher; a publisher of the same key continues."""
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
        """Remove the subscriptions of a node, with the messages that wait for them."""
        self._readers = [reader for reader in self._readers if reader.node != node]
        for writer in self._writers.values():
            writer.pairs = [pair for pair in writer.pairs if pair.reader.node != node]

    def publish(self, key: str, message: Message) -> bool:
        """Accept a message of a publisher; False: its queue is full."""
        self._writers[key].write(message)
        return True

    def publish_again(self, key: str, message: Message) -> None:
        """Accept a message from before a restart; later subscriptions get it too."""
        self._writers[key].write(message, is_again=True)

    def moves(self) -> list[Callable[[], None]]:
        """Return the possible moves: a message moves from one queue to the next, or to a node."""
        pairs = [pair for writer in self._writers.values() for pair in writer.pairs]
        return [
            *(pair.pass_on for pair in pairs if pair.history),
            *(reader.deliver for reader in self._readers if reader.is_due),
        ]


LocalTopic = QueueTopic | HistoryTopic
