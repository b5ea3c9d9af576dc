"""Reads the trace of one node of DiNeROS: runs of callbacks, followed by tokens, and ticks of timers."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from dineros.metamodel.records import Fire, Record, Request, Response
from dineros.observation.measuring.bodies import Bodies, MeasuredCallback
from dineros.observation.measuring.idling import Spans, idle_before
from dineros.observation.measuring.seen import Part, Seen

_INSTANCE = re.compile(r"^[^\[\]]*\[\d+\]\.")
_MOST_OPEN = 100_000
"""Limit of the tokens of open runs; the oldest are discarded."""

_Key = tuple[str, object]


@dataclass(eq=False)
class _Run:
    callback: MeasuredCallback
    begun: float
    work: float = 0.0
    keys: set[_Key] = field(default_factory=set)


@dataclass
class _Tick:
    """The last start of a timer's callback, and the earliest time at which it could have started."""

    begun: float
    idle: float


class NodeRuns:
    """Follows the records of one node."""

    def __init__(self, bodies: Bodies) -> None:
        self._bodies = bodies
        self._open: dict[_Key, _Run] = {}
        self._ticks: dict[str, _Tick] = {}
        self.busy = Spans()
        """When its handlers ran."""
        self.since = -math.inf
        """Before this moment the node was not in normal operation: it started, failed, or changed its state.
        """

    def begin(self, moment: float) -> None:
        """Discard earlier data: the node starts, fails, or changes its state."""
        self._open.clear()
        self._ticks.clear()
        self.since = moment

    def fire(self, record: Fire) -> Iterator[Seen]:
        """Process a firing; yield the times that it completes."""
        moment = record.time or 0.0
        took = max(0.0, record.duration or 0.0)
        id = _INSTANCE.sub("", record.transition)
        if record.duration is not None:
            yield Seen(Part("duration", id), took, took, moment, record)
        callback = self._bodies.callbacks.get(id)
        if callback is not None:
            if id in callback.begins:
                yield from self._tick(callback, moment - took, record)
            if callback.ends:
                yield from self._step(callback, id, record, moment, took)
        self.busy.add(moment - took, moment)

    def _tick(self, callback: MeasuredCallback, begun: float, record: Record) -> Iterator[Seen]:
        idle = max(idle_before(begun, self.busy), self.since)
        before = self._ticks.get(callback.id)
        self._ticks[callback.id] = _Tick(begun, idle)
        if before is not None:
            # The strike before was not before `before.idle`, or the callback would have begun then.
            least = idle - before.begun if callback.begins_at_once else -math.inf
            most = begun - before.idle if callback.begins_at_once else math.inf
            yield Seen(Part("period", callback.id), least, most, begun, record)

    def _step(
        self, callback: MeasuredCallback, id: str, record: Fire, moment: float, took: float
    ) -> Iterator[Seen]:
        taken: list[_Key] = [(place, token) for place, tokens in record.taken.items() for token in tokens]
        found = (self._open.get(key) for key in taken)
        run = next((each for each in found if each is not None and each.callback is callback), None)
        if run is None:
            run = _Run(callback, moment - took)
        for key in taken:
            if self._open.get(key) is run:
                del self._open[key]
                run.keys.discard(key)
        run.work += took
        if id in callback.ends:
            for key in run.keys:
                self._open.pop(key, None)
            yield Seen(Part("duration", callback.id), run.work, moment - run.begun, moment, record)
            return
        for place, tokens in record.made.items():
            for token in tokens:
                self._put((place, token.id), run)

    def _put(self, key: _Key, run: _Run) -> None:
        if len(self._open) >= _MOST_OPEN:
            oldest = next(iter(self._open))
            self._open.pop(oldest).keys.discard(oldest)
        self._open[key] = run
        run.keys.add(key)

    def _move(self, key: _Key, other: _Key) -> None:
        run = self._open.pop(key, None)
        if run is not None:
            run.keys.discard(key)
            self._put(other, run)

    def request(self, record: Request) -> None:
        """A run continues with the response to its request."""
        self._move((record.place, record.token), (f"request {record.channel}", record.message))

    def response(self, record: Response) -> None:
        """A response arrives."""
        self._move((f"request {record.channel}", record.message), (record.place, record.token))
