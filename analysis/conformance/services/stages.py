"""The last step of each call in a run, by the id of its request.

A request is sent before it is served, then answered, then its response is received; it may be given up at any
point in between, and is then still served and answered. The stored data grows with the number of lost
requests, not with the length of the run.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field

from dineros.metamodel.records import Reply, Request, Response, Serve
from dineros.metamodel.records.schema import ServiceStep

Stage = type[ServiceStep]

AFTER: Mapping[Stage, tuple[Stage | None, str, str]] = {
    # the required last step of the call, its description, and the description of this step
    Request: (None, "", "requested"),
    Serve: (Request, "requested", "served"),
    Reply: (Serve, "served", "answered"),
    Response: (Reply, "answered", "responded to"),
}

_ORDER = {stage: number for number, stage in enumerate(AFTER)}


@dataclass(frozen=True)
class Before:
    """State of a client's calls when the traces of client and server begin, by their numbers."""

    sender: str
    """Prefix of the ids of its requests."""
    requested: int
    pending: frozenset[int] = frozenset()
    """Requests for which the client waited; the others were over."""
    serving: Mapping[int, int] = field(default_factory=dict)
    """Requests being served, with their instances."""
    replied: frozenset[int] = frozenset()
    """Requests whose responses the server keeps; it has answered all requests before them."""
    gives_up: bool = False
    """Whether the client has a time-out: then requests that are over may still be served."""

    def is_over(self, number: int) -> bool:
        """Return whether the client no longer waits for a request."""
        return number <= self.requested and number not in self.pending

    def stage(self, number: int) -> Stage:
        """Return the state of a request at the server."""
        if number in self.serving:
            return Serve
        first = min(self.replied, default=0)
        return Reply if number in self.replied or number < first else Request


class Stages:
    """The calls under way, and the rest of calls that were given up."""

    def __init__(self) -> None:
        self._calls: defaultdict[tuple[str, str], dict[str, Stage]] = defaultdict(dict)
        self._late: defaultdict[str, dict[str, Stage]] = defaultdict(dict)
        self._at: dict[tuple[str, str], int] = {}  # the instance that serves or served a request
        self._unserved: defaultdict[str, dict[str, None]] = defaultdict(dict)
        self._before: dict[tuple[str, str], Before] = {}
        self._strays: set[tuple[str, str]] = set()

    def begin(self, channel: str, client: str, before: Before) -> None:
        """Record the state before the traces of client and server begin."""
        self._before[channel, client] = before
        calls = self._calls[channel, client]
        for number in sorted({*before.pending, *before.serving, *before.replied}):
            message, stage = f"{before.sender}/{number}", before.stage(number)
            if number in before.serving:
                self._at[channel, message] = before.serving[number]
            if number > before.requested:
                continue  # the sending is in the client's trace
            if number in before.pending or (stage is Serve and not before.gives_up):
                calls[message] = stage
            elif stage is Serve:
                self._late[channel][message] = stage

    def has_begun_within(self, channel: str) -> bool:
        """Return whether traces of a channel's clients begin in the middle of the run."""
        return any(known == channel for known, _ in self._before)

    def ahead(self, channel: str, client: str, message: str) -> Stage | None:
        """Return the server's state of a request whose sending is later in the client's trace."""
        before, number = self._before.get((channel, client)), _number(message)
        if before is None or number <= before.requested or before.stage(number) is Request:
            return None
        return before.stage(number)

    def is_over(self, channel: str, client: str, message: str) -> bool:
        """Return whether a call was over when the client's trace begins."""
        before = self._before.get((channel, client))
        return before is not None and before.is_over(_number(message))

    def message(self, record: ServiceStep, client: str) -> str:
        """Return the call of a step; without an id, the oldest call that the step can follow."""
        after = AFTER[type(record)][0]
        calls = self._calls[record.channel, client]
        return record.message or next((id for id, stage in calls.items() if stage is after), "")

    def of(self, channel: str, client: str, message: str) -> Stage | None:
        """Return the last step of a call for which its client waits; None: there is none."""
        return self._calls[channel, client].get(message)

    def late(self, channel: str, message: str) -> Stage | None:
        """Return the last step of a call that was given up; None: it was not."""
        return self._late[channel].get(message)

    def was_over(self, channel: str, client: str, number: int) -> bool:
        """Return whether a call was over before the traces begin, but not served."""
        before = self._before.get((channel, client))
        return before is not None and before.is_over(number) and before.stage(number) is Request

    def is_unknown_late(self, channel: str, client: str, number: int) -> bool:
        """Return whether a call may have been given up before the traces begin."""
        return self.was_over(channel, client, number) and self._before[channel, client].gives_up

    def instance(self, channel: str, message: str) -> int | None:
        """Return the instance that serves or served a request."""
        return self._at.get((channel, message))

    def waiting(self, channel: str, but: str) -> int:
        """Return the number of requests, except one, that can be in the history of a service."""
        unserved = self._unserved[channel]
        return len(unserved) - (but in unserved)

    def is_unserved(self, channel: str, message: str) -> bool:
        """Return whether a request was sent and not served."""
        return message in self._unserved[channel]

    def step(self, record: ServiceStep, client: str, instance: int | None) -> None:
        """Record a step of a call, with its server instance if it has one."""
        calls, before = self._calls[record.channel, client], self._before.get((record.channel, client))
        message, kind = self.message(record, client), type(record)
        late, number = self._late[record.channel], _number(message)
        if isinstance(record, Request):
            calls[message] = Request if before is None else before.stage(number)
            if calls[message] is Request and message:
                self._unserved[record.channel][message] = None
            return
        if isinstance(record, Serve):
            self._unserved[record.channel].pop(message, None)
            self._at[record.channel, message] = instance or 0
        if isinstance(record, Response):
            calls.pop(message, None)
            self._at.pop((record.channel, message), None)
        elif message in late:
            late[message] = kind
            if isinstance(record, Reply):
                del late[message]
                self._at.pop((record.channel, message), None)
        else:
            calls[message] = kind
            if isinstance(record, Reply) and before is not None and before.is_over(number):
                del calls[message]

    def begin_late(self, channel: str, message: str) -> None:
        """Record that a call which was over before the traces begin was given up."""
        self._late[channel][message] = Request
        self._strays.add((channel, message))

    def is_stray(self, channel: str, message: str) -> bool:
        """Return, once, whether a call was given up before the traces begin and is served now."""
        is_stray = (channel, message) in self._strays
        self._strays.discard((channel, message))
        return is_stray

    def resume(self, channel: str, client: str, message: str) -> None:
        """Record that a call was over before the client's trace begins, and is still to be served."""
        self._calls[channel, client].setdefault(message, Request)

    def give_up(self, channel: str, client: str, message: str) -> None:
        """Record that a client has stopped waiting for a call."""
        stage = self._calls[channel, client].pop(message)
        if stage is Reply:
            self._at.pop((channel, message), None)
        else:
            self._late[channel][message] = stage

    @staticmethod
    def comes_before(stage: Stage, kind: Stage) -> bool:
        """Return whether a step of a call has not happened when another one was the last."""
        return _ORDER[stage] < _ORDER[kind]


def _number(message: str) -> int:
    text = message.rpartition("/")[2]
    return int(text) if text.isdigit() else 0
