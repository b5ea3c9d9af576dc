"""Selects the topics whose messages decide about branches of callbacks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from dineros.observation.importing.flows.deciding import answers_tested, tested
from dineros.observation.importing.flows.labels import Deciding, of_service
from dineros.observation.importing.flows.values import KINDS, deciding, is_of
from dineros.observation.importing.given import Given, GivenNode
from dineros.observation.systems import ObservedNode
from dineros.sources.branches import Give, walk
from dineros.sources.facts import Entity, NodeFact, is_open
from dineros.sources.interfaces import Interfaces
from dineros.sources.variables import Known

_MOST_DEPTH = 1
"""Limit of the depth of the queues of a topic whose messages may have both values of a field."""
_WORDS = {"and", "between", "false", "not", "or", "true"}
"""Words of the language of guards."""


def deciding_fields(
    nodes: Iterable[tuple[NodeFact, Mapping[Entity, str]]], interfaces: Interfaces
) -> dict[str, Deciding]:
    """Return for each topic the field that a callback tests and whose value is known in all publications.

    The field is a truth value or a whole number.

    If one of them may have any value, both branches can run. If they have both values, too, unless the queues
    are short: the number of contents of a queue doubles with each message that guards distinguish.

    Parameters
    ----------
    nodes : iterable of (NodeFact, mapping of Entity to str)
        The nodes, and the full names of their topics.
    interfaces : Interfaces
        Those of the folders.
    """
    types: dict[str, set[str]] = {}
    lent: set[str] = set()
    asked: dict[str, dict[str, set[Known]]] = {}
    deep: set[str] = set()
    sent: dict[str, dict[str, set[Known]]] = {}
    for fact, names in nodes:
        for entity, name in names.items():
            if entity.kind in ("publishers", "subscriptions"):
                types.setdefault(name, set()).add(entity.type)
                depth = entity.details.get("depth")
                if not isinstance(depth, int) or not 0 < depth <= _MOST_DEPTH:
                    deep.add(name)
            if entity.kind == "publishers" and (fact.is_lent or entity.is_lent or "via" in entity.details):
                lent.add(name)  # code that is not in the folder may publish, too
            callback = entity.callbacks.get("callback")
            if entity.kind == "subscriptions" and callback is not None:
                for test in tested(callback):
                    asked.setdefault(name, {}).setdefault(test.name, set()).update(test.values)
        for effect in (each for callback in fact.callbacks for each in callback.effects):
            if effect.do == "publish" and effect.entity is not None and effect.entity in names:
                name = names[effect.entity]
                before = sent.get(name, {field: set() for field in effect.sends})
                sent[name] = {
                    field: before[field] | {value} for field, value in effect.sends.items() if field in before
                }
    found: dict[str, Deciding] = {}
    for name in sorted((set(asked) & set(sent)) - lent):
        if len(types[name]) == 1:
            (type,) = types[name]
            for known in _decided(type, type, asked[name], sent[name], interfaces, has_others=False):
                if len(sent[name][known.name]) == 1 or name not in deep:
                    found.setdefault(name, known)
    return found


def certain(
    deciding: Mapping[str, Deciding],
    nodes: Iterable[ObservedNode],
    observed: Iterable[ObservedNode],
    given: Given,
) -> dict[str, Deciding]:
    """Return the topics and services whose fields still decide, in the types that were read.

    Parameters
    ----------
    deciding : mapping of str to Deciding
        Those by the code.
    nodes : iterable of ObservedNode
        The nodes of the model: each sends known values on such a topic.
    observed : iterable of ObservedNode
        All nodes: such a service has one server. What it answers may be open.
    given : Given
        Hand-written facts about the nodes.
    """
    found, observed, loose = dict(deciding), list(observed), list[str]()
    for key, known in found.items():
        ports = [
            (port.type, is_server)
            for node in observed
            for is_server in (True, False)
            for port in (node.servers if is_server else node.clients)
            if of_service(port.name) == key
        ]
        if ports and ({type for type, _ in ports} != {known.type} or sum(each for _, each in ports) > 1):
            loose.append(key)
    for key in loose:
        del found[key]
    for node in nodes:
        for port in (*node.publishers, *node.subscribers):
            if port.topic in found and port.type != found[port.topic].type:
                del found[port.topic]
        for port in node.publishers:
            if port.topic in found and not _is_certain(given.node(node.name), port.topic):
                del found[port.topic]
    return found


def deciding_responses(
    nodes: Iterable[tuple[NodeFact, Mapping[Entity, str]]], interfaces: Interfaces
) -> dict[str, Deciding]:
    """Return for each service the field of its response that clients test and to which the server assigns.

    Parameters
    ----------
    nodes : iterable of (NodeFact, mapping of Entity to str)
        The nodes, and the full names of their services.
    interfaces : Interfaces
        Those of the folders.
    """
    types: dict[str, set[str]] = {}
    servers: dict[str, list[dict[str, set[Known]]]] = {}
    asked: dict[str, dict[str, set[Known]]] = {}
    for fact, names in nodes:
        for entity, name in names.items():
            if entity.kind in ("clients", "services"):
                types.setdefault(name, set()).add(entity.type)
            if entity.kind == "services":
                callback = entity.callbacks.get("callback")
                body = [] if callback is None or entity.is_lent or fact.is_lent else callback.body or []
                given: dict[str, set[Known]] = {}
                for each in walk(body):
                    if isinstance(each, Give) and each.value is not None:
                        given.setdefault(each.name, set()).add(each.value)
                servers.setdefault(name, []).append(given)
        for callback in fact.callbacks:
            for test in answers_tested(callback):
                client = None if test.call is None else test.call.entity
                if client is not None and client in names:
                    asked.setdefault(names[client], {}).setdefault(test.name, set()).update(test.values)
    found: dict[str, Deciding] = {}
    for name, fields in asked.items():
        type = min(types[name])
        if len(types[name]) == 1 and len(servers.get(name, ())) == 1 and not is_open(type):
            part, given = f"{type}_Response", servers[name][0]
            for known in _decided(type, part, fields, given, interfaces, has_others=True):
                found.setdefault(of_service(name), known)
    return found


def _decided(
    type: str,
    part: str,
    asked: Mapping[str, set[Known]],
    given: Mapping[str, set[Known]],
    interfaces: Interfaces,
    *,
    has_others: bool,
) -> Iterator[Deciding]:
    """Yield what decides of the fields of a part of a type that code tests and gives values to."""
    kinds, every = _kinds(part, interfaces), any if has_others else all
    for field in sorted(set(asked) & set(given) & set(kinds)):
        values, kind = given[field], kinds[field]
        if every(is_of(kind, each, interfaces) for each in values):
            found = deciding(type, field, kind, values, asked[field], interfaces, has_others=has_others)
            if found is not None:
                yield found


def _is_certain(said: GivenNode, topic: str) -> bool:
    """Return whether all steps of a node that publish on a topic have known values."""
    callbacks = list(said.callbacks.values())
    if said.timers is None or any(each.does is None for each in callbacks):
        return False
    steps = [step for each in callbacks for step in each.does or ()]
    return all(step.sends for step in steps if (step.verb, step.name) == ("publish", topic))


def _kinds(part: str, interfaces: Interfaces) -> dict[str, str]:
    """Return the fields of a message, or of a part of a service, that may decide, with their ROS types."""
    known = interfaces.fields(part) or ()
    return {
        each.name: str(each.ros)
        for each in known
        if each.kind in ("boolean", "integer") and each.ros in KINDS and each.name.lower() not in _WORDS
    }
