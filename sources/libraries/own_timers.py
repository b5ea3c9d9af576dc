"""Timers of libraries: what they do, as a table of idioms says."""

from __future__ import annotations

from dineros.sources.branches import Do
from dineros.sources.facts import CallbackFact, Effect, Entity


def publish_at_each_tick(timer: Entity, publisher: Entity) -> None:
    """Give the timer of a library its callback, which publishes.

    The callback is not in the code of the folder, so it is not in the list of the callbacks of its node.
    """
    effect = Effect("publish", publisher.port, timer.at, "always", entity=publisher)
    found = CallbackFact(f"timer of {timer.details['via']}", "timer", timer.at, [effect])
    found.body = [Do(effect)]
    timer.callbacks["callback"] = found
