"""Reads calls from a recording: events of service introspection among the messages.

A client publishes events when it has sent a request and received the response, a server when it has received
the request and sent the response; both only if introspection was configured
(`rclpy.client.Client.configure_introspection`). Events do not name the node. Each event is published after
its step, by a thread that may have been interrupted in between; so a request may be reported as received
before it is reported as sent, which is corrected here.
"""

from __future__ import annotations

from collections import Counter, defaultdict, deque
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

from dineros.metamodel.errors import counted
from dineros.observation.recordings.reading import Recording
from dineros.observation.systems import (
    OF_EVENTS,
    REQUEST_RECEIVED,
    REQUEST_SENT,
    RESPONSE_RECEIVED,
    RESPONSE_SENT,
    SERVICE_EVENTS,
    RecordedTopic,
    event_name,
    full_name,
)

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

_INFO = "service_msgs/msg/ServiceEventInfo"
_INFO_SIZE = 44
"""Bytes of an event that describe the call, including the header of CDR; request or response follow."""

LATE = 1_000_000_000
"""Largest delay in nanoseconds of an event behind its consequence."""
MOST_LATE = 10_000
"""Limit of the messages in between."""
MOST_CALLS = 100_000
"""Limit of the remembered calls without a response."""

_BEFORE = {REQUEST_RECEIVED: REQUEST_SENT, RESPONSE_RECEIVED: RESPONSE_SENT}
_ANSWERS = {RESPONSE_RECEIVED: REQUEST_SENT, RESPONSE_SENT: REQUEST_RECEIVED}


class Event(NamedTuple):
    """An event of a call: one of `SERVICE_EVENTS`, its client, the number of its request."""

    kind: str
    client: bytes
    number: int


class Untaken(NamedTuple):
    """Responses that a server sent and that no client took."""

    service: str
    """Its name."""
    responses: int
    """How many."""
    seconds: float
    """From the first of them to the end of the recording."""

    def __str__(self) -> str:
        responses = counted(self.responses, "response")
        since = f"the first one {self.seconds:.3g} s before the end"
        return f"{self.service}: answered, never taken: {responses}, {since}"


@dataclass
class Calls:
    """The events of the two ends of a service."""

    events: Counter[str] = field(default_factory=Counter)
    """The number of each event."""
    clients: defaultdict[str, set[bytes]] = field(default_factory=lambda: defaultdict(set))
    """By event: the clients of the calls. The two ends use different numbers for a client."""
    answers: dict[str, tuple[int, float, float]] = field(default_factory=dict)
    """Of the server (`RESPONSE_SENT`) and of clients (`RESPONSE_RECEIVED`), as far as they tell: how many
    answers, and the seconds until the soonest and the latest one.
    """
    _open: dict[tuple[str, bytes, int], int] = field(default_factory=dict)
    _sent: dict[int, list[int]] = field(default_factory=dict)
    _taken: Counter[int] = field(default_factory=Counter)

    def add(self, event: Event, time: int) -> None:
        """Add an event."""
        self.events[event.kind] += 1
        if len(self.clients[event.kind]) < MOST_CALLS:
            self.clients[event.kind].add(event.client)
        self._match(event, time)
        asked = _ANSWERS.get(event.kind)
        if asked is None:
            if len(self._open) < MOST_CALLS:
                self._open[event] = time
            return
        began = self._open.pop((asked, event.client, event.number), None)
        if began is not None:
            delay = max(0, time - began) / 1e9
            count, least, most = self.answers.get(event.kind, (0, delay, delay))
            self.answers[event.kind] = count + 1, min(least, delay), max(most, delay)

    def untaken(self, end: int) -> tuple[int, int] | None:
        """Return the number of untaken responses, and when the first was sent; None if there are none.

        Those of the last second before the end may still be taken. Without events of clients the result is
        None.
        """
        if RESPONSE_SENT not in (told := self.told()) or REQUEST_SENT not in told:
            return None
        times = [time for sent in self._sent.values() for time in sent if time < end - LATE]
        return (len(times), min(times)) if times else None

    def _match(self, event: Event, time: int) -> None:
        """Match responses sent with responses taken, by their numbers; either may be recorded first."""
        number = event.number
        if event.kind == RESPONSE_SENT:
            if self._taken[number] > 0:
                self._taken[number] -= 1
            elif len(self._sent) < MOST_CALLS:
                self._sent.setdefault(number, []).append(time)
        elif event.kind == RESPONSE_RECEIVED:
            if number in self._sent:
                self._sent[number].pop(0)
                if not self._sent[number]:
                    del self._sent[number]
            elif len(self._taken) < MOST_CALLS:
                self._taken[number] += 1
        if not self._taken[number]:
            del self._taken[number]

    def told(self) -> list[str]:
        """Return the events that each call has; events of only one client are not among them."""
        heard = max((len(self.clients[each]) for each in (REQUEST_RECEIVED, RESPONSE_SENT)), default=0)
        sent = max((len(self.clients[each]) for each in (REQUEST_SENT, RESPONSE_RECEIVED)), default=0)
        of_clients = (REQUEST_SENT, RESPONSE_RECEIVED) if sent and sent >= heard else ()
        of_server = (REQUEST_RECEIVED, RESPONSE_SENT) if heard else ()
        return [each for each in SERVICE_EVENTS if each in (*of_clients, *of_server)]


class Observed:
    """The messages of a recording, including the events of services.

    `recording`: an open recording; its events of calls are read once at the start.

    Raises
    ------
    RecordingError
        The recording is damaged, or an event is invalid.
    """

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._services = {f"{each.name}{OF_EVENTS}": each for each in recording.services}
        self.calls = {each.name: Calls() for each in recording.services}
        """By service."""
        for topic, time, data in recording.messages(self._services):
            self.calls[self._services[topic].name].add(self._event(topic, data), time)
        end = recording.start + recording.duration - 1
        self.untaken = tuple(
            Untaken(name, found[0], (end - found[1]) / 1e9)
            for name, calls in self.calls.items()
            if (found := calls.untaken(end))
        )
        """Services with responses that no client took."""
        self._told = {name: calls.told() for name, calls in self.calls.items()}
        self.recorded = (
            *(
                replace(topic, name=full_name(topic.name))
                for topic in recording.topics
                if topic.name not in self._services
            ),
            *(
                RecordedTopic(event_name(each.name, kind), each.type, (), self.calls[each.name].events[kind])
                for each in recording.services
                for kind in self._told[each.name]
            ),
        )
        """Its topics by their full names, and the events of services that publish every call, by their names
        (`event_name`).
        """

    def messages(self) -> Iterator[tuple[str, int]]:
        """Yield name and time in nanoseconds of each message and event, in order of their times."""
        if not self._services:
            for topic, time, _ in self._recording.messages():
                yield full_name(topic), time
            return
        ahead: deque[_RecordedMessage] = deque()
        coming = iter(self._all())
        waiting: Counter[tuple[str, str, int]] = Counter()
        while True:
            told = ahead.popleft() if ahead else next(coming, None)
            if told is None:
                return
            event = told.event
            if event is not None:
                if event.kind not in self._told[told.name]:
                    continue
                before = _BEFORE.get(event.kind)
                if before is None:
                    waiting[told.name, event.kind, event.number] += 1
                elif before in self._told[told.name]:
                    key = told.name, before, event.number
                    if waiting[key] > 0:
                        waiting[key] -= 1
                    elif _taken(told._replace(event=Event(before, b"", event.number)), ahead, coming):
                        yield event_name(told.name, before), told.time
                    if not waiting[key]:
                        del waiting[key]
                if len(waiting) > MOST_CALLS:
                    waiting.clear()
            yield told.name if event is None else event_name(told.name, event.kind), told.time

    def _all(self) -> Iterator[_RecordedMessage]:
        for topic, time, data in self._recording.messages():
            service = self._services.get(topic)
            if service is None:
                yield _RecordedMessage(full_name(topic), time, None)
            else:
                yield _RecordedMessage(service.name, time, self._event(topic, data))

    def _event(self, topic: str, data: bytes) -> Event:
        from rosbags.serde import SerdeError

        try:
            info = _types().deserialize_cdr(data[:_INFO_SIZE], _INFO)
        except SerdeError as error:
            raise self._recording.error(
                f"topic {topic} has a message that is not an event: {error}"
            ) from error
        kind = int(info.event_type)  # type: ignore[attr-defined]
        if kind >= len(SERVICE_EVENTS):
            raise self._recording.error(f"topic {topic} has an event of the unknown kind {kind}")
        client, number = bytes(info.client_gid), int(info.sequence_number)  # type: ignore[attr-defined]
        return Event(SERVICE_EVENTS[kind], client, number)


class _RecordedMessage(NamedTuple):
    """A message, or an event of a service; by the name of topic or service."""

    name: str
    time: int
    event: Event | None


def _taken(
    wanted: _RecordedMessage, ahead: deque[_RecordedMessage], coming: Iterator[_RecordedMessage]
) -> bool:
    """Take an event from the next messages if it comes soon; return whether it does."""
    assert wanted.event is not None
    place = 0
    while place < MOST_LATE:
        if place == len(ahead):
            told = next(coming, None)
            if told is None:
                return False
            ahead.append(told)
        found = ahead[place]
        if found.time > wanted.time + LATE:
            return False
        event = found.event
        if (
            event is not None
            and found.name == wanted.name
            and (event.kind, event.number) == (wanted.event.kind, wanted.event.number)
        ):
            del ahead[place]
            return True
        place += 1
    return False


@cache
def _types() -> Typestore:
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS2_JAZZY)
