"""Which messages of an existing ROS type were announced with an id, and which a stranger sent.

Whoever announces a message says which of its messages it is, as the middleware counts, and sends it right
afterwards. Both tell when they were sent, by the clock of their sender: messages of equal content and number
that are far apart are different ones, and those close together, of two senders, can stand for each other.
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
"""Nanoseconds between an announcement and its message, at most: a sender that was suspended in between."""

ANNOUNCEMENT_LIMIT = 1024
"""Announcements whose messages have not come that are kept, at least."""

HELD_LIMIT = 1024
"""Messages that wait for their announcement; strangers' are what comes beyond."""

Item = TypeVar("Item")


def content_of(data: Data, number: int) -> bytes:
    """Return what is equal for messages of equal content that have the same number, each of its sender."""
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
    """Tells the messages that come which of them were announced, and which were not.

    The announcement of a message comes another way: mostly before it, at times after it. So a message that is
    not known waits for a while; those of strangers keep their order.

    Parameters
    ----------
    known : callable
        Called with a message, or what stands for it, and its id.
    strange : callable
        Called with a message that nobody has announced.
    patience : callable
        Tells how many seconds a message may wait for its announcement.
    limit : int
        Announcements to keep, at least.
    clock : callable
        Tells the time in seconds.
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
        """Whether nothing waits: no message, and no announcement."""
        return not self._held and not self._announcements

    def announced(self, content: bytes, sent: int, id: str) -> None:
        """Note an announcement, whose message may have come before it."""
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
        """Hand on a message that was announced; return whether it was."""
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
        """Let a message wait for its announcement, if there can be one."""
        self._held.append(_Held(content, sent, self._clock(), item))
        self.look()

    def look(self) -> None:
        """Hand on those messages as strangers' that have waited long enough, in their order."""
        while self._held and (
            len(self._held) > HELD_LIMIT or self._clock() >= self._held[0].since + self._patience()
        ):
            self._strange(self._held.popleft().item)
