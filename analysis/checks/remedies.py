"""What would make a net bounded, in the words of the model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from dineros.analysis.model.queues import queues
from dineros.analysis.model.subject import Subject

if TYPE_CHECKING:
    from dineros.analysis.covering.growth import Remedy


def remedy_text(subject: Subject, remedy: Remedy) -> str:
    """Return the necessary addition: a capacity, an acknowledgement, the end of a count."""
    parts = []
    if len(remedy.weights) == 1:
        (place,) = remedy.weights
        parts.append(f"a capacity of {remedy.credits} at {subject.place_text(place)}")
    elif remedy.weights:
        parts.append(
            f"an acknowledgement: {_named(subject, remedy.waiting)} waiting for "
            f"{_acknowledgers(subject, remedy.acknowledging)}, {remedy.credits} at a time"
        )
    if remedy.counters:
        counters = ", ".join(subject.place_text(place) for place in remedy.counters)
        parts.append(f"without the counters that grow forever: {counters}")
    return ", ".join(parts)


def _acknowledgers(subject: Subject, transitions: Sequence[int]) -> str:
    losing = {subject.transition_index[drop] for queue in queues(subject) for drop in queue.drops}
    named = _named(subject, [t for t in transitions if t not in losing])
    lost = "the loss of a message" if losing.intersection(transitions) else ""
    return " or ".join(part for part in (named, lost) if part)


def _named(subject: Subject, transitions: Sequence[int]) -> str:
    return ", ".join(dict.fromkeys(subject.transition_text(t) for t in transitions))
