"""The ids of messages: what is one, and when a message has come before.

A node calls a message ``NODE/PLACE/NUMBER`` or ``NODE@RUN/PLACE/NUMBER``; the part before the number is
the *sender*, whose messages are numbered from 1. A message that is sent again (by a node that continues after
a crash, by a client without a response) keeps its id; a node that received it before ignores it.

Any program on the network can write any id, so two rules apply to each id that is received:

* What is not an id is refused (`parse_id` says why): its message is counted and dropped.
* A number has come before if *it* came, or if the transport reported it as lost (`Numbers`). That a greater
  one came proves nothing: a forged id costs its sender the one message of that number and no other. Memory
  stays small, since neighbouring numbers are one range, and the lowest ranges are forgotten beyond a limit.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable
from functools import lru_cache

from dineros.metamodel.errors import DinerosError

LENGTH_LIMIT = 1024
"""Characters of an id, at most."""

NUMBER_LIMIT = 2**63 - 1
"""The greatest number: a node that sends a million messages a second gets there in 292 000 years."""

RANGE_LIMIT = 64
"""Ranges that are kept of a sender's numbers."""


class MessageIdError(DinerosError):
    """A text is not an id of a message."""


@lru_cache(maxsize=8)  # an id is looked at several times on its way
def parse_id(message_id: str) -> tuple[str, int] | None:
    """Return sender and number of a message id.

    Returns
    -------
    tuple of str and int, or None
        None if the message has no number, as those of programs without DiNeROS: it is unknown whether it
        came before.

    Raises
    ------
    MessageIdError
        It is longer than `LENGTH_LIMIT`, has control characters, or a number outside of 1 to `NUMBER_LIMIT`.

    Examples
    --------
    >>> parse_id("arm@5f0c/Picked/12")
    ('arm@5f0c/Picked', 12)
    >>> parse_id("") is None
    True
    """
    if len(message_id) > LENGTH_LIMIT:
        raise MessageIdError(f"an id of {len(message_id)} characters")
    if message_id and not message_id.isprintable():
        raise MessageIdError("an id with control characters")
    sender, _, text = message_id.rpartition("/")
    if not text or not text.lstrip("+-").isdecimal():
        return None
    number = int(text) if text.isascii() and text.isdecimal() and len(text) <= 19 else 0
    if not 1 <= number <= NUMBER_LIMIT or text[0] == "0":
        shown = text if len(text) <= 24 else f"{text[:20]}... of {len(text)} digits"
        raise MessageIdError(f"an id with the number {shown}")
    return sender, number


class Numbers:
    """The numbers of one sender's messages that have come, or are known to be lost.

    Parameters
    ----------
    ranges : iterable of (int, int)
        First and last number of each range.
    limit : int, optional
        Ranges to keep, the highest; None: all.
    """

    __slots__ = ("_firsts", "_lasts", "_limit")

    def __init__(self, ranges: Iterable[tuple[int, int]] = (), *, limit: int | None = RANGE_LIMIT) -> None:
        self._firsts: list[int] = []
        self._lasts: list[int] = []
        self._limit = limit
        for first, last in ranges:
            self.add(last, last - first)

    def __contains__(self, number: int) -> bool:
        at = bisect_right(self._firsts, number) - 1
        return at >= 0 and number <= self._lasts[at]

    def add(self, number: int, lost: int = 0) -> None:
        """Note a number, and that the `lost` numbers just below it will never come."""
        firsts, lasts = self._firsts, self._lasts
        if lasts and not lost and lasts[-1] + 1 == number:  # nearly always
            lasts[-1] = number
            return
        first = max(1, number - lost)
        # All ranges that touch [first, number] become one with it.
        low = bisect_right(lasts, first - 2)
        high = bisect_right(firsts, number + 1)
        if low < high:
            first, number = min(first, firsts[low]), max(number, lasts[high - 1])
        firsts[low:high], lasts[low:high] = [first], [number]
        if self._limit is not None and len(firsts) > self._limit:
            del firsts[0], lasts[0]

    @property
    def highest(self) -> int:
        """The highest number; 0: there is none."""
        return self._lasts[-1] if self._lasts else 0

    def highest_up_to(self, last: int) -> int:
        """Return the highest end of a range that is not above a number; 0: there is none."""
        at = bisect_right(self._lasts, last) - 1
        return self._lasts[at] if at >= 0 else 0

    def count(self, first: int, last: int) -> int:
        """Return how many numbers from `first` to `last` are noted.

        Examples
        --------
        >>> Numbers([(1, 3), (6, 6)]).count(2, 9)
        3
        """
        return sum(max(0, min(last, end) - max(first, begin) + 1) for begin, end in self.ranges())

    def ranges(self) -> list[tuple[int, int]]:
        """Return first and last number of each range, in order."""
        return list(zip(self._firsts, self._lasts, strict=True))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Numbers) and self.ranges() == other.ranges()

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"Numbers({self.ranges()})"


class Senders:
    """The numbers that a port had of each sender; of many senders, the most recent ones.

    Parameters
    ----------
    seen : mapping, optional
        Sender -> last number of the range that begins at 1, as in a checkpoint.
    apart : mapping, optional
        Sender -> first and last number of each further range, as in a checkpoint.
    limit : int
        How many senders are kept.
    """

    def __init__(
        self,
        seen: dict[str, int] | None = None,
        apart: dict[str, list[list[int]]] | None = None,
        *,
        limit: int = 256,
    ) -> None:
        self._numbers: dict[str, Numbers] = {}
        self._limit = limit
        for sender, last in (seen or {}).items():
            self.add(sender, last, last)
        for sender, ranges in (apart or {}).items():
            for first, last in ranges:
                self.add(sender, last, last - first)

    def had(self, sender: str, number: int) -> bool:
        """Return whether this number came before, or was lost."""
        return sender in self._numbers and number in self._numbers[sender]

    def skipped(self, sender: str, number: int) -> int:
        """Return how many numbers lie between one and all known ones of its sender; none of a new sender."""
        known = self._numbers.get(sender)
        return max(0, number - known.highest - 1) if known is not None else 0

    def lacks(self, sender: str, number: int, count: int) -> int:
        """Return how many of the `count` numbers just below one neither came nor were lost."""
        first = max(1, number - count)
        known = self._numbers.get(sender)
        return number - first - (known.count(first, number - 1) if known is not None else 0)

    def add(self, sender: str, number: int, lost: int = 0) -> None:
        """Note a number, and that the `lost` numbers just below it will never come."""
        numbers = self._numbers.pop(sender, None) or Numbers()
        numbers.add(number, lost)
        self._numbers[sender] = numbers  # the most recent one
        if len(self._numbers) > self._limit:
            del self._numbers[next(iter(self._numbers))]

    def saved(self) -> tuple[dict[str, int], dict[str, list[list[int]]]]:
        """Return what the constructor takes: nearly all is one range from 1 on."""
        seen: dict[str, int] = {}
        apart: dict[str, list[list[int]]] = {}
        for sender, numbers in self._numbers.items():
            for first, last in numbers.ranges():
                if first == 1:
                    seen[sender] = last
                else:
                    apart.setdefault(sender, []).append([first, last])
        return seen, apart
