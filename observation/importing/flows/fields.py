"""Selects the topics whose messages decide about branches of callbacks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from dineros.metamodel.token_types.installed import MESSAGE, UnknownInterfaceError, installed_fields
from dineros.observation.importing.flows.deciding import tested
from dineros.observation.importing.flows.labels import Deciding
from dineros.observation.importing.given import Given, GivenNode
from dineros.observation.systems import ObservedNode
from dineros.sources.facts import Entity, NodeFact

_WORDS = {"and", "between", "false", "not", "or", "true"}
"""Words of the language of guards."""


def deciding_fields(nodes: Iterable[tuple[NodeFact, Mapping[Entity, str]]]) -> dict[str, Deciding]:
    """Return for each topic the boolean field that a callback tests and that all publications give one value.

    If one of them may have another value, both branches can run. Then the topic is left as it is: queues
    of messages that guards distinguish have many more states.

    Parameters
    ----------
    nodes : iterable of (NodeFact, mapping of Entity to str)
        The nodes, and the full names of their topics.
    """
    types: dict[str, set[str]] = {}
    lent: set[str] = set()
    asked: dict[str, set[str]] = {}
    sent: dict[str, set[tuple[str, bool]]] = {}
    for fact, names in nodes:
        for entity, name in names.items():
            if entity.kind in ("publishers", "subscriptions"):
                types.setdefault(name, set()).add(entity.type)
            if entity.kind == "publishers" and (fact.is_lent or entity.is_lent or "via" in entity.details):
                lent.add(name)  # code that is not in the folder may publish, too
            callback = entity.callbacks.get("callback")
            if entity.kind == "subscriptions" and callback is not None:
                asked.setdefault(name, set()).update(each.name for each in tested(callback))
        for effect in (each for callback in fact.callbacks for each in callback.effects):
            if effect.do == "publish" and effect.entity is not None and effect.entity in names:
                name = names[effect.entity]
                fields = set(effect.sends.items())
                sent[name] = sent.get(name, fields) & fields
    found = {}
    for name in sorted((set(asked) & set(sent)) - lent):
        if len(types[name]) == 1:
            (type,) = types[name]
            able = asked[name] & {field for field, _ in sent[name]} & _booleans(type)
            if able:
                found[name] = Deciding(type, min(able))
    return found


def certain(
    deciding: Mapping[str, Deciding], nodes: Iterable[ObservedNode], given: Given
) -> dict[str, Deciding]:
    """Return the topics on which each node of the model sends known values, of the type that was read."""
    found = dict(deciding)
    for node in nodes:
        for port in (*node.publishers, *node.subscribers):
            if port.topic in found and port.type != found[port.topic].type:
                del found[port.topic]
        for port in node.publishers:
            if port.topic in found and not _is_certain(given.node(node.name), port.topic):
                del found[port.topic]
    return found


def _is_certain(said: GivenNode, topic: str) -> bool:
    """Return whether all steps of a node that publish on a topic have known values."""
    callbacks = list(said.callbacks.values())
    if said.timers is None or any(each.does is None for each in callbacks):
        return False
    steps = [step for each in callbacks for step in each.does or ()]
    return all(step.sends for step in steps if (step.verb, step.name) == ("publish", topic))


def _booleans(type: str) -> set[str]:
    """Return the boolean fields of an installed message; none if it is not installed."""
    if not MESSAGE.fullmatch(type):
        return set()
    try:
        names = {each.name for each in installed_fields(type) if each.kind == "boolean"}
        return names - _WORDS
    except UnknownInterfaceError:
        return set()
