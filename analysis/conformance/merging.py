"""The traces of several nodes as one sequence of steps that the flattened net allows.

Each node's steps keep their order; between nodes, only messages order steps, since clocks differ. What a
node does to its own places depends on no other node, and of all that a node can do, only two things can
harm another's step: a message taken too early leaves a publisher's queue that drops later not full, and
nothing else. So when messages are dropped, takes wait until nothing else can be done; and where that is not
enough, the merge begins again and first does only what must have come before the drop.

Where messages have no ids, a server's step does not say whose request it serves; it can only be one that was
made before. So such a step waits, too, until nothing else can be done.
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
"""What a step may wait for."""


class Feed:
    """The records of one node, as far as they are there.

    Parameters
    ----------
    records : iterable of Record, optional
        All of them, read when they are needed; without it, they are added as they come.
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
        """Return the next record, or None where there is none (yet)."""
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
        """How many records have come, or were read, and are not replayed."""
        return len(self._ahead)

    def pop(self) -> None:
        """Go on to the record after the next."""
        self.last = self._ahead.popleft()
        self.position += 1

    @property
    def has_stopped(self) -> bool:
        """Whether the node ended in good order: nothing it did can be missing."""
        return isinstance(self.last, Stop)


class Merger:
    """Replays the records of several nodes in an order that the messages allow.

    Parameters
    ----------
    replay : Replay
        The net and its marking.
    feeds : dict of str to Feed
        The records of each node.
    takes_last : bool
        Whether takes wait until nothing else can be done, instead of the clocks' order.
    is_dropped : callable
        Tells of a publish record whether the message was lost in the publisher's queue; None: that cannot be
        told yet.
    draw : Random, optional
        Draws the order of calls whose server does not know whose they are; without it, clocks tell it.

    Attributes
    ----------
    forces : bool
        Whether a message of ROS 2 is lost when nothing else can be done: there is nothing more to come. Until
        then a loss waits for the record after it, which says whose message was lost.
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
        """Replay all that can be.

        Parameters
        ----------
        until : dict of str to int, optional
            Of each node, how many records may be replayed.
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
        """Let the oldest step continue that loses a message; return whether there is one."""
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
        """Try steps again that wait to know whether a message was lost: more may be known now."""
        for node, (_, waiting) in list(self.waiting.items()):
            if waiting.is_forcible:
                del self.waiting[node]

    def skip(self, node: str) -> None:
        """Pass over the record at which a node has failed, or waits."""
        self.failed.pop(node, None)
        self.waiting.pop(node, None)
        self.feeds[node].pop()

    def is_unclear(self, node: str) -> bool:
        """Tell whether a node waits that might not in another order of messages without ids."""
        _, waiting = self.waiting[node]
        is_stuck = any(sender in self.waiting for sender in waiting.senders)
        return waiting.unclear or (waiting.unclear_if_stuck and is_stuck)

    def _wake(self, node: str, record: Record, until: Mapping[str, int] | None) -> None:
        """Try nodes again that wait for what has happened."""
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
        """Return the order of steps that can come in any: what comes last has the greater number.

        A client gives up when nothing else can be done: nobody waits for that, and its request takes room in
        the history of its service from then on, if it is not served before.
        """
        if record.declared.comes_last:
            return 4, record.time or 0.0
        if self.replay.is_ambiguous(record):
            if self._draw is not None:
                return self._draw.choice((0, 1, 3)), self._draw.random()
            return int(isinstance(record, Serve)), record.time or 0.0
        return 2 * (self._takes_last and isinstance(record, (Take, Drop))), record.time or 0.0
