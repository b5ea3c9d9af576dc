"""What became of published messages and of goals, as far as the traces of those who got them say it."""

from __future__ import annotations

from collections import Counter

from dineros.metamodel.message_ids import MessageIdError, Numbers, parse_id
from dineros.metamodel.records import Cancel, GoalStep, Outcome, Take


class Fates:
    """Which messages were taken; of those between them, it is known that they were lost.

    What is kept grows with the messages that were lost, not with a run.

    Attributes
    ----------
    are_known : bool
        Whether all takes are there: what was not taken by now is not taken any more.
    """

    def __init__(self) -> None:
        self._taken: dict[tuple[str, str, str], Numbers] = {}
        self._cancels: Counter[tuple[str, str]] = Counter()
        self._ended: set[tuple[str, str]] = set()
        self.are_known = False

    def add_goal(self, record: GoalStep) -> None:
        """Note what a client does about a goal."""
        key = record.channel, record.message or ""
        if isinstance(record, Cancel):
            self._cancels[key] += 1
        elif isinstance(record, Outcome):
            self._ended.add(key)

    def cancels_of(self, channel: str, goal: str) -> int | None:
        """Return how often a client has asked to cancel a goal; None: that is not known yet."""
        is_known = self.are_known or (channel, goal) in self._ended
        return self._cancels[channel, goal] if is_known else None

    def add(self, record: Take) -> None:
        """Note a take."""
        known = _parsed(record.message or "")
        if known is not None:
            key = record.channel, record.place, known[0]
            self._taken.setdefault(key, Numbers(limit=None)).add(known[1])

    def is_lost(self, channel: str, place: str, message: str) -> bool | None:
        """Tell whether a subscriber's place never gets a message; None: that is not known yet."""
        known = _parsed(message)
        if known is None:
            return False
        sender, number = known
        ranges = (
            self._taken[channel, place, sender].ranges() if (channel, place, sender) in self._taken else []
        )
        if not ranges or ranges[-1][1] < number:
            return False if self.are_known else None
        return number not in self._taken[channel, place, sender]


def _parsed(message: str) -> tuple[str, int] | None:
    try:
        return parse_id(message)
    except MessageIdError:
        return None
