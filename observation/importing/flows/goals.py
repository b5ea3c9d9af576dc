"""Waits of callbacks for goals of actions: for the acceptance, and for the result."""

from __future__ import annotations

from dineros.observation.importing.flows.labels import Step
from dineros.sources.facts import Effect

_WAITS = ("blocks", "await", "spin-until", "polled")
"""Prefixes of effects that wait in the executor of the callback; other waits spin a node of their own."""


def waits_for_goal(effect: Effect) -> bool:
    """Return whether a callback waits without time-out for the acceptance or the result of a goal."""
    is_endless = effect.timeout is None and "open" not in effect.how
    return effect.do in ("send_goal", "get_result") and effect.how.startswith(_WAITS) and is_endless


def acceptance_after(effect: Effect, step: Step) -> tuple[Step, ...]:
    """Return the wait for the acceptance of a goal that follows its step, if the callback waits for it."""
    is_waiting = effect.do == "send_goal" and waits_for_goal(effect)
    return (Step("accepted", step.name, step.times, step.at),) if is_waiting else ()
