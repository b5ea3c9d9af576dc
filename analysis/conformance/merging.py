"""Merges the traces of several nodes into one sequence of steps that the flattened net allows.

The steps of each node keep their order; between nodes, only messages order steps, since clocks differ. A
node's steps on its own places do not depend on other nodes. Only one kind of step can make a step of another
node impossible: if a message is taken too early, a publisher's queue that drops a message later is not full.
So if messages are dropped, takes wait until nothing else can be replayed. If that is not sufficient, the
merge restarts and first replays only the causal past of the drop.

If messages have no ids, a server's step does not identify the request that it serves, which must have been
sent before. So such a step also waits until nothing else can be replayed.
"""

from __future__ import annotations

import heapq
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from random import Random

from dineros.analysis.conformance.refusals import Fault, Waiting
from dineros.analysis.conformance.replay import Replay
from dineros.metamodel.records import (
    Drop,
    GoalStep,
    Publish,
    Record,
    Reply,
    Request,
    Serve,
    Stop,
    Take,
)

_WAKING = (Publish, Take, Drop, Request, Serve, Reply, GoalStep)
"""The reasons for which a step may wait."""


class Feed:
    """The records of one node that are available.

    `records`: all records, read when needed; without it, records are added as they arrive.
    """

    def __init__(self, records: Iterable[Record] | None = None) -> None:
        self._rest: Iterator[Record] = iter(() if records is None else records)
        self._ahead: deque[Record] = deque()
        self.closed = records is not None
        self.position = 0
        self.last: Record | None = None

    def add(self, record: Record) -> None:
        """Append a record."""
        self._ahead.append(record)

    def head(self) -> Record | None:
        """Return the next record; None: there is none yet, or no more."""
        if not self._ahead:
            following = next(self._rest, None)
            if following is None:
                return None
            self._ahead.append(following)
        return self._ahead[0]

    def following(self) -> Record | None:
        """Return the record after the next."""
        if self.head() is not None and len(self._ahead) == 1:
            following = next(self._rest, None)
            if following is not None:
                self._ahead.append(following)
        return self._ahead[1] if len(self._ahead) > 1 else None

    @property
    def held(self) -> int:
        """Number of records that were added or read, and not replayed."""
        return len(self._ahead)

    def pop(self) -> None:
        """Advance to the next record."""
        self.last = self._ahead.popleft()
        self.position += 1

    @property
    def has_stopped(self) -> bool:
        """Whether the node ended in order: then no step is missing."""
        return isinstance(self.last, Stop)


class Merger:
    """Replays the records of several nodes in an order that the messages allow.

    Parameters
    ----------
    feeds : dict of str to Feed
        The records of each node.
    takes_last : bool
        Whether takes wait until nothing else can be replayed, instead of following the order of the clocks.
    is_dropped : callable
        Returns for a publish record whether the message was lost in the publisher's queue; None: this is not
        known yet.
    draw : Random, optional
        Draws the order of calls whose server does not know the client; without it, clocks decide.

    Attributes
    ----------
    forces : bool
        Whether a message of ROS 2 is lost if nothing else can be replayed, because no further records follow.
        Until then, a loss waits for the next record, which identifies the lost message.
    """

    def __init__(
        self,
        replay: Replay,
        feeds: Mapping[str, Feed],
        takes_last: bool,
        is_dropped: Callable[[Feed, Publish], bool | None],
        draw: Random | None = None,
    ) -> None:
        self.replay = replay
        self.feeds = feeds
        self.failed: dict[str, tuple[Record, Fault]] = {}
        self.waiting: dict[str, tuple[Record, Waiting]] = {}
        self._takes_last = takes_last
        self._is_dropped = is_dropped
        self._draw = draw
        self._ready: list[tuple[int, float, int, str]] = []
        self._queued: set[str] = set()
        self._pushed = 0
        self._forced: str | None = None
        self.forces = True

    def advance(self, until: Mapping[str, int] | None = None) -> None:
        """Replay as many steps as possible.

        `until`: for each node, the maximum number of records to replay.
        """
        for node in self.feeds:
            self._push(node, until)
        while self._ready or self._force(until):
            _, _, _, node = heapq.heappop(self._ready)
            self._queued.discard(node)
            record = self.feeds[node].head()
            assert record is not None
            dropped = isinstance(record, Publish) and self._is_dropped(self.feeds[node], record)
            if dropped is None:
                continue
            following = self.feeds[node].following() if isinstance(record, Drop) else None
            if isinstance(record, Drop) and following is None and not self.forces:
                continue
            forced, self._forced = self._forced == node, None
            refusal = self.replay.step(record, dropped, forced, following)
            if isinstance(refusal, Fault):
                self.failed[node] = (record, refusal)
                continue
            if isinstance(refusal, Waiting):
                self.waiting[node] = (record, refusal)
                continue
            self.feeds[node].pop()
            self._push(node, until)
            self._wake(node, record, until)

    def _force(self, until: Mapping[str, int] | None) -> bool:
        """Let the oldest waiting step continue by losing a message; return whether there is one."""
        forcible = [
            (record.time or 0.0, node)
            for node, (record, waiting) in self.waiting.items()
            if waiting.is_forcible and self.forces
        ]
        if forcible:
            self._forced = min(forcible)[1]
            del self.waiting[self._forced]
            self._push(self._forced, until)
        return bool(self._ready)

    def retry(self) -> None:
        """Retry steps that wait to know whether a message was lost, since more may be known now."""
        for node, (_, waiting) in list(self.waiting.items()):
            if waiting.is_forcible:
                del self.waiting[node]

    def skip(self, node: str) -> None:
        """Skip the record at which a node failed or waits."""
        self.failed.pop(node, None)
        self.waiting.pop(node, None)
        self.feeds[node].pop()

    def is_unclear(self, node: str) -> bool:
        """Return whether a node waits but might not in another order of messages without ids."""
        _, waiting = self.waiting[node]
        is_stuck = any(sender in self.waiting for sender in waiting.senders)
        return waiting.unclear or (waiting.unclear_if_stuck and is_stuck)

    def _wake(self, node: str, record: Record, until: Mapping[str, int] | None) -> None:
        """Retry nodes that wait for this step."""
        for other, (_, refusal) in list(self.waiting.items()):
            if node in refusal.senders and isinstance(record, _WAKING):
                del self.waiting[other]
                self._push(other, until)

    def _push(self, node: str, until: Mapping[str, int] | None) -> None:
        if node in self._queued or node in self.failed or node in self.waiting:
            return
        feed = self.feeds[node]
        if until is not None and feed.position >= until.get(node, 0):
            return
        record = feed.head()
        if record is None:
            return
        self._pushed += 1
        heapq.heappush(self._ready, (*self._urgency(record), self._pushed, node))
        self._queued.add(node)

    def _urgency(self, record: Record) -> tuple[int, float]:
        """Return the priority of a step whose order is free; the step with the greatest number comes last.

        A time-out of a client comes when nothing else can be replayed: no step waits for it, and its request
        uses room in the history of its service from then on, unless it is served before.
        """
        if record.declared.comes_last:
            return 4, record.time or 0.0
        if self.replay.is_ambiguous(record):
            if self._draw is not None:
                return self._draw.choice((0, 1, 3)), self._draw.random()
            return int(isinstance(record, Serve)), record.time or 0.0
        return 2 * (self._takes_last and isinstance(record, (Take, Drop))), record.time or 0.0
