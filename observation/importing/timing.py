"""Derives times from code: the order in which an executor takes callbacks, and their sleeps."""

from __future__ import annotations

from typing import NamedTuple

from dineros.sources.facts import CallbackFact, Entity, NodeFact
from dineros.sources.places import Place

_STOPS = {
    "cancel_timer": "is cancelled",
    "reset_timer": "is reset",
    "destroy": "is destroyed",
    "create_timer": "is made",
}
"""Possible changes of a timer while its node runs, in words."""


class Stops(NamedTuple):
    """The reason why a timer does not tick all the time, with its location."""

    at: Place
    words: str


def order_of(fact: NodeFact) -> str | None:
    """Return the order in which the executor of a node takes callbacks; None: unknown from the code.

    Executors with one thread and a wait set have the order of their client library. For a component it
    depends on its container and the other components.
    """
    if fact.threads != 1 or fact.plugin:
        return None
    words = fact.executor.partition(" (")[0]
    if fact.at.file.endswith(".py"):
        return "rclpy" if words in ("rclpy.spin", "SingleThreadedExecutor, spin") else None
    return "rclcpp" if words == "SingleThreadedExecutor" else None


def sleeps_of(fact: CallbackFact) -> tuple[float, None] | None:
    """Return the least seconds of a callback: its unconditional sleeps."""
    sleeps = [
        effect.timeout or 0.0
        for effect in fact.effects
        if (effect.do, effect.when) == ("sleep", "always") and effect.how in ("", "time.sleep")
    ]
    return (round(sum(sleeps), 9), None) if sum(sleeps) > 0 else None


def stops_of(timer: Entity, fact: NodeFact) -> Stops | None:
    """Return why a timer does not tick all the time; None: it does.

    Transitions of a managed node do not count: also in the model, its timers run while it is configured.
    Actions of a main function in Python do not count either: they end the program. In C++, constructors are
    part of it.
    """
    own = timer.callbacks.get("callback")
    ignored = ("transition", "main") if fact.at.file.endswith(".py") else ("transition",)
    for callback in fact.callbacks:
        for effect in callback.effects if callback.kind not in ignored else ():
            if effect.entity is timer and effect.do in _STOPS:
                ends = callback is own and effect.do == "cancel_timer" and effect.when == "always"
                again = any(
                    each.entity is timer and each.do == "reset_timer"
                    for other in fact.callbacks
                    for each in other.effects
                )
                once = " each time, so that it fires once" if ends and not again else ""
                name = own.name if own is not None else timer.port
                return Stops(effect.at, f"timer {name} {_STOPS[effect.do]} in {callback.name}{once}")
    return None
