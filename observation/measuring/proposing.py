"""Proposes times for a model: intervals from the least to the greatest observed time.

An observed maximum is not a bound: a later time can be greater. The next time lies within the least and the
greatest of n with the probability (n - 1) / (n + 1), if all of them are equally likely to be the extremes;
that is the confidence.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Literal

from dineros.metamodel import pn, sym
from dineros.metamodel.build import seconds
from dineros.metamodel.callbacks.bodies import timers_of
from dineros.metamodel.callbacks.groups import runs_callbacks
from dineros.metamodel.elements import channels, label, node_net_of, pages, transitions
from dineros.metamodel.records import Fire
from dineros.observation.measuring.samples import Samples, Summary, duration_text
from dineros.observation.measuring.seen import Seen

LEAST_TIMES = 5
"""Least number of samples of a proposal."""
SAME_PERIOD = 0.01
"""Part of a period by which the median of the times between ticks may differ from it."""

Times = Literal["duration", "period", "latency"]


@dataclass(frozen=True)
class TimeProposal:
    """A measurement of an element, and the proposed time."""

    feature: Times
    """The proposed feature: ``duration``, ``period``, ``latency``."""
    element: str
    name: str
    """`element`, `name`: its id, or the node and the callback of an imported model; and its name in messages.
    """
    summary: Summary
    """The measurement."""
    source: str
    """The name of the recording."""
    period: float = 0.0
    jitter: float = 0.0
    """`period`, `jitter`: of a timer: the period that it has, and the greatest deviation from it."""

    @property
    def confidence(self) -> float:
        """The probability that the next time lies within the interval."""
        return (self.summary.count - 1) / (self.summary.count + 1)

    @property
    def interval(self) -> tuple[float, float]:
        """The least and the greatest time, in seconds: whole microseconds, so that all times lie within."""
        return _micro(self.summary.least, math.floor), _micro(self.summary.greatest, math.ceil)

    @property
    def origin(self) -> str:
        """The source of the interval, in one line."""
        return f"{self.source}: {self.summary}"

    def __str__(self) -> str:
        if self.feature == "period":
            shown = f"ticks every {duration_text(self.period)}, jitter {duration_text(self.jitter)}"
        else:
            least, greatest = map(duration_text, self.interval)
            shown = f"{_VERBS[self.feature]} {least} to {greatest}"
        return f"{self.confidence:.2f}  {self.name} {shown} ({self.summary})"

    def to_dict(self) -> dict[str, Any]:
        """Return it for JSON."""
        timer = {"period": self.period, "jitter": self.jitter} if self.feature == "period" else {}
        return {
            "feature": self.feature,
            "element": self.element,
            "confidence": self.confidence,
            "least": self.interval[0],
            "greatest": self.interval[1],
            **timer,
            "measured": self.summary.to_dict(),
            "source": self.source,
        }


_VERBS = {"duration": "takes", "latency": "is on its way for"}


def ticks_proposed(
    element: str, name: str, gaps: Samples, source: str, declared: float | None = None
) -> TimeProposal | None:
    """Return the proposal of the times between ticks; None if there are too few.

    Parameters
    ----------
    element, name : str
        As for `TimeProposal`.
    gaps : Samples
        The times between ticks.
    source : str
        The name of the recording.
    declared : float, optional
        The period that the timer has; it stays if the median is near.
    """
    if len(gaps) < LEAST_TIMES:
        return None
    summary = gaps.summary()
    period = summary.median
    if declared and abs(period - declared) <= SAME_PERIOD * declared:
        period = declared
    jitter = min(period, max(0.0, summary.greatest - period, period - summary.least))
    return TimeProposal(
        "period", element, name, summary, source, _micro(period, round), _micro(jitter, math.ceil)
    )


def _micro(seconds: float, rounded: Callable[[float], int]) -> float:
    # Times that differ by less than a nanosecond are equal.
    return rounded(round(seconds * 1e6, 3)) / 1e6


def time_proposals(model: sym.SystemModel, times: Iterable[Seen], source: str) -> list[TimeProposal]:
    """Return the proposals from the traces of a run for the elements of its model, in model order.

    Durations are those of callbacks, and of transitions with handlers in other node nets. Times between ticks
    and latencies count only without waits. A reader's latency is that of all of its publishers.

    Parameters
    ----------
    model : sym.SystemModel
        The model that was run.
    times : iterable of Seen
        The measurement.
    source : str
        The name of the recording.
    """
    found: defaultdict[tuple[str, str], Samples] = defaultdict(Samples)
    for seen in times:
        part = seen.part
        if part.feature == "duration":
            fired = seen.record
            is_firing = isinstance(fired, Fire) and fired.transition.rpartition("].")[2] == part.element
            if not is_firing or (isinstance(fired, Fire) and fired.handlers):
                found["duration", part.element].add(seen.least)
        elif seen.is_certain:
            found[part.feature, part.reader or part.element].add(max(0.0, seen.least))
    return list(_proposed(model, found, source))


def _proposed(
    model: sym.SystemModel, found: defaultdict[tuple[str, str], Samples], source: str
) -> Iterator[TimeProposal]:
    def proposal(feature: Times, element: str, name: str) -> Iterator[TimeProposal]:
        samples = found.get((feature, element))
        if samples is not None and len(samples) >= LEAST_TIMES:
            yield TimeProposal(feature, element, name, samples.summary(), source)

    timers = set(timers_of(model))
    for page in pages(model):
        if isinstance(page, sym.CallbackPage):
            name = f"callback {label(page)}"
            yield from proposal("duration", str(page.id), name)
            if page in timers:
                gaps = found.get(("period", str(page.id)), Samples())
                ticks = ticks_proposed(str(page.id), name, gaps, source, page.timer)
                yield from [ticks] if ticks is not None else []
    for transition in transitions(model):
        node = node_net_of(transition)
        if isinstance(transition, sym.Transition) and node is not None and not runs_callbacks(node):
            yield from proposal("duration", str(transition.id), f"transition {label(transition)}")
    for topic in channels(model, sym.TopicChannel):
        for reader in topic.subscribers:
            place = reader.place
            name = f"a message of topic {topic.topic} to {label(place)}"
            yield from proposal("latency", str(place.id), name)


def give_times(model: sym.SystemModel, accepted: Iterable[TimeProposal]) -> None:
    """Set the times of accepted proposals in a model, each with its source; the model is changed."""
    by_id: dict[tuple[str, str], pn.Element | sym.SubscriberPort] = {}
    for page in pages(model):
        by_id["duration", str(page.id)] = by_id["period", str(page.id)] = page
    for transition in transitions(model):
        by_id["duration", str(transition.id)] = transition
    for topic in channels(model, sym.TopicChannel):
        for reader in topic.subscribers:
            by_id["latency", str(reader.place.id)] = reader
    for each in accepted:
        element = by_id[each.feature, each.element]
        if each.feature == "period":
            assert isinstance(element, sym.CallbackPage)
            element.timer, element.jitter = each.period, each.jitter
            left = [word for word in (element.assumed or "").split() if word != "period"]
            element.assumed = " ".join(left) or None
            continue
        interval = seconds(*each.interval)
        interval.source = each.origin
        setattr(element, each.feature, interval)
