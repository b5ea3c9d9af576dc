"""Joins ports that replace each other: a member that is assigned again holds only the last one."""

from __future__ import annotations

from dineros.sources.cpp.following.machine import Machine
from dineros.sources.facts import Entity, NodeFact, is_open

_UNCERTAIN = ("conditional", "instances")
"""Details that say how certain a port is, and nothing about it."""


def join_replaced(machine: Machine) -> None:
    """Join the ports that one line assigns to one member of one object, if they are equal.

    A routine that is called from several places makes a port each time, and the pointer to the one before is
    gone: ``rclcpp`` removes a port with its last pointer. Ports in a list or map stay, but if their names are
    not known, calls that lead to one line say nothing about their number: it is open.
    """
    same: dict[int, Entity] = {}
    for node in machine.nodes:
        known: dict[tuple[object, ...], Entity] = {}
        for entity in node.entities:
            holder, is_last = machine.holders.get(id(entity), (None, False))
            if holder is None or not (is_last or is_open(entity.name) or "{" in entity.name):
                continue
            first = known.setdefault((holder, *_key(entity)), entity)
            if first is not entity:
                same[id(entity)] = first
                _join(first, entity)
                if not is_last:
                    first.details["instances"] = "open: made by several calls"
    if same:
        for node in machine.nodes:
            _replace(node, same)


def _key(entity: Entity) -> tuple[object, ...]:
    details = {key: repr(each) for key, each in entity.details.items() if key not in _UNCERTAIN}
    callbacks = [(role, str(each.at)) for role, each in sorted(entity.callbacks.items())]
    return (
        entity.kind,
        str(entity.at),
        entity.port,
        entity.name,
        entity.type,
        id(entity.group),
        tuple(sorted(details.items())),
        tuple(callbacks),
    )


def _join(first: Entity, other: Entity) -> None:
    for key in _UNCERTAIN:
        if key not in other.details and other.is_enabled:
            first.details.pop(key, None)
    first.is_enabled = first.is_enabled or other.is_enabled


def _replace(node: NodeFact, same: dict[int, Entity]) -> None:
    gone = [each for each in node.entities if id(each) in same]
    facts = {
        id(fact): same[id(each)].callbacks[role] for each in gone for role, fact in each.callbacks.items()
    }
    node.entities = [each for each in node.entities if id(each) not in same]
    node.callbacks = [each for each in node.callbacks if id(each) not in facts]
    for each in node.entities:
        if each.group is not None:
            each.group = same.get(id(each.group), each.group)
    for fact in node.callbacks:
        for effect in fact.effects:
            if effect.entity is not None:
                effect.entity = same.get(id(effect.entity), effect.entity)
            if effect.then is not None:
                effect.then = facts.get(id(effect.then), effect.then)
