"""The least depths of reader histories with which no message is displaced, with the times of a model.

Histories are made deeper until none overflows. Then a greater depth changes nothing: each history holds all
messages that it ever gets at once, and a history with one place less would displace a message.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from dineros.analysis.answers.budget import Budget
from dineros.analysis.latencies.answers import require_times
from dineros.analysis.latencies.parts import Parts
from dineros.analysis.timed.exploring import explore_timed
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.metamodel import sym
from dineros.metamodel.elements import channels

LARGEST = 64
"""The largest depth that is tried, unless the model has a larger one."""


@dataclass(frozen=True)
class Depth:
    """What depth a reader needs."""

    depth: int
    """What it has."""
    least: int | None
    """The least one with which its history displaces no message; None if it is not known."""
    reason: str = ""
    """Why it is not known; else empty."""

    def to_dict(self) -> dict[str, object]:
        """Return it for JSON."""
        return {"depth": self.depth, "least": self.least} | ({"reason": self.reason} if self.reason else {})


def least_depths(model: sym.SystemModel, budget: Budget) -> dict[str, Depth]:
    """Return by place of a subscriber the least depth of its history.

    If a history overflows even with the largest depth that is tried, the depths of the other histories
    allow for that overflow.

    Parameters
    ----------
    model : sym.SystemModel
        A model of the middleware ``ros2`` that gives times. Its depths are changed meanwhile.
    budget : Budget
        Limits of all searches together.

    Raises
    ------
    DinerosError
        As for `dineros.analysis.latencies.answers.Latencies`.
    """
    require_times(model)
    budget = budget.begun()
    readers = [port for topic in channels(model, sym.TopicChannel) for port in topic.subscribers]
    given = {port: int(port.limit) for port in readers}
    try:
        return _deepened(model, given, budget)
    finally:
        for port, limit in given.items():
            port.limit = limit


def _deepened(
    model: sym.SystemModel, given: Mapping[sym.SubscriberPort, int], budget: Budget
) -> dict[str, Depth]:
    while True:
        subject = timed_base_subject(model)
        explored = explore_timed(subject.timed, budget)
        if explored.reason:
            return {port.place.id: Depth(limit, None, explored.reason) for port, limit in given.items()}
        names = subject.timed.untimed.transitions
        index = {name: at for at, name in enumerate(subject.timed.untimed.places)}
        fired = {names[t] for t in explored.ways}
        histories = Parts(subject).histories
        full = [port for port, queue in histories.items() if fired & set(queue.drops)]
        deeper = [port for port in full if port.limit < max(LARGEST, given[port])]
        if not deeper:
            break
        for port in deeper:
            port.limit = min(2 * int(port.limit), max(LARGEST, given[port]))
    found = {}
    for port, queue in histories.items():
        longest = int(explored.markings[:, index[queue.load]].max())
        reason = f"a depth of {port.limit} does not suffice" if port in full else ""
        found[port.place.id] = Depth(given[port], None if reason else max(1, longest), reason)
    return found
