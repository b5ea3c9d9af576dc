"""The fates of published messages, according to the traces of their subscribers."""

from __future__ import annotations

from collections import Counter
from functools import lru_cache

from dineros.metamodel.message_ids import MessageIdError, Numbers, parse_id
from dineros.metamodel.records import Drop, Publish, Take


class Fates:
    """Records which messages were taken; messages between them are known to be lost.

    The stored data grows with the number of lost messages, not with the length of the run.

    Attributes
    ----------
    are_known : bool
        Whether all takes are recorded: messages that were not taken will not be taken.
    told : Counter
        For each channel and subscriber's place, the number of losses in its trace.
    """

    def __init__(self) -> None:
        self._taken: dict[tuple[str, str, str], Numbers] = {}
        self._nameless: set[tuple[str, str]] = set()  # places whose takes have no message ids
        self.told: Counter[tuple[str, str]] = Counter()
        self._published: Counter[str] = Counter()
        self._takes: Counter[tuple[str, str]] = Counter()
        self.are_known = False

    def add(self, record: Publish | Take | Drop) -> None:
        """Process a record about a message."""
        if isinstance(record, Publish):
            self._published[record.channel] += 1
            return
        at = record.channel, record.place or ""
        if isinstance(record, Drop):
            self.told[at] += record.count
            return
        self._takes[at] += 1
        known = sender_and_number(record.message or "")
        if known is None:
            self._nameless.add((record.channel, record.place))
        else:
            key = record.channel, record.place, known[0]
            self._taken.setdefault(key, Numbers(limit=None)).add(known[1])

    def is_lost(self, channel: str, place: str, message: str) -> bool | None:
        """Return whether a subscriber's place never gets a message; None: this is not known yet."""
        known = sender_and_number(message)
        if known is None:
            return False
        sender, number = known
        taken = self._taken.get((channel, place, sender))
        if taken is None or taken.highest < number:
            return False if self.are_known else None
        return number not in taken

    def are_nameless(self, channel: str, place: str) -> bool:
        """Return whether a subscriber's place takes messages without ids, as with installed interfaces."""
        return (channel, place) in self._nameless

    def may_lose_what_it_tells(self, channel: str, place: str) -> bool:
        """Return whether a place records losses, and takes plus losses do not exceed the sent messages."""
        at = channel, place
        enough = self._takes[at] + self.told[at] <= self._published[channel]
        return not self.are_known or (self.told[at] > 0 and enough)

    def is_left(self, channel: str, place: str, message: str) -> bool:
        """Return whether a message follows all messages of its sender that a place ever takes."""
        known = sender_and_number(message)
        if known is None or not self.are_known or self.are_nameless(channel, place):
            return False
        taken = self._taken.get((channel, place, known[0]))
        return taken is None or taken.highest < known[1]


@lru_cache(maxsize=4096)  # messages under way are looked up repeatedly
def sender_and_number(message: str) -> tuple[str, int] | None:
    """Return sender and number of a message id; None: it is not such an id, or has no number."""
    try:
        return parse_id(message)
    except MessageIdError:
        return None
