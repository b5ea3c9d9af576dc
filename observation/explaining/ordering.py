"""In which order recorded messages may have been published.

A recorder sees the messages of one topic in their order. Those of different topics reach it on different
ways, so that two which come shortly after each other may have been published the other way round. Which of
them were published before a message is open until all that may have been have come.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from dineros.metamodel.errors import BudgetError
from dineros.observation.explaining.following import Follower, State

MOST_ORDERS = 5_000
"""Sets of messages at once that may have been published before the others."""

Early = frozenset[int]
"""Numbers of messages that were published before some that came before them."""

NONE: Early = frozenset()

TRAIL = 64
"""Messages, at least, of which the order is remembered in which they were published."""


@dataclass(frozen=True, slots=True)
class Published:
    """A message in one of the orders, and those before it.

    Attributes
    ----------
    before : Published or None
        The message before it; None: it is the first that is remembered.
    topic : str
        Its topic.
    state : State
        What was possible before it.
    count : int
        How many messages are remembered.
    """

    before: Published | None
    topic: str
    state: State
    count: int


@dataclass(frozen=True, slots=True)
class Way:
    """What is possible after some messages, and one of the orders in which they may have been published."""

    state: State
    trail: Published | None = None


@dataclass(frozen=True)
class Seen:
    """A message, as far as its order goes.

    Attributes
    ----------
    number : int
        Of the messages followed, from 1.
    topic : str
        Full name.
    time : int
        In nanoseconds.
    """

    number: int
    topic: str
    time: int


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

    Attributes
    ----------
    open : deque of Seen
        Messages that came last: whether they were published before others is open.
    """

    def __init__(self, follower: Follower, start: State, tolerance: int) -> None:
        self._follower = follower
        self._tolerance = tolerance
        self.open: deque[Seen] = deque()
        self._ways: dict[Early, Way] = {NONE: Way(start)}
        self._is_whole = True

    def add(self, message: Seen) -> Seen | None:
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

    def finish(self) -> Seen | None:
        """Take the end of the messages; return the first that no run shows, None where there is none."""
        while self.open:
            if not self._settle():
                return self.open[0]
        return None

    def possible(self) -> set[str]:
        """Return the topics on which a message may have been published next, in one of the orders."""
        return {topic for way in self._ways.values() for topic in self._follower.possible(way.state)}

    def trail(self) -> tuple[State, list[str], bool]:
        """Return the state before the last messages, their topics in one order, and whether they are all.

        Of several orders of the same messages one is remembered. Where what came later fits to another of
        them only, the messages before that are left out.
        """
        way = self._ways[min(self._ways, key=len)]
        last = _remembered(way.trail)
        for first, published in enumerate(last):
            topics = [each.topic for each in last[first:]]
            if self._leads_on(published.state, topics):
                return published.state, topics, self._is_whole and first == 0
        return way.state, [], self._is_whole and not last

    def _leads_on(self, state: State, topics: list[str]) -> bool:
        for topic in topics:
            state = self._follower.step(state, topic)
            if not state:
                return False
        return True

    def _settle(self) -> bool:
        """Let the first open message have been published; tell whether it can have been."""
        first = self.open[0]
        if len(self.open) == 1 and len(self._ways) == 1 and NONE in self._ways:
            way = self._step(self._ways[NONE], first.topic)
            found = {NONE: way} if way.state else {}
        else:
            found = self._settled(first)
        if found:
            self._ways = found
            self.open.popleft()
        return bool(found)

    def _settled(self, first: Seen) -> dict[Early, Way]:
        found: dict[Early, Way] = {}
        pending = dict(self._ways)
        near = self._near(first.topic)
        for early in [early for early in pending if first.number in early]:
            found[early - {first.number}] = pending.pop(early)
        while pending:
            if len(pending) + len(found) > MOST_ORDERS:
                raise BudgetError(
                    f"messages may have been published in too many orders at message {first.number:,}",
                    hint="a smaller --tolerance leaves fewer",
                )
            # Fewest first: when a set's turn comes, all ways to it are known.
            early = min(pending, key=len)
            way = pending.pop(early)
            self._join(found, early, self._step(way, first.topic))
            for message in self._next(early, near - {first.topic}):
                self._join(pending, early | {message.number}, self._step(way, message.topic))
        return found

    def _near(self, topic: str) -> set[str]:
        """Return the topics of open messages that make a difference if they are published before one.

        The others can as well be published after it: no order of theirs has to do with any order of these.
        """
        left = {message.topic for message in self.open}
        found, reached = {topic}, [topic]
        while reached:
            one = reached.pop()
            met = {other for other in left - found if not self._follower.are_independent(one, other)}
            found |= met
            reached += met
        return found

    def _next(self, early: Early, topics: set[str]) -> list[Seen]:
        """Return the first open message of each of some topics that was not published early."""
        found: dict[str, Seen] = {}
        for message in self.open:
            if message.topic in topics and message.number not in early:
                found.setdefault(message.topic, message)
        return list(found.values())

    def _step(self, way: Way, topic: str) -> Way:
        trail = way.trail
        if trail is not None and trail.count >= 2 * TRAIL:
            trail, self._is_whole = _shortened(trail), False
        count = 1 if trail is None else trail.count + 1
        return Way(self._follower.step(way.state, topic), Published(trail, topic, way.state, count))

    def _join(self, ways: dict[Early, Way], early: Early, way: Way) -> None:
        """Add a way; of those to the same messages, one order is remembered and all markings are."""
        if way.state:
            known = ways.get(early)
            if known is not None:
                way = Way(self._follower.union(known.state, way.state), known.trail)
            ways[early] = way


def _remembered(last: Published | None) -> list[Published]:
    """Return the messages of a trail, from the first on."""
    found = []
    while last is not None:
        found.append(last)
        last = last.before
    return found[::-1]


def _shortened(last: Published) -> Published:
    """Return the end of a trail."""
    trail = None
    for count, published in enumerate(_remembered(last)[-TRAIL:], 1):
        trail = Published(trail, published.topic, published.state, count)
    assert trail is not None
    return trail
