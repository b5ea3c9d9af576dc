"""Counts which messages of a node follow which others in a recording, how often and how soon.

For each pair of topics only a few numbers are stored, independent of the length of the recording.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from dineros.observation.measuring.samples import Samples

SECOND = 1_000_000_000
_MOST_GAPS = 1 << 14
"""Limit of the stored times between messages of a topic."""


@dataclass
class Delays:
    """Times between two messages, in nanoseconds; `samples`, if given, stores them in seconds."""

    count: int = 0
    least: int = 0
    most: int = 0
    mean: float = 0.0
    samples: Samples | None = None
    _squares: float = 0.0

    def add(self, delay: int) -> None:
        """Count one more."""
        self.least = min(self.least, delay) if self.count else delay
        self.most = max(self.most, delay)
        self.count += 1
        # Welford, Technometrics 4(3), 1962: no differences of large sums.
        off = delay - self.mean
        self.mean += off / self.count
        self._squares += off * (delay - self.mean)
        if self.samples is not None:
            self.samples.add(delay / SECOND)

    @property
    def variation(self) -> float:
        """Standard deviation relative to the mean; infinite if undefined."""
        if self.count < 2 or self.mean <= 0:
            return math.inf
        return math.sqrt(self._squares / (self.count - 1)) / self.mean


@dataclass
class Following:
    """Counts how messages of one topic follow those of another.

    A message is matched to the latest one before it, if that one is not matched yet.
    """

    triggers: int = 0
    """Messages that may be followed."""
    followed: int = 0
    """Those that are."""
    delays: Delays = field(default_factory=Delays)
    """How soon."""
    _last: int | None = None
    _first: int = 0
    _latest: int = 0

    def trigger(self, time: int) -> None:
        """Add a message that may be followed."""
        if not self.triggers:
            self._first = time
        self.triggers += 1
        self._last = self._latest = time

    @property
    def promptness(self) -> float:
        """How much sooner it is followed than by chance (half the mean gap): from 0 to 1."""
        if self.triggers < 2 or self._latest <= self._first:
            return 1.0
        by_chance = (self._latest - self._first) / (self.triggers - 1) / 2
        return max(0.0, 1 - self.delays.mean / by_chance)

    def open_since(self, time: int, within: int) -> int | None:
        """Return the waiting time of the latest trigger; None: none waits, or for too long."""
        if self._last is None or time - self._last > within:
            return None
        return max(0, time - self._last)

    def end(self) -> None:
        """Discard the latest trigger as not followed."""
        self._last = None

    def follow(self, delay: int) -> None:
        """Mark the latest trigger as followed."""
        self.followed += 1
        self.delays.add(delay)
        self._last = None

    @property
    def waits(self) -> bool:
        """Whether the latest trigger is not followed yet."""
        return self._last is not None


class Publications:
    """Counts of the messages that one node publishes on one topic, or of its calls of one service.

    Parameters
    ----------
    triggers : tuple of str
        Topics to which the node subscribes; of its services, names of events.
    within : int
        Nanoseconds after which a message no longer counts as a follower.

    Attributes
    ----------
    count : int
        Messages.
    attributed : int
        Messages that follow something in `together`.
    """

    def __init__(self, triggers: tuple[str, ...], within: int) -> None:
        self._within = within
        self._last: int | None = None
        self.count = self.attributed = 0
        self.gaps = Delays(samples=Samples(most=_MOST_GAPS))
        """Times between them."""
        self.alone = {topic: Following() for topic in triggers}
        """By trigger: how they follow it if they follow nothing else."""
        self.together = {topic: Following() for topic in triggers}
        """By trigger: how they follow it if each message follows what came last before it."""
        self._begun = dict.fromkeys(triggers, 0)

    def heard(self, trigger: str, time: int) -> None:
        """Add a message that the node receives, or an event that starts a callback."""
        self._begun[trigger] += 1
        self.alone[trigger].trigger(time)
        self.together[trigger].trigger(time)

    def ended(self, trigger: str) -> None:
        """Add the end of a callback: if no other one of its kind runs, no follower is possible any more."""
        self._begun[trigger] -= 1
        if self._begun[trigger] <= 0:
            self._begun[trigger] = 0
            self.alone[trigger].end()
            self.together[trigger].end()

    def published(self, time: int) -> None:
        """Add a message that the node publishes."""
        self.count += 1
        if self._last is not None:
            self.gaps.add(time - self._last)
        self._last = time
        for following in self.alone.values():
            delay = following.open_since(time, self._within)
            if delay is not None:
                following.follow(delay)
        open_ones = [
            (delay, topic)
            for topic, following in self.together.items()
            if (delay := following.open_since(time, self._within)) is not None
        ]
        if open_ones:
            delay, topic = min(open_ones)
            self.together[topic].follow(delay)
            self.attributed += 1
