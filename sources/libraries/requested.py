"""Callbacks that requests from outside run: of transitions, of changed parameters, of guard conditions.

A transition runs in the callback of the service ``~/change_state``, what checks new values of parameters in
that of ``~/set_parameters``. Both are in the default callback group of the node, in rclpy and in rclcpp. A
guard condition has its own group; other code triggers it.
"""

from __future__ import annotations

from dataclasses import replace

from dineros.sources.facts import CallbackFact, Entity, NodeFact

AT_ANY_TIME = "at any time"
"""Period of a timer that stands for requests from outside."""
TRANSITION = "transition"
"""Kind of callbacks that transitions run."""
PARAMETERS = "parameters"
"""Kind of callbacks that check or hear of new values of parameters."""
GUARD = "guard condition"
"""Kind of callbacks that run when code triggers a guard condition."""


def waits_in_transition(callback: CallbackFact) -> bool:
    """Return whether the callback of a transition waits for another node, or may do so."""
    waits = (each.how.startswith(("blocks", "spin", "waits", "polled")) for each in callback.effects)
    return callback.kind == TRANSITION and (callback.is_open or any(waits))


def with_requested(node: NodeFact) -> NodeFact:
    """Return a node with timers for callbacks that requests from outside run: itself, if these do nothing.

    Requests may come from programs that are not in the code, at any time: each such callback that does
    something is that of a timer without period, in the default group. The same holds for guard conditions,
    in their own group.
    """
    # A controller's transitions run in a callback of its manager.
    is_managed = node.managed and any(word in node.base.lower() for word in ("lifecycle", "managed"))
    kinds = (TRANSITION, PARAMETERS) if is_managed else (PARAMETERS,)
    added = [
        Entity("timers", each.name, each.at, details={"period": AT_ANY_TIME}, callbacks={"callback": each})
        for each in node.callbacks
        if each.kind in kinds and (each.effects or each.is_open)
    ]
    added += [
        replace(each, kind="timers", details={**each.details, "period": AT_ANY_TIME})
        for each in node.of("guard_conditions")
        if (fact := each.callbacks.get("callback")) is not None and (fact.effects or fact.is_open)
    ]
    return replace(node, entities=[*node.entities, *added]) if added else node
