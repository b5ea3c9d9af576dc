"""What bounds exclude if no search for all states ends: overflows of queues, and endless runs."""

from __future__ import annotations

from collections.abc import Iterable

from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.model.queues import queues
from dineros.analysis.model.subject import Subject
from dineros.analysis.model.wording import source_of
from dineros.metamodel import sym
from dineros.metamodel.times.given import says_times, with_lifespans


def never_lost(subject: Subject) -> set[str]:
    """Return the ids of transitions of a net with times that would lose a message or a tick, and never fire.

    Those of reader histories that are deep enough for all that can wait there; those of writer histories, if
    each message that is on its way has a clock: then it leaves the history at once; and those of timers whose
    callbacks begin before the next strike.
    """
    bounds = _bounds(subject)
    if bounds is None:
        return set()
    from dineros.transformations.rules.histories import R2, R3  # their modules take time to import
    from dineros.transformations.rules.times.strikes import D1

    found: set[str] = set()
    for queue in queues(subject):
        if queue.link.maker is R3:
            if bounds.never_overflows(source_of(queue.link, sym.SubscriberPort)):
                found.update(queue.drops)
        elif queue.link.maker is R2:
            ends = source_of(queue.link, sym.PublisherPort), source_of(queue.link, sym.SubscriberPort)
            if bounds.never_waits(*ends):
                found.update(queue.drops)
    for link in subject.links():
        is_miss = link.maker is D1 and link.role == "miss"
        if is_miss and bounds.loses_no_tick(source_of(link, sym.CallbackPage)):
            found.add(link.target.id)
    return found


def always_ending(subject: Subject, pages: Iterable[sym.CallbackPage]) -> set[sym.CallbackPage]:
    """Return the callbacks, among some, of which each run ends: their response times have bounds."""
    bounds = _bounds(subject)
    return set() if bounds is None else {page for page in pages if bounds.response(page).greatest is not None}


def _bounds(subject: Subject) -> Bounds | None:
    """Return the bounds of a model; None if it is of a kind that they do not know."""
    model = subject.model
    if not isinstance(model, sym.SystemModel) or model.middleware != sym.Middleware.ros2:
        return None
    return Bounds(model) if says_times(model) and not with_lifespans(model) else None
