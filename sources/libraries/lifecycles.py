"""Transitions of managed nodes as callbacks that run at any time.

A transition runs in the callback of the service ``~/change_state``, which is in the default callback group of
the node, in rclpy and in rclcpp.
"""

from __future__ import annotations

from dataclasses import replace

from dineros.sources.facts import CallbackFact, Entity, NodeFact

AT_ANY_TIME = "at any time"
"""Period of a timer that stands for requests from outside."""
TRANSITION = "transition"
"""Kind of callbacks that transitions run."""


def waits_in_transition(callback: CallbackFact) -> bool:
    """Return whether the callback of a transition waits for another node, or may do so."""
    waits = (each.how.startswith(("blocks", "spin", "waits", "polled")) for each in callback.effects)
    return callback.kind == TRANSITION and (callback.is_open or any(waits))


def with_transitions(node: NodeFact) -> NodeFact:
    """Return a node with timers for its transitions: itself, if these do nothing.

    Requests for transitions may come from programs that are not in the code, at any time: each transition
    that does something is the callback of a timer without period, in the default group.

    Parameters
    ----------
    node : NodeFact
        The node.
    """
    if not node.managed or not any(word in node.base.lower() for word in ("lifecycle", "managed")):
        return node  # a controller's transitions run in a callback of its manager
    added = [
        Entity("timers", each.name, each.at, details={"period": AT_ANY_TIME}, callbacks={"callback": each})
        for each in node.callbacks
        if each.kind == TRANSITION and (each.effects or each.is_open)
    ]
    return replace(node, entities=[*node.entities, *added]) if added else node
