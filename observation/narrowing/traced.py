"""Reads from tracing files the messages that callbacks published while they ran."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from dineros.observation.measuring.proposing import LEAST_TIMES, TimeProposal, ticks_proposed
from dineros.observation.measuring.samples import Samples
from dineros.observation.narrowing.counting import SECOND, Delays
from dineros.observation.narrowing.proposals import LEAST_MESSAGES, Kind, Proposal, expected, seconds_of
from dineros.observation.systems import ObservedNode, ObservedSystem, RecordedTopic
from dineros.observation.tracing import Callback, Publication, Run, Tracing, Uncertain, runs

_MILLISECOND = 1_000_000
_LONGEST_PERIOD = 1e8
"""Seconds."""
_MOST_OTHERS = 10


@dataclass
class Lead:
    """The messages that runs of a callback published on a topic of its node."""

    followed: int = 0
    """Runs that published on it."""
    open: int = 0
    """Those of them that had not ended at the end of the trace."""
    messages: int = 0
    most: int = 0
    """`messages`, `most`: messages, and the most of them in one run."""
    delays: Delays = field(default_factory=Delays)
    """From the beginning of a run to the first message."""


@dataclass
class Traced:
    """Counts of tracing files for a system; their size does not depend on the length of the files."""

    system: ObservedSystem
    nodes: set[str] = field(default_factory=set)
    """Nodes of the system that published, or ran a callback."""
    others: set[str] = field(default_factory=set)
    """Some nodes that the system does not have."""
    messages: Counter[tuple[str, str]] = field(default_factory=Counter)
    """By node and topic."""
    runs: Counter[Callback] = field(default_factory=Counter)
    """Of the callbacks that the system has."""
    leads: defaultdict[tuple[Callback, str], Lead] = field(default_factory=lambda: defaultdict(Lead))
    """By callback and topic."""
    uncertain: Uncertain = field(default_factory=Uncertain)
    """What the files do not contain."""
    discarded: int = 0
    odd: int = 0
    """`discarded`, `odd`: as in `Tracing`."""
    took: defaultdict[Callback, Samples] = field(default_factory=lambda: defaultdict(Samples))
    """Seconds that runs of a callback took."""
    gaps: defaultdict[Callback, Samples] = field(default_factory=lambda: defaultdict(Samples))
    """Of a timer: seconds between two beginnings of its callback that did not wait for its thread."""
    _last: dict[Callback, Run] = field(default_factory=dict)

    def note(self, run: Run) -> None:
        """Count the times of a run."""
        if run.took is not None:
            self.took[run.callback].add(run.took / SECOND)
        if run.callback.kind == "timer":
            last = self._last.get(run.callback)
            self._last[run.callback] = run
            if last is not None and not run.waited and not last.waited:
                self.gaps[run.callback].add((run.began - last.began) / SECOND)

    def times(self, source: str) -> list[TimeProposal]:
        """Return the times that are proposed: durations of callbacks, periods and jitter of timers."""
        found = []
        for callback, name in sorted(_names(self.runs).items()):
            words, element = f"{callback.node}: {name}", f"{callback.node} {name}"
            took = self.took[callback]
            if len(took) >= LEAST_TIMES:
                found.append(TimeProposal("duration", element, words, took.summary(), source))
            if callback.kind == "timer":
                declared = callback.period / SECOND
                ticks = ticks_proposed(element, words, self.gaps[callback], source, declared)
                found += [ticks] if ticks is not None else []
        return found

    def attributed(self, node: str, topic: str) -> int:
        """Return how many messages of a node on a topic were published by callbacks of it."""
        return sum(lead.messages for (its, on), lead in self.leads.items() if (its.node, on) == (node, topic))

    @property
    def outside(self) -> int:
        """Messages that no callback of their node published while it ran."""
        return sum(self.messages.values()) - sum(lead.messages for lead in self.leads.values())

    def recorded(self) -> list[RecordedTopic]:
        """Return the topics whose messages are all in the files: all publishers are traced."""
        types: dict[str, str] = {}
        owners: defaultdict[str, set[str]] = defaultdict(set)
        for node, endpoint in self.system.publishers():
            types[endpoint.topic] = endpoint.type
            owners[endpoint.topic].add(node.name)
        counts: Counter[str] = Counter()
        for (_, topic), count in self.messages.items():
            counts[topic] += count
        return [
            RecordedTopic(topic, types[topic], (), counts[topic])
            for topic in sorted(types)
            if owners[topic] <= self.nodes
        ]


def traced(system: ObservedSystem, tracing: Tracing) -> Traced:
    """Count the data of tracing files about the callbacks of a system.

    Raises
    ------
    TracingError
        They cannot be read.
    """
    found = Traced(system)
    publishing = {(node.name, endpoint.topic) for node, endpoint in system.publishers()}
    begun = {node.name: _begun_by(node) for node in system.nodes}
    for each in runs(tracing, found.uncertain):
        node = each.node if isinstance(each, Publication) else each.callback.node
        if node in begun:
            found.nodes.add(node)
        elif len(found.others) < _MOST_OTHERS:
            found.others.add(node)
        if isinstance(each, Publication):
            if (each.node, each.topic) in publishing:
                found.messages[each.node, each.topic] += 1
        elif node in begun and (each.callback.kind == "timer" or each.callback[1:3] in begun[node]):
            _count(found, each, publishing)
    found.discarded, found.odd = tracing.discarded, tracing.odd
    return found


def _begun_by(node: ObservedNode) -> set[tuple[str, str]]:
    return {
        *(("subscription", endpoint.topic) for endpoint in node.subscribers),
        *(("service", endpoint.name) for endpoint in node.servers),
    }


def _count(found: Traced, run: Run, publishing: set[tuple[str, str]]) -> None:
    found.note(run)
    found.runs[run.callback] += run.ended
    for (node, topic), sent in run.published.items():
        if node == run.callback.node and (node, topic) in publishing:
            lead = found.leads[run.callback, topic]
            lead.followed += 1
            lead.open += not run.ended
            lead.messages += sent.count
            lead.most = max(lead.most, sent.count)
            lead.delays.add(sent.first)


def publications(system: ObservedSystem, tracing: Tracing) -> Iterator[tuple[str, int]]:
    """Yield topic and time of each message in tracing files on topics of a system."""
    topics = {endpoint.topic for _, endpoint in system.publishers()}
    for each in runs(tracing):
        if isinstance(each, Publication) and each.topic in topics:
            yield each.topic, each.time


def with_traced(found: Iterable[Proposal], counts: Traced) -> list[Proposal]:
    """Return proposals from the times of messages, replaced by those from tracing files if available.

    For a callback that ran, its publications are known. Proposals by times remain for other triggers
    (responses, which traces do not contain), as long as not all messages of the topic come from callbacks
    that ran;
    and timers, if none do. Nodes and topics are in order of their names.
    """
    ran = {(callback.node, name) for callback, name in _names(counts.runs).items()}
    told = _proposed(counts)
    known = {(each.node, each.topic) for each in told}

    def stays(proposal: Proposal) -> bool:
        its = proposal.node, proposal.topic
        if proposal.verb != "publish" or its not in known:
            return True
        if (proposal.node, proposal.callback) in ran:
            return False
        attributed = counts.attributed(*its)
        return attributed == 0 if proposal.kind == "timer" else attributed < counts.messages[its]

    both = [*told, *(proposal for proposal in found if stays(proposal))]
    return sorted(both, key=lambda each: (each.node, each.verb != "publish", each.topic))


def _proposed(counts: Traced) -> list[Proposal]:
    names = _names(counts.runs)
    return [
        _proposal(counts, callback, names[callback], topic, count)
        for (node, topic), count in sorted(counts.messages.items())
        if count >= LEAST_MESSAGES
        for callback in sorted(names)
        if callback.node == node and counts.runs[callback] + _lead(counts, callback, topic).open
    ]


def _proposal(counts: Traced, callback: Callback, name: str, topic: str, messages: int) -> Proposal:
    lead = _lead(counts, callback, topic)
    # Callbacks that run at the end of the trace may still publish.
    triggers = counts.runs[callback] + lead.open
    kind: Kind = "sometimes"
    if lead.followed in (0, triggers):
        kind = "always" if lead.followed else "never"
    timer = callback.kind == "timer"
    period = min(max(callback.period / 1e9, 1e-6), _LONGEST_PERIOD) if timer else 0.0
    return Proposal(
        callback.node,
        name,
        topic,
        kind,
        triggers,
        lead.followed,
        messages,
        lead.messages,
        *seconds_of(lead.delays),
        expected(triggers, triggers),
        trigger=name,
        source="tracing",
        period=period,
        repeats=max(1, lead.most),
    )


def _lead(counts: Traced, callback: Callback, topic: str) -> Lead:
    return counts.leads.get((callback, topic)) or Lead()


def _names(callbacks: Iterable[Callback]) -> dict[Callback, str]:
    """Return the names of callbacks in the given facts: timers by their periods."""
    found: dict[Callback, str] = {}
    taken: Counter[tuple[str, str]] = Counter()
    for callback in sorted(callbacks):
        name = callback.name
        if callback.kind == "timer":
            period = f"{callback.period / _MILLISECOND:.15g}".replace(".", "_").replace("-", "minus_")
            name = f"timer_{period}ms"
            taken[callback.node, name] += 1
            if taken[callback.node, name] > 1:
                name = f"{name}_{taken[callback.node, name]}"
        found[callback] = name
    return found
