"""Losses that bounds exclude: where no search for all states ends, they prove that queues never overflow."""

from __future__ import annotations

from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.model.queues import queues
from dineros.analysis.model.subject import Subject
from dineros.analysis.model.wording import source_of
from dineros.metamodel import sym
from dineros.metamodel.times.given import says_times, with_lifespans
from dineros.transformations.rules.histories import R2, R3


def never_lost(subject: Subject) -> set[str]:
    """Return the ids of transitions of a net with times that would lose a message, and never fire.

    Those of reader histories that are deep enough for all that can wait there; and those of writer histories,
    if each message that is on its way has a clock: then it leaves the history at once.
    """
    model = subject.model
    if not isinstance(model, sym.SystemModel) or model.middleware != sym.Middleware.ros2:
        return set()
    if not says_times(model) or with_lifespans(model):
        return set()
    bounds = Bounds(model)
    found: set[str] = set()
    for queue in queues(subject):
        if queue.link.maker is R3:
            if bounds.never_overflows(source_of(queue.link, sym.SubscriberPort)):
                found.update(queue.drops)
        elif queue.link.maker is R2:
            ends = source_of(queue.link, sym.PublisherPort), source_of(queue.link, sym.SubscriberPort)
            if bounds.never_waits(*ends):
                found.update(queue.drops)
    return found
