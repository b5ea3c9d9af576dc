"""Determines the orders in which recorded messages may have been published.

A recorder sees the messages of one topic in their order. Messages of different topics take different paths,
so two messages that arrive shortly after each other may have been published in the other order. The messages
that preceded a message are known only when all candidates have arrived.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from dineros.metamodel.errors import BudgetError
from dineros.observation.explaining.commuting import Commuting
from dineros.observation.explaining.following import Follower, State

MOST_ORDERS = 5_000
"""Limit of the sets of messages that may have been published before the others."""

Early = int
"""Messages published before earlier arrivals: bit `n` is the `n`-th open message."""

NONE: Early = 0

TRAIL = 64
"""Least number of messages whose order of publication is remembered."""


@dataclass(slots=True)
class Way:
    """The possible markings after some messages, and one possible order of their publication."""

    state: State
    """What is possible."""
    topic: str = ""
    """The topic of the last message."""
    before: Way | None = None
    """The order up to that message; None: earlier messages are not remembered."""


@dataclass(frozen=True)
class SeenMessage:
    """The order data of a message."""

    number: int
    """Of the messages followed, from 1."""
    topic: str
    """Full name."""
    time: int
    """In nanoseconds."""


class Ordering:
    """Follows messages in every order that their times allow.

    Parameters
    ----------
    follower : Follower
        The model.
    start : State
        What is possible before them.
    tolerance : int
        Nanoseconds: messages of different topics no farther apart may have been published in any order.
    """

    def __init__(self, follower: Follower, start: State, tolerance: int) -> None:
        self._follower = follower
        self._tolerance = tolerance
        self._commuting = Commuting(follower)
        self.open: deque[SeenMessage] = deque()
        """Messages that came last: whether they were published before others is open."""
        self._ways: dict[Early, Way] = {NONE: Way(start)}
        self._is_whole = True

    def add(self, message: SeenMessage) -> SeenMessage | None:
        """Take the next message; return the first that no run shows, None while there is none.

        Raises
        ------
        BudgetError
            There are too many orders, or too many markings.
        """
        while self.open and self.open[0].time + self._tolerance < message.time:
            if not self._settle():
                return self.open[0]
        self.open.append(message)
        return None

    def finish(self) -> SeenMessage | None:
        """Process the end of the messages; return the first one that no run shows, None if there is none."""
        while self.open:
            if not self._settle():
                return self.open[0]
        return None

    @property
    def last(self) -> State:
        """The possible markings after all messages, once they are finished."""
        return self._ways[NONE].state

    def possible(self) -> set[str]:
        """Return the topics on which a message could have come instead of one that no run shows."""
        found: set[str] = set()
        masks = self._masks()
        pending = dict(self._ways)
        for _ in range(MOST_ORDERS):
            if not pending:
                break
            early = min(pending, key=int.bit_count)
            way = pending.pop(early)
            found.update(self._follower.possible(way.state))
            for topic, mask in masks.items():
                left = mask & ~early
                if left and not left & 1:
                    self._join(pending, early | (left & -left), self._step(way, topic))
        return found

    def trail(self) -> tuple[State, list[str], bool]:
        """Return the state before the last messages, their topics in one order, and whether they are all.

        If several orders have the same messages, one order is stored. If later messages fit only to another
        one, the messages before it are omitted.
        """
        way = self._ways[min(self._ways, key=int.bit_count)]
        last = _remembered(way)
        for first, published in enumerate(last[:-1]):
            topics = [each.topic for each in last[first + 1 :]]
            if self._leads_on(published.state, topics):
                return published.state, topics, self._is_whole and first == 0
        return way.state, [], self._is_whole and len(last) == 1

    def _leads_on(self, state: State, topics: list[str]) -> bool:
        for topic in topics:
            state = self._follower.step(state, topic)
            if not state:
                return False
        return True

    def _settle(self) -> bool:
        """Assume that the first open message was published; return whether that is possible."""
        first = self.open[0]
        if len(self.open) == 1 and len(self._ways) == 1 and NONE in self._ways:
            way = self._step(self._ways[NONE], first.topic)
            found = {NONE: way} if way.state else {}
        else:
            found = self._settled(first)
        if found:
            self._ways = found
            self.open.popleft()
            if not first.number % TRAIL:
                self._cut_trails()
        return bool(found)

    def _settled(self, first: SeenMessage) -> dict[Early, Way]:
        found: dict[Early, Way] = {}
        # By the number of messages published early: when a set is processed, all orders that lead to it are
        # known.
        pending: list[dict[Early, Way]] = [{} for _ in self.open]
        for early, way in self._ways.items():
            if early & 1:
                found[early >> 1] = way
            else:
                pending[early.bit_count()][early] = way
        # Messages independent of the first one can also be published after it and after all dependent ones.
        masks = self._masks()
        near = self._commuting.near(first.topic, tuple(sorted(masks)))
        orders = 0
        for count, ways in enumerate(pending):
            orders += len(ways)
            if orders > MOST_ORDERS:
                raise BudgetError(
                    f"messages may have been published in too many orders at message {first.number:,}",
                    hint="a smaller --tolerance leaves fewer",
                )
            for early, way in ways.items():
                self._join(found, early >> 1, self._step(way, first.topic))
                left = {topic: masks[topic] & ~early for topic in near if masks[topic] & ~early}
                if not left:
                    continue
                waiting = tuple([(topic, mask.bit_count()) for topic, mask in left.items()])
                for topic in self._commuting.needed(way.state, first.topic, waiting)[1:]:
                    following = early | (left[topic] & -left[topic])
                    self._join(pending[count + 1], following, self._step(way, topic))
        return found

    def _masks(self) -> dict[str, int]:
        """Return which of the open messages are of each topic."""
        masks: dict[str, int] = {}
        bit = 1
        for message in self.open:
            masks[message.topic] = masks.get(message.topic, 0) | bit
            bit <<= 1
        return masks

    def _step(self, way: Way, topic: str) -> Way:
        return Way(self._follower.step(way.state, topic), topic, way)

    def _join(self, ways: dict[Early, Way], early: Early, way: Way) -> None:
        """Add a way; of those to the same messages, one order is remembered and all markings are."""
        if way.state:
            known = ways.get(early)
            if known is not None:
                way = Way(self._follower.union(known.state, way.state), known.topic, known.before)
            ways[early] = way

    def _cut_trails(self) -> None:
        """Forget the beginnings of all orders."""
        for way in self._ways.values():
            last: Way | None = way
            for _ in range(TRAIL):
                last = last.before if last is not None else None
            if last is not None and last.before is not None:
                last.before, self._is_whole = None, False


def _remembered(last: Way | None) -> list[Way]:
    """Return the steps to a message, from the first one that is remembered."""
    found = []
    while last is not None:
        found.append(last)
        last = last.before
    return found[::-1]
