"""Matches messages of an existing ROS type to their announcements, which have the ids.

An announcement contains the number of its message, as the middleware counts, and is sent right before it.
Both have a time stamp of the sender's clock. Messages of equal content and number with distant times are
different messages; with close times, from two senders, they are interchangeable.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections import deque
from collections.abc import Callable
from typing import Generic, NamedTuple, TypeVar

from dineros.runtime.nets.ports import Data

WINDOW = 2_000_000_000
"""Maximum time in nanoseconds from an announcement to its message: the sender may be suspended in between."""

ANNOUNCEMENT_LIMIT = 1024
"""Minimum number of announcements kept without their messages."""

HELD_LIMIT = 1024
"""Maximum number of messages that wait for announcements; further ones count as not announced."""

Item = TypeVar("Item")


def content_of(data: Data, number: int) -> bytes:
    """Return a key that is equal for messages of equal content and number, from any senders."""
    return hashlib.blake2b(json.dumps([number, data], sort_keys=True).encode(), digest_size=16).digest()


class _Announcement(NamedTuple):
    content: bytes
    sent: int
    id: str


class _Held(NamedTuple, Generic[Item]):
    content: bytes
    sent: int
    since: float
    item: Item


class Recognition(Generic[Item]):
    """Finds out which arriving messages were announced.

    The announcement of a message arrives on another topic, usually before the message, sometimes after it. So
    a message without announcement waits for a while; messages that remain without one keep their order.

    Parameters
    ----------
    known : callable
        Called with an announced message, or an object for it, and its id.
    strange : callable
        Called with a message that was not announced.
    patience : callable
        Returns how many seconds a message may wait for its announcement.
    limit : int
        Minimum number of announcements to keep.
    clock : callable
        Returns the time in seconds.
    """

    def __init__(
        self,
        known: Callable[[Item, str], None],
        strange: Callable[[Item], None],
        patience: Callable[[], float],
        *,
        limit: int = ANNOUNCEMENT_LIMIT,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._known = known
        self._strange = strange
        self._patience = patience
        self._limit = max(limit, ANNOUNCEMENT_LIMIT)
        self._clock = clock
        self._announcements: dict[int, _Announcement] = {}
        self._by_content: dict[bytes, list[int]] = {}
        self._count = 0
        self._held: deque[_Held[Item]] = deque()

    @property
    def is_waiting(self) -> bool:
        """Whether a message waits for its announcement."""
        return bool(self._held)

    @property
    def is_idle(self) -> bool:
        """Whether neither a message nor an announcement waits."""
        return not self._held and not self._announcements

    def announced(self, content: bytes, sent: int, id: str) -> None:
        """Record an announcement; its message may have arrived before."""
        nearest = min(
            (held for held in self._held if held.content == content),
            key=lambda held: abs(held.sent - sent),
            default=None,
        )
        if nearest is not None and abs(nearest.sent - sent) <= WINDOW:
            self._held.remove(nearest)
            self._known(nearest.item, id)
            return
        self._count += 1
        self._announcements[self._count] = _Announcement(content, sent, id)
        self._by_content.setdefault(content, []).append(self._count)
        if len(self._announcements) > self._limit:
            self._forget(next(iter(self._announcements)))

    def _forget(self, number: int) -> _Announcement:
        found = self._announcements.pop(number)
        numbers = self._by_content[found.content]
        numbers.remove(number)
        if not numbers:
            del self._by_content[found.content]
        return found

    def recognise(self, content: bytes, sent: int, item: Item) -> bool:
        """Deliver a message that was announced; return whether it was."""
        number = min(
            self._by_content.get(content, ()),
            key=lambda number: abs(self._announcements[number].sent - sent),
            default=None,
        )
        if number is None or abs(self._announcements[number].sent - sent) > WINDOW:
            return False
        self._known(item, self._forget(number).id)
        return True

    def hold(self, content: bytes, sent: int, item: Item) -> None:
        """Let a message wait for its announcement, if one is possible."""
        self._held.append(_Held(content, sent, self._clock(), item))
        self.look()

    def look(self) -> None:
        """Deliver messages that have waited long enough as not announced, in order."""
        while self._held and (
            len(self._held) > HELD_LIMIT or self._clock() >= self._held[0].since + self._patience()
        ):
            self._strange(self._held.popleft().item)
