"""Which callback leads to which messages, as far as a recording shows it, and what speaks for that."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal

from dineros.observation.narrowing.counting import SECOND, Delays, Following, Publications
from dineros.observation.systems import ObservedSystem

WITHIN = 1.0
"""Seconds after which a message is no consequence of another one any more."""
REGULAR = 0.15
"""Largest standard deviation of the times between messages of a timer, as a part of their mean."""
LEAST_MESSAGES = 5
"""With fewer, nothing is proposed."""
MOSTLY = 0.9
"""Part of the triggers of which a topic has to be followed to be taken for the one and only cause."""

Kind = Literal["always", "sometimes", "never", "timer"]


@dataclass(frozen=True)
class Proposal:
    """That a callback leads to messages on a topic.

    Attributes
    ----------
    node : str
        Full name of the node.
    callback : str
        Topic of the subscription; of a timer, the topic that it publishes on.
    topic : str
        What is published.
    kind : {"always", "sometimes", "never", "timer"}
        Whether a message follows each that the callback takes, some, or none; or a timer publishes.
    triggers, followed : int
        Messages that the callback took, and those that one on the topic followed; of a timer, times between
        two messages, and all of them.
    messages, explained : int
        Messages on the topic, and those that follow what is proposed for it.
    least, mean, most : float
        Seconds between a message and what follows it, or between two of a timer.
    confidence : float
        Between 0 and 1: the expected share, after what was seen, of times at which it will hold.
    """

    node: str
    callback: str
    topic: str
    kind: Kind
    triggers: int
    followed: int
    messages: int
    explained: int
    least: float
    mean: float
    most: float
    confidence: float

    def __str__(self) -> str:
        share = f"{self.confidence:.2f}"
        if self.kind == "timer":
            return (
                f"{share}  {self.node}: a timer of {self.mean:.3g} s publishes {self.topic} "
                f"({self.messages:,} messages, {_seconds(self.least)} to {_seconds(self.most)} apart)"
            )
        if self.kind == "never":
            return (
                f"{share}  {self.node}: {self.callback} never leads to {self.topic} "
                f"({self.explained:,} of {self.messages:,} messages have another cause)"
            )
        return (
            f"{share}  {self.node}: {self.callback} {self.kind} leads to {self.topic} "
            f"({self.followed:,} of {self.triggers:,} followed, within {_seconds(self.least)} to "
            f"{_seconds(self.most)}; {self.explained:,} of {self.messages:,} messages explained)"
        )


def proposals(
    system: ObservedSystem, messages: Iterable[tuple[str, int]], *, within: float = WITHIN
) -> list[Proposal]:
    """Return what a recording shows of the callbacks of nodes, nodes and topics in order of their names.

    Of a topic that several nodes publish on, nothing is proposed: whose message it is, no recording says.

    Parameters
    ----------
    system : ObservedSystem
        Nodes with their publishers and subscriptions.
    messages : iterable of (str, int)
        Topic and time in nanoseconds of each message, in order of their times.
    within : float
        Seconds after which a message is no consequence of another one any more.
    """
    publishing: defaultdict[str, list[str]] = defaultdict(list)
    for node, endpoint in system.publishers():
        if node.name not in publishing[endpoint.topic]:
            publishing[endpoint.topic].append(node.name)
    counted: dict[tuple[str, str], Publications] = {}
    hearing: defaultdict[str, list[Publications]] = defaultdict(list)
    for node in sorted(system.nodes, key=lambda node: node.name):
        heard = tuple(sorted({endpoint.topic for endpoint in node.subscribers}))
        for topic in sorted({endpoint.topic for endpoint in node.publishers}):
            if len(publishing[topic]) == 1:
                found = counted[node.name, topic] = Publications(heard, round(within * SECOND))
                for each in heard:
                    hearing[each].append(found)
    published: defaultdict[str, list[Publications]] = defaultdict(list)
    for (_, topic), found in counted.items():
        published[topic].append(found)
    for topic, time in messages:
        for found in published.get(topic, ()):
            found.published(time)
        for found in hearing.get(topic, ()):
            found.heard(topic, time)
    return [
        proposal
        for (node, topic), found in counted.items()
        if found.count >= LEAST_MESSAGES
        for proposal in _proposed(node, topic, found)
    ]


def _proposed(node: str, topic: str, found: Publications) -> Iterator[Proposal]:
    cause = _only_cause(found)
    if cause is not None:
        causes, explained = {cause: found.alone[cause]}, found.alone[cause].followed
    elif found.gaps.variation <= REGULAR:
        yield _timer(node, topic, found)
        causes, explained = {}, found.count
    else:
        causes = {each: following for each, following in found.together.items() if following.followed}
        explained = found.attributed
    share = _expected(explained, found.count)
    for callback, following in found.alone.items():
        if callback in causes:
            yield _cause(node, callback, topic, causes[callback], found.count, explained, share)
        elif following.triggers:
            yield Proposal(
                node, callback, topic, "never", following.triggers, 0, found.count, explained, 0, 0, 0, share
            )


def _only_cause(found: Publications) -> str | None:
    """Return the topic of which each message is followed, or nearly each, by one of all that there are."""
    able = [
        (following.delays.mean, topic)
        for topic, following in found.alone.items()
        if following.followed == found.count and following.followed >= MOSTLY * following.triggers
    ]
    return min(able)[1] if able else None


def _timer(node: str, topic: str, found: Publications) -> Proposal:
    gaps = found.gaps
    confidence = (1 - gaps.variation) * _expected(gaps.count, gaps.count)
    count = (gaps.count, gaps.count, found.count, found.count)
    return Proposal(node, topic, topic, "timer", *count, *_times(gaps), confidence)


def _cause(
    node: str, callback: str, topic: str, following: Following, messages: int, explained: int, share: float
) -> Proposal:
    # What waits when the recording ends may still be followed.
    missed = following.triggers - following.followed - following.waits
    kind: Kind = "sometimes" if missed else "always"
    if kind == "always":
        share *= _expected(following.followed, following.followed)
    count = (following.triggers, following.followed, messages, explained)
    return Proposal(node, callback, topic, kind, *count, *_times(following.delays), share)


def _times(delays: Delays) -> tuple[float, float, float]:
    return delays.least / SECOND, delays.mean / SECOND, delays.most / SECOND


def _expected(times: int, of: int) -> float:
    """Return the expected share, after it was so some times (Laplace's rule of succession)."""
    return (times + 1) / (of + 2)


def _seconds(time: float) -> str:
    return f"{time * 1000:.3g} ms" if time < 1 else f"{time:.3g} s"
