"""What became of published messages, as far as the traces of their subscribers say it."""

from __future__ import annotations

from collections import Counter
from functools import lru_cache

from dineros.metamodel.message_ids import MessageIdError, Numbers, parse_id
from dineros.metamodel.records import Drop, Publish, Take


class Fates:
    """Which messages were taken; of those between them, it is known that they were lost.

    What is kept grows with the messages that were lost, not with a run.

    Attributes
    ----------
    are_known : bool
        Whether all takes are there: what was not taken by now is not taken any more.
    told : Counter
        Of each channel and subscriber's place, how many losses its trace tells.
    """

    def __init__(self) -> None:
        self._taken: dict[tuple[str, str, str], Numbers] = {}
        self._nameless: set[tuple[str, str]] = set()  # where what is taken does not say which message it is
        self.told: Counter[tuple[str, str]] = Counter()
        self._published: Counter[str] = Counter()
        self._takes: Counter[tuple[str, str]] = Counter()
        self.are_known = False

    def add(self, record: Publish | Take | Drop) -> None:
        """Note what a trace tells of a message."""
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
        """Tell whether a subscriber's place never gets a message; None: that is not known yet."""
        known = sender_and_number(message)
        if known is None:
            return False
        sender, number = known
        taken = self._taken.get((channel, place, sender))
        if taken is None or taken.highest < number:
            return False if self.are_known else None
        return number not in taken

    def are_nameless(self, channel: str, place: str) -> bool:
        """Tell whether a subscriber's place takes messages without ids, as those of installed interfaces."""
        return (channel, place) in self._nameless

    def may_lose_what_it_tells(self, channel: str, place: str) -> bool:
        """Tell whether a subscriber's place tells losses, and as much is sent as it takes and loses."""
        at = channel, place
        enough = self._takes[at] + self.told[at] <= self._published[channel]
        return not self.are_known or (self.told[at] > 0 and enough)

    def is_left(self, channel: str, place: str, message: str) -> bool:
        """Tell whether a message comes after all that a subscriber's place ever takes of its sender."""
        known = sender_and_number(message)
        if known is None or not self.are_known or self.are_nameless(channel, place):
            return False
        taken = self._taken.get((channel, place, known[0]))
        return taken is None or taken.highest < known[1]


@lru_cache(maxsize=4096)  # those under way are looked at again and again
def sender_and_number(message: str) -> tuple[str, int] | None:
    """Return sender and number of a message id; None where it is none, or has no number."""
    try:
        return parse_id(message)
    except MessageIdError:
        return None
