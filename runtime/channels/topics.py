"""Publishers and subscribers of a node."""

from __future__ import annotations

import threading
from collections import deque

from dineros.metamodel.message_ids import MessageIdError, Senders, parse_id
from dineros.runtime.channels.traffic import SendError, Traffic
from dineros.runtime.nets.ports import Message, PublisherPort, Queue, SubscriberPort
from dineros.runtime.scheduling.timers import IDLE


class Writer:
    """The state shared by the places of a publisher's port; on a server page, one place per instance.

    Attributes
    ----------
    history : deque of Message
        The last messages, as many as the queue holds.
    """

    def __init__(self, traffic: Traffic, port: PublisherPort) -> None:
        self._traffic = traffic
        self.port = port
        self.history: deque[Message] = deque(maxlen=max(1, port.limit))

    def send_again(self) -> None:
        """Publish again the messages that the queue held when the process ended.

        Receivers ignore those that they had received.

        Raises
        ------
        SendError
            The transport failed.
        """
        transport = self._traffic.joined
        for message in tuple(self.history):
            try:
                transport.publish_again(self.port, message)
            except Exception as error:
                raise SendError(f"cannot publish on {self.port.topic}: {error}") from error


class Publisher:
    """Sends the tokens of a place on a topic."""

    def __init__(self, traffic: Traffic, writer: Writer, place: str) -> None:
        self._traffic = traffic
        self._writer = writer
        self.port = writer.port
        self.place, self._name = traffic.places[place], place
        self.departure = traffic.add_departure(self.place, self.send, self.port)
        self._about = {"channel": self.port.channel}

    def send(self) -> None:
        """Publish the oldest token."""
        traffic, port, place = self._traffic, self.port, self.place
        if not traffic.is_active:
            self._discard("inactive")
            return
        token = traffic.engine.oldest(place)
        message = Message(traffic.next_id(port.place), token.data)
        try:
            is_sent = traffic.joined.publish(port, message)
        except Exception as error:
            raise SendError(f"cannot publish on {port.topic}: {error}") from error
        if not is_sent:
            self._discard("publisher")
            return
        traffic.engine.take(place)
        traffic.count_sent(port.place)
        self._writer.history.append(message)
        if traffic.observer.is_observing:
            traffic.left("publish", self._about, self._name, token, message.id)

    def _discard(self, queue: Queue) -> None:
        """Drop the oldest token: the queue is full, or the node of a lifecycle publisher is not active."""
        traffic = self._traffic
        token = traffic.engine.take(self.place)
        traffic.drops[self.port.channel, queue] += 1
        place, change = self._name, {self._name: -1}
        traffic.observer.emit(
            "drop", **self._about, place=place, token=token.id, queue=queue, count=1, change=change
        )


class Subscriber:
    """Puts a token for each message of a topic.

    Attributes
    ----------
    seen : Senders
            Messages received or known to be lost: repeated messages are ignored.
    missing : int
            Number of messages lost since the last one was received.
    place : int
            The place onto which their tokens are put.
    is_late : bool
            Whether a deadline was missed and its place has had no room for the token since.
    """

    def __init__(self, traffic: Traffic, port: SubscriberPort) -> None:
        self._traffic = traffic
        self._port = port
        self._about = {"channel": port.channel}
        self._deadline = IDLE
        self._due = 0.0
        self.is_late = False
        self.place = traffic.places[port.place]
        self.seen = Senders()
        self.missing = 0
        self._lock = threading.Lock()

    def had(self, message: Message) -> bool:
        """Return whether a message was received before; from any thread."""
        known = _number_of(message)
        with self._lock:
            return known is not None and self.seen.had(*known)

    def skipped(self, message: Message) -> int:
        """Return how many of its publisher's messages before this one are missing; from any thread."""
        known = _number_of(message)
        with self._lock:
            return self.seen.skipped(*known) if known is not None else 0

    def has_room(self) -> bool:
        """Return whether its place has room for a message; from any thread."""
        return self._traffic.engine.has_room(self.place)

    def lost(self, queue: Queue, count: int) -> None:
        """Count and record messages that a full queue lost; they will not arrive."""
        if queue != "restart":  # forged ids must not make this node ignore real messages
            self.missing += count
        self._traffic.lost(self._port, queue, count, self._port.place)

    def arrived(self, message: Message, lost: int) -> None:
        """Put the token of a new message; `lost` messages are missing just before it."""
        traffic, port = self._traffic, self._port
        if not traffic.plausible(port.channel, port.topic, message.id):
            return
        known = parse_id(message.id)
        if known is not None and lost:  # a publisher that continues sends earlier messages again
            lost = self.seen.lacks(*known, lost)
        if lost > 0:
            self.lost("subscriber", lost)
        if known is not None and self.had(message):
            return
        token = traffic.arriving(port.topic, self.place, message.data)
        if token is None:
            return
        if known is not None:
            with self._lock:
                self.seen.add(*known, self.missing)
        self.missing = 0
        traffic.engine.put(self.place, token)
        if traffic.observer.is_observing:
            traffic.came("take", self._about, port.place, token, message.id)
        if port.missed is not None and port.quality.deadline is not None:
            self._expect_next(port.quality.deadline)

    def _expect_next(self, deadline: float) -> None:
        """Restart the deadline of the next message; one timer serves any number of messages."""
        timers = self._traffic.loop.timers
        self.is_late = False
        self._due = timers.now + deadline
        if self._deadline is IDLE:
            self._deadline = timers.call_later(deadline, self._look)

    def _look(self) -> None:
        """Miss the deadline, or wait longer if a message arrived since the timer was started."""
        timers = self._traffic.loop.timers
        if (left := self._due - timers.now) > 0:
            self._deadline = timers.call_later(left, self._look)
        else:
            self._deadline = IDLE
            self.miss()

    def miss(self) -> None:
        """Put the token of a missed deadline; if its place is full, `is_late` is set to retry later."""
        traffic, name = self._traffic, self._port.missed
        assert name is not None, "then no deadline runs"
        place = traffic.places[name]
        self.is_late = not traffic.engine.has_room(place)
        token = None if self.is_late else traffic.arriving(self._port.topic, place, {})
        if token is not None:
            traffic.engine.put(place, token)
            traffic.came("miss", self._about, name, token, None)


def _number_of(message: Message) -> tuple[str, int] | None:
    """Return sender and number of a message; None if it has no id, or an implausible one."""
    try:
        return parse_id(message.id)
    except MessageIdError:
        return None
