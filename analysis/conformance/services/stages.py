"""Which step the calls of a run's clients have come to: of each request one, with its id.

A request is made before it is served, then answered, then its response got, or given up anywhere in between;
what is given up is served and answered all the same. What is kept grows with the requests that were lost, not
with a run.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field

from dineros.metamodel.records import Reply, Request, Response, Serve
from dineros.metamodel.records.schema import ServiceStep

Stage = type[ServiceStep]

AFTER: Mapping[Stage, tuple[Stage | None, str, str]] = {
    # what must have happened last to the call, what that is called, and what this step is called
    Request: (None, "", "requested"),
    Serve: (Request, "requested", "served"),
    Reply: (Serve, "served", "answered"),
    Response: (Reply, "answered", "responded to"),
}

_ORDER = {stage: number for number, stage in enumerate(AFTER)}


@dataclass(frozen=True)
class Before:
    """What had become of a client's calls when the traces of client and server begin, by their numbers.

    Attributes
    ----------
    sender : str
        What the ids of its requests begin with.
    requested : int
        How many there were.
    pending : frozenset of int
        Those that the client waited for; the others were over.
    serving : dict of int to int
        Those that the server worked on, and at which instance.
    replied : frozenset of int
        Those whose responses the server keeps; it has answered all before them.
    gives_up : bool
        Whether the client has a time-out: what is over may still be served.
    """

    sender: str
    requested: int
    pending: frozenset[int] = frozenset()
    serving: Mapping[int, int] = field(default_factory=dict)
    replied: frozenset[int] = frozenset()
    gives_up: bool = False

    def is_over(self, number: int) -> bool:
        """Tell whether the client waits for a request no more."""
        return number <= self.requested and number not in self.pending

    def stage(self, number: int) -> Stage:
        """Return how far a request had come at the server."""
        if number in self.serving:
            return Serve
        first = min(self.replied, default=0)
        return Reply if number in self.replied or number < first else Request


class Stages:
    """The calls under way, and what continues of those that were given up."""

    def __init__(self) -> None:
        self._calls: defaultdict[tuple[str, str], dict[str, Stage]] = defaultdict(dict)
        self._late: defaultdict[str, dict[str, Stage]] = defaultdict(dict)
        self._at: dict[tuple[str, str], int] = {}  # instance that serves, or has served, a request
        self._unserved: defaultdict[str, dict[str, None]] = defaultdict(dict)
        self._before: dict[tuple[str, str], Before] = {}
        self._strays: set[tuple[str, str]] = set()

    def begin(self, channel: str, client: str, before: Before) -> None:
        """Note what came before the traces of client and server begin."""
        self._before[channel, client] = before
        calls = self._calls[channel, client]
        for number in sorted({*before.pending, *before.serving, *before.replied}):
            message, stage = f"{before.sender}/{number}", before.stage(number)
            if number in before.serving:
                self._at[channel, message] = before.serving[number]
            if number > before.requested:
                continue  # the client's trace tells that it asks
            if number in before.pending or (stage is Serve and not before.gives_up):
                calls[message] = stage
            elif stage is Serve:
                self._late[channel][message] = stage

    def has_begun_within(self, channel: str) -> bool:
        """Tell whether traces of a channel's clients begin within the run."""
        return any(known == channel for known, _ in self._before)

    def ahead(self, channel: str, client: str, message: str) -> Stage | None:
        """Return how far the server had come with a request that the client's trace is still to tell."""
        before, number = self._before.get((channel, client)), _number(message)
        if before is None or number <= before.requested or before.stage(number) is Request:
            return None
        return before.stage(number)

    def is_over(self, channel: str, client: str, message: str) -> bool:
        """Tell whether a call was over when the client's trace begins."""
        before = self._before.get((channel, client))
        return before is not None and before.is_over(_number(message))

    def message(self, record: ServiceStep, client: str) -> str:
        """Return which call a step is of: the oldest one that it can follow, where it does not say so."""
        after = AFTER[type(record)][0]
        calls = self._calls[record.channel, client]
        return record.message or next((id for id, stage in calls.items() if stage is after), "")

    def of(self, channel: str, client: str, message: str) -> Stage | None:
        """Return the last step of a call that its client waits for; None: there is none."""
        return self._calls[channel, client].get(message)

    def late(self, channel: str, message: str) -> Stage | None:
        """Return the last step of a call that was given up; None: it is none."""
        return self._late[channel].get(message)

    def was_over(self, channel: str, client: str, number: int) -> bool:
        """Tell whether a call was over before the traces begin, while the server had not served it."""
        before = self._before.get((channel, client))
        return before is not None and before.is_over(number) and before.stage(number) is Request

    def is_unknown_late(self, channel: str, client: str, number: int) -> bool:
        """Tell whether a call may have been given up before the traces begin."""
        return self.was_over(channel, client, number) and self._before[channel, client].gives_up

    def instance(self, channel: str, message: str) -> int | None:
        """Return the instance that serves a request, or has served it."""
        return self._at.get((channel, message))

    def waiting(self, channel: str, but: str) -> int:
        """Return how many requests, but for one, can be in the history of a service."""
        unserved = self._unserved[channel]
        return len(unserved) - (but in unserved)

    def is_unserved(self, channel: str, message: str) -> bool:
        """Tell whether a request was made and not served."""
        return message in self._unserved[channel]

    def step(self, record: ServiceStep, client: str, instance: int | None) -> None:
        """Note a step of a call, at a server instance where it has one."""
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
        """Note that a call which was over before the traces begin was given up."""
        self._late[channel][message] = Request
        self._strays.add((channel, message))

    def is_stray(self, channel: str, message: str) -> bool:
        """Tell of a call, once, that it was given up before the traces begin and is served now."""
        is_stray = (channel, message) in self._strays
        self._strays.discard((channel, message))
        return is_stray

    def resume(self, channel: str, client: str, message: str) -> None:
        """Note that a call was over before the client's trace begins, and is still to be served."""
        self._calls[channel, client].setdefault(message, Request)

    def give_up(self, channel: str, client: str, message: str) -> None:
        """Note that a client waits for a call no longer."""
        stage = self._calls[channel, client].pop(message)
        if stage is Reply:
            self._at.pop((channel, message), None)
        else:
            self._late[channel][message] = stage

    @staticmethod
    def comes_before(stage: Stage, kind: Stage) -> bool:
        """Tell whether a step of a call is not done when another one was the last."""
        return _ORDER[stage] < _ORDER[kind]


def _number(message: str) -> int:
    text = message.rpartition("/")[2]
    return int(text) if text.isdigit() else 0
