"""Proposes from a recording which callback leads to which messages and calls, with the evidence."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from dineros.metamodel.errors import counted as in_words
from dineros.observation.importing.assuming import TIMER
from dineros.observation.measuring.samples import Samples
from dineros.observation.narrowing.counting import SECOND, Delays, Following, Publications
from dineros.observation.systems import (
    REQUEST_RECEIVED,
    REQUEST_SENT,
    RESPONSE_RECEIVED,
    RESPONSE_SENT,
    ObservedNode,
    ObservedSystem,
    event_name,
    named,
)

WITHIN = 1.0
"""Seconds after which a message no longer counts as a consequence of another one."""
REGULAR = 0.15
"""Largest standard deviation of the times between messages of a timer, relative to their mean."""
LEAST_MESSAGES = 5
"""Least number of observations of a proposal."""
NEARLY = 0.98
"""Least share of the messages that have to follow it."""
MOSTLY = 0.9
"""Least share of followed triggers for a topic to count as the only cause."""

Kind = Literal["always", "sometimes", "never", "timer"]
Verb = Literal["publish", "call", "send"]
Source = Literal["times", "tracing"]
Verbs = Mapping[tuple[str, str], Verb]
"""Whether nodes wait for responses of services (``call``) or continue (``send``): by node and service."""


@dataclass(frozen=True)
class Proposal:
    """The proposal that a callback leads to messages on a topic, or to calls of a service."""

    node: str
    """Full name of the node."""
    callback: str
    """Topic of the subscription, or name of the service; of a timer, the topic or service to which it leads.
    """
    topic: str
    """The topic or service that it uses."""
    kind: Kind
    """Whether a message follows each that the callback takes, some, or none; or a timer publishes:
    ``always``, ``sometimes``, ``never``, ``timer``.
    """
    triggers: int
    followed: int
    """`triggers`, `followed`: messages that the callback took, and those followed by one on the topic; of a
    timer, times between two messages, and all of them.
    """
    messages: int
    explained: int
    """`messages`, `explained`: messages on the topic, and those that follow what is proposed for it."""
    least: float
    mean: float
    most: float
    """`least`, `mean`, `most`: seconds between a message and its follower, or between two messages of a
    timer.
    """
    confidence: float
    """Between 0 and 1: the expected share of cases in which it will hold."""
    verb: Verb = "publish"
    """Its action: publish, call and wait for the response, or send a request and continue."""
    trigger: str = ""
    """The topic, or the event of a service, that begins the callback; of a timer, nothing."""
    source: Source = "times"
    """The evidence: order of messages in time, or tracing files. Of these, `triggers` and `followed` count
    runs of the callback, times are from its beginning to the first message, and `explained` are the messages
    of this callback alone.
    """
    period: float = 0.0
    """Of the callback of a timer in tracing files: seconds; otherwise 0."""
    repeats: int = 1
    """The most messages of one run."""
    gaps: Samples | None = field(default=None, compare=False, repr=False)
    """Of a timer: the times between messages, in seconds."""

    def to_dict(self) -> dict[str, Any]:
        """Return it for JSON."""
        return {name: value for name, value in vars(self).items() if name != "gaps"}

    def __str__(self) -> str:
        share = f"{self.confidence:.2f}"
        if self.source == "tracing":
            leads = f"{self.callback} {self.kind} leads to {self.topic}"
            return f"{share}  {self.node}: {leads} ({self._traced()})"
        does, effect = _WORDS[self.verb]
        each = "messages" if self.verb == "publish" else "requests"
        effect = f"{effect}{self.topic}"
        if self.kind == "timer":
            return (
                f"{share}  {self.node}: a timer of {self.mean:.3g} s {does} {self.topic} "
                f"({self.messages:,} {each}, {_seconds(self.least)} to {_seconds(self.most)} apart)"
            )
        callback = self.trigger or self.callback
        if self.kind == "never":
            return (
                f"{share}  {self.node}: {callback} never leads to {effect} "
                f"({self.explained:,} of {self.messages:,} {each} have another cause)"
            )
        return (
            f"{share}  {self.node}: {callback} {self.kind} leads to {effect} "
            f"({self.followed:,} of {self.triggers:,} followed, within {_seconds(self.least)} to "
            f"{_seconds(self.most)}; {self.explained:,} of {self.messages:,} {each} explained)"
        )

    def _traced(self) -> str:
        if self.kind == "never":
            return f"in none of {in_words(self.triggers, 'run')}; traced"
        runs = f"in {self.followed:,} of {in_words(self.triggers, 'run')}"
        each = f", up to {self.repeats:,} each" if self.repeats > 1 else ""
        times = f"{_seconds(self.least)} to {_seconds(self.most)}"
        return f"{runs}{each}, after {times}; {self.explained:,} of {self.messages:,} messages; traced"


_WORDS = {"publish": ("publishes", ""), "call": ("calls", "a call of "), "send": ("asks", "a request of ")}


def proposals(
    system: ObservedSystem,
    messages: Iterable[tuple[str, int]],
    *,
    verbs: Verbs | None = None,
    within: float = WITHIN,
) -> list[Proposal]:
    """Return the proposals of a recording for the callbacks of nodes, by names of nodes and topics.

    There are no proposals for topics with several publishers and services with several clients, because a
    recording does not show the sender.

    Parameters
    ----------
    system : ObservedSystem
        Nodes with their ports.
    messages : iterable of (str, int)
        Topic, or name of an event (`dineros.observation.systems.event_name`), and time in nanoseconds of each
        message, in order of their times.
    verbs : mapping, optional
        Whether nodes wait for answers, where it is not ``call``.
    within : float
        Seconds after which a message no longer counts as a consequence of another one.
    """
    asked = verbs or {}
    counted: dict[tuple[str, Verb, str], Publications] = {}
    happened: defaultdict[str, list[Publications]] = defaultdict(list)
    hearing: defaultdict[str, list[Publications]] = defaultdict(list)
    ending: defaultdict[str, list[tuple[Publications, str]]] = defaultdict(list)
    owners = _owners(system)
    for node in sorted(system.nodes, key=lambda node: node.name):
        topics = sorted({endpoint.topic for endpoint in node.subscribers})
        served = {each.name: event_name(each.name, REQUEST_RECEIVED) for each in node.servers}
        answers = [
            event_name(each.name, RESPONSE_RECEIVED)
            for each in node.clients
            if asked.get((node.name, each.name)) == "send"
        ]
        triggers = (*topics, *sorted(served.values()), *sorted(answers))
        for verb, name, shown in _effects(node, asked):
            if owners[shown] != {node.name}:
                continue
            found = counted[node.name, verb, name] = Publications(triggers, round(within * SECOND))
            happened[shown].append(found)
            for each in triggers:
                hearing[each].append(found)
            for service, begins in served.items():
                ending[event_name(service, RESPONSE_SENT)].append((found, begins))
    for name, time in messages:
        for found in happened.get(name, ()):
            found.published(time)
        for found in hearing.get(name, ()):
            found.heard(name, time)
        for found, begins in ending.get(name, ()):
            found.ended(begins)
    return [
        proposal
        for (node, verb, name), found in counted.items()
        if found.count >= LEAST_MESSAGES
        for proposal in _proposed(node, verb, name, found)
    ]


def _effects(node: ObservedNode, asked: Verbs) -> Iterator[tuple[Verb, str, str]]:
    """Yield the visible actions of a node: verb, topic or service, and event."""
    for topic in sorted({endpoint.topic for endpoint in node.publishers}):
        yield "publish", topic, topic
    for service in sorted({endpoint.name for endpoint in node.clients}):
        yield asked.get((node.name, service), "call"), service, event_name(service, REQUEST_SENT)


def _owners(system: ObservedSystem) -> defaultdict[str, set[str]]:
    """Return the nodes of the visible actions."""
    found: defaultdict[str, set[str]] = defaultdict(set)
    for node in system.nodes:
        for _, _, shown in _effects(node, {}):
            found[shown].add(node.name)
    return found


def _proposed(node: str, verb: Verb, topic: str, found: Publications) -> Iterator[Proposal]:
    cause = _only_cause(found)
    if cause is not None:
        causes, explained = {cause: found.alone[cause]}, found.alone[cause].followed
    elif found.gaps.variation <= REGULAR:
        yield _timer(node, verb, topic, found.gaps, found.count)
        causes, explained = {}, found.count
    else:
        causes = {each: following for each, following in found.together.items() if following.followed}
        explained = found.attributed
    share = expected(explained, found.count)
    for trigger, following in found.alone.items():
        its = causes.get(trigger)
        if its is None and not following.triggers:
            continue
        kind: Kind = "never"
        confidence = share
        if its is not None:
            kind, confidence = _kind(its, share)
        shown = following if its is None else its
        yield Proposal(
            node,
            named(trigger),
            topic,
            kind,
            *(shown.triggers, 0 if its is None else its.followed, found.count, explained),
            *(seconds_of(Delays() if its is None else its.delays)),
            confidence,
            verb,
            trigger,
        )


def _only_cause(found: Publications) -> str | None:
    """Return the topic whose messages are all, or nearly all, followed by one of the counted messages."""
    able = [
        (following.delays.mean, topic)
        for topic, following in found.alone.items()
        if following.followed >= NEARLY * found.count and following.followed >= MOSTLY * following.triggers
    ]
    return min(able)[1] if able else None


def _timer(node: str, verb: Verb, topic: str, gaps: Delays, messages: int) -> Proposal:
    confidence = (1 - gaps.variation) * expected(gaps.count, gaps.count)
    count = (gaps.count, gaps.count, messages, messages)
    return Proposal(
        node, topic, topic, "timer", *count, *seconds_of(gaps), confidence, verb, gaps=gaps.samples
    )


def timer_name(topic: str) -> str:
    """Return the name of the timer that publishes on a topic, or calls a service."""
    return f"{TIMER}_{topic.strip('/').replace('/', '_')}"


def _kind(following: Following, share: float) -> tuple[Kind, float]:
    """Return whether all triggers are followed, or some; with the confidence."""
    # Triggers that wait at the end of the recording may still be followed.
    if following.triggers - following.followed - following.waits:
        return "sometimes", share * following.promptness
    return "always", share * expected(following.followed, following.followed)


def seconds_of(delays: Delays) -> tuple[float, float, float]:
    """Return the least, the mean and the greatest of some times, in seconds."""
    return delays.least / SECOND, delays.mean / SECOND, delays.most / SECOND


def expected(times: int, of: int) -> float:
    """Return the expected share of successes (Laplace's rule of succession)."""
    return (times + 1) / (of + 2)


def _seconds(time: float) -> str:
    return f"{time * 1000:.3g} ms" if time < 1 else f"{time:.3g} s"
