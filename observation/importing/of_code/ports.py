"""The ports of a node in code."""

from __future__ import annotations

import re
from collections.abc import Iterable

from dineros.metamodel.matching import Quality
from dineros.observation.importing.of_code.node import CodedNode
from dineros.observation.systems import Endpoint, ObservedNode, TopicEndpoint
from dineros.sources.facts import Entity, is_open

_MIDDLEWARE = ("system default", "best available")
"""Qualities that the middleware decides."""
_ASK = ("clients", "action_clients")


def ports_of(node: CodedNode) -> ObservedNode:
    """Return a node with its ports, of which some are left out: the assumptions say which."""
    return ObservedNode(
        node.name,
        tuple(_topics(node, "publishers")),
        tuple(_topics(node, "subscriptions")) if node.is_spun else (),
        tuple(_others(node, "services")) if node.is_spun else (),
        tuple(_others(node, "clients")),
        tuple(_others(node, "action_servers")) if node.is_spun else (),
        tuple(_others(node, "action_clients")),
        lifecycle="unconfigured" if node.fact.managed else None,
    )


def _kept(node: CodedNode, kind: str) -> Iterable[tuple[Entity, str]]:
    for entity in node.fact.of(kind):
        if not entity.is_enabled or (kind in _ASK and _is_idle(node, entity)):
            continue
        name = node.names.get(entity)
        several = re.match(r"open: (\w+/(?:msg|srv|action)/\w+) or ", entity.type)
        if several is not None:
            node.taken.add(f"{node.at(entity.at)}: the type is {entity.type}; the first is assumed")
            entity.type = several[1]
        if name is None:
            node.taken.lack(
                f"{node.at(entity.at)}: omitted in the model, because its name is "
                f"{node.renamed.get(entity, entity.name)}"
            )
        elif is_open(entity.type):
            node.taken.lack(f"{node.at(entity.at)}: omitted in the model, because its type is {entity.type}")
        elif (
            "conditional" in entity.details
            and (other := node.chosen.get((kind, name), entity)).type != entity.type
        ):
            node.taken.lack(
                f"{node.at(entity.at)}: omitted in the model: {name} of line {other.at.line} is used instead"
            )
        else:
            yield entity, name


def _is_idle(node: CodedNode, client: Entity) -> bool:
    """Return whether a library made a client that no code uses, such as one of those for parameters."""
    if not client.details.get("via") or client.is_lent:
        return False
    return not any(each.is_open for each in node.fact.callbacks) and not any(
        effect.entity is client for each in node.fact.callbacks for effect in each.effects
    )


def _topics(node: CodedNode, kind: str) -> Iterable[TopicEndpoint]:
    for entity, name in _kept(node, kind):
        depth = entity.details.get("depth")
        yield TopicEndpoint(
            name,
            entity.type,
            _quality(node, entity),
            depth if isinstance(depth, int) and depth > 0 else None,
            node.at(entity.at),
            is_optional=any(entity.details.get(each) for each in ("conditional", "instances")),
        )


def _quality(node: CodedNode, entity: Entity) -> Quality:
    reliability, durability = entity.details.get("reliability"), entity.details.get("durability")
    for key, value in (("reliability", reliability), ("durability", durability)):
        if is_open(value) or value in _MIDDLEWARE:
            usual = "reliable" if key == "reliability" else "volatile"
            # With another value the ports may not match, so that no message ever arrives.
            say = node.taken.lack if is_open(value) else node.taken.add
            say(f"{node.at(entity.at)}: the {key} of {entity.name} is {value}; {usual} is assumed")
    times: dict[str, float | None] = {}
    for key in ("deadline", "lease_duration"):
        seconds = entity.details.get(key)
        times[key] = seconds if isinstance(seconds, float) else None
    for key in (*times, "liveliness"):
        value = entity.details.get(key)
        if is_open(value):
            words = f"the {key.replace('_', ' ')} of {entity.name} is {value}; the usual one is assumed"
            node.taken.lack(f"{node.at(entity.at)}: {words}")
    return Quality(
        "bestEffort" if reliability == "best_effort" else "reliable",
        "transientLocal" if durability == "transient_local" else "volatile",
        "manualByTopic" if entity.details.get("liveliness") == "manual_by_topic" else "automatic",
        times["deadline"],
        times["lease_duration"],
        None,
    )


def _others(node: CodedNode, kind: str) -> Iterable[Endpoint]:
    seen: dict[str, Entity] = {}
    for entity, name in _kept(node, kind):
        first = seen.setdefault(name, entity)
        if first is entity:
            yield Endpoint(name, entity.type, node.at(entity.at))
        elif kind != "clients" and entity.details.get("group") != first.details.get("group"):
            node.taken.add(f"{node.at(entity.at)}: treated as the same as that of line {first.at.line}")
