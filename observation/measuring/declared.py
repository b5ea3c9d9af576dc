"""Compares measured times with those that a model declares."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.bodies import timers_of
from dineros.metamodel.callbacks.groups import runs_callbacks
from dineros.metamodel.elements import channels, label, node_net_of, pages, transitions
from dineros.metamodel.errors import Location
from dineros.metamodel.records import Record
from dineros.metamodel.times.given import (
    duration_of,
    gives_times,
    latency_between,
    latency_of_calls,
    period_of,
)
from dineros.observation.measuring.samples import duration_text
from dineros.observation.measuring.seen import Part, Seen

ALLOWANCE = 0.005
"""Seconds by which a time may pass its bound: clocks differ, and a machine does other work."""


class Declaration(NamedTuple):
    """The declaration of a time: its bounds in seconds, and the name of its element in messages."""

    least: float
    most: float | None
    words: str


@dataclass
class Breach:
    """A declared time that a run violates."""

    part: Part
    """The element of the time."""
    bound: Literal["least", "most"]
    """Which bound is broken."""
    declared: Declaration
    seconds: float
    at: float
    """`seconds`, `at`: the time that is farthest from it, and when it was over, from the start of the run."""
    record: Record
    """Where it is recorded."""
    count: int = 1
    of: int = 1
    """`count`, `of`: how many times break the bound, of how many that were measured."""

    @property
    def rule(self) -> str:
        """The kind of finding, such as ``duration-too-long``."""
        return f"{self.part.feature}-too-{'long' if self.bound == 'most' else 'short'}"

    @property
    def location(self) -> Location | None:
        """File and line of the record."""
        return self.record.location

    def __str__(self) -> str:
        seen = f"{self.declared.words} {duration_text(self.seconds)} at {round(self.at, 3):,} s"
        share = "" if self.of == 1 else f" ({self.count:,} of {self.of:,})"
        return f"{seen}; declared: {self._declared()}{share}"

    def _declared(self) -> str:
        if self.bound == "most":
            return f"at most {duration_text(self.declared.most or 0.0)}"
        return f"at least {duration_text(self.declared.least)}"

    def to_dict(self) -> dict[str, Any]:
        """Return it for JSON."""
        location = self.location
        return {
            "rule": self.rule,
            "element": self.part.element,
            "message": str(self),
            "seconds": self.seconds,
            "at": self.at,
            "declared": [self.declared.least, self.declared.most],
            "count": self.count,
            "of": self.of,
            "file": None if location is None else str(location.file),
            "line": None if location is None else location.line,
            "node": self.record.node,
            "sequence": self.record.sequence,
        }


def declarations(model: sym.SystemModel) -> dict[Part, Declaration]:
    """Return the durations, periods and latencies that a model declares."""
    return dict(_declared(model))


def _declared(model: sym.SystemModel) -> Iterator[tuple[Part, Declaration]]:
    timers = set(timers_of(model))
    for page in pages(model):
        if isinstance(page, sym.CallbackPage):
            node = node_net_of(page)
            duration = duration_of(page) if node is not None and runs_callbacks(node) else None
            yield from _bounds(Part("duration", str(page.id)), duration, f"callback {label(page)} took")
            period, jitter = period_of(page), float(page.jitter or 0)
            if page in timers and period is not None:
                words = f"ticks of callback {label(page)} came after"
                least = max(0.0, period - jitter)
                yield Part("period", str(page.id)), Declaration(least, period + jitter, words)
    for transition in transitions(model):
        duration = getattr(transition, "duration", None)
        words = f"transition {label(transition)} took"
        yield from _bounds(Part("duration", str(transition.id)), duration, words)
    for topic in channels(model, sym.TopicChannel):
        for writer in topic.publishers:
            for reader in topic.subscribers:
                part = Part("latency", str(topic.id), str(writer.place.id), str(reader.place.id))
                words = f"a message of topic {topic.topic} to {label(reader.place)} was on its way for"
                yield from _bounds(part, latency_between(writer, reader), words)
    for service in channels(model, sym.ServiceChannel):
        for client in service.clients:
            latency = latency_of_calls(client)
            for kind, what in (("request", "a request"), ("reply", "a response")):
                words = f"{what} of service {service.service}, client {client.client}, was on its way for"
                yield from _bounds(Part("latency", str(service.id), str(client.client), kind), latency, words)


def _bounds(part: Part, interval: pn.TimeInterval | None, words: str) -> Iterator[tuple[Part, Declaration]]:
    if interval is not None:
        latest = None if interval.latest is None else float(interval.latest)
        yield part, Declaration(float(interval.earliest), latest, words)


class Comparison:
    """Compares times that were measured with those that a model declares.

    The periods of timers count only if the model has times, as in questions with time.

    `allowance`: seconds by which a time may pass its bound.

    Attributes
    ----------
    compared : int
        Times for which something is declared.
    """

    def __init__(self, model: sym.SystemModel, allowance: float = ALLOWANCE) -> None:
        self._declared = declarations(model) if gives_times(model) else {}
        self._allowance = allowance
        self._counts: dict[Part, int] = {}
        self._found: dict[tuple[Part, str], Breach] = {}
        self.compared = 0

    @property
    def is_needed(self) -> bool:
        """Whether the model declares anything that can be compared."""
        return bool(self._declared)

    def take(self, seen: Seen, begun: float) -> None:
        """Compare a time; `begun` is the start of the run by the same clock."""
        declared = self._declared.get(seen.part)
        if declared is None:
            return
        self.compared += 1
        self._counts[seen.part] = self._counts.get(seen.part, 0) + 1
        # The true time lies between both: a bound counts as violated only if both violate it.
        if declared.most is not None and seen.least > declared.most + self._allowance:
            self._note(Breach(seen.part, "most", declared, seen.least, seen.at - begun, seen.record))
        elif seen.most < declared.least - self._allowance:
            self._note(Breach(seen.part, "least", declared, seen.most, seen.at - begun, seen.record))

    def _note(self, breach: Breach) -> None:
        key = breach.part, breach.bound
        known = self._found.setdefault(key, breach)
        if known is breach:
            return
        known.count += 1
        farther = breach.seconds - known.seconds
        if (farther if breach.bound == "most" else -farther) > 0:
            known.seconds, known.at, known.record = breach.seconds, breach.at, breach.record

    def breaches(self) -> list[Breach]:
        """Return the violated bounds, each once with its worst time, the earliest first."""
        for breach in self._found.values():
            breach.of = self._counts[breach.part]
        return sorted(self._found.values(), key=lambda each: each.at)
