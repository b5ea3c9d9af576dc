"""Determines which callbacks of a node can run at once, by its threads, callback groups and entities."""

from __future__ import annotations

from collections.abc import Iterable

from dineros.sources.facts import CallbackFact, Entity, NodeFact, is_open

CALLED = (
    *("subscription", "timer", "service", "goal", "cancel", "accepted", "done callback", "feedback"),
    *("transition", "parameters", "guard condition", "task"),
)
"""Kinds of callbacks that an executor runs in turn."""


def may_have_one_thread(node: NodeFact) -> bool:
    """Return whether an executor has one thread, or an unknown number."""
    return node.is_single or (is_open(node.threads) and not node.apart)


def if_one_thread(node: NodeFact) -> str:
    """Return the words for what holds only if an executor has one thread; empty if it has one."""
    return "" if node.is_single else f", if the executor has one thread ({node.threads})"


def overlaps_itself(callback: CallbackFact, node: NodeFact) -> bool:
    """Return whether several runs of a callback may overlap, if there are several threads."""
    kinds = [
        str(group.details.get("kind", ""))
        for entity in node.entities
        if callback in entity.callbacks.values() and (group := node.group_of(entity)) is not None
    ]
    return callback.kind == "execute" or any(kind.startswith("reentrant") for kind in kinds)


def group_of_callback(callback: CallbackFact, node: NodeFact) -> str | None:
    """Return the mutually exclusive group that a callback is known to be in."""
    return common_group((each for each in node.entities if callback in each.callbacks.values()), node)


def common_group(entities: Iterable[Entity], node: NodeFact) -> str | None:
    """Return the mutually exclusive group that all entities are known to be in."""
    found: set[str | None] = set()
    for entity in entities:
        said = str(entity.details.get("group", "default"))
        if is_open(said):
            return None
        group = node.group_of(entity)
        if group is None:
            found.add("default")
        elif str(group.details.get("kind", "")).startswith("exclusive"):
            found.add(f"{group.at} {id(group)}")  # a line may make several
        else:
            found.add(None)
    return found.pop() if len(found) == 1 else None


def starters_of(callback: CallbackFact, node: NodeFact) -> list[Entity]:
    """Return the entities that start a callback.

    A done callback starts when its client has taken the response, which needs the group of the client. It
    runs in no group then.
    """
    clients = [
        effect.entity
        for each in node.callbacks
        for effect in each.effects
        if (effect.then is callback or callback in effect.meanwhile) and effect.entity is not None
    ]
    return [*clients, *(each for each in node.entities if callback in each.callbacks.values())]
