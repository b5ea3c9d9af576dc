"""Finds types of an observed system that are not installed here."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator

from dineros.analysis.witnesses.findings import Fault, Finding
from dineros.metamodel.errors import listed
from dineros.metamodel.token_types.installed import UnknownInterfaceError, installed_fields
from dineros.observation.systems import ObservedSystem

UNKNOWN = Fault(
    "type-unknown",
    "note",
    "The message type of a topic is not installed here: the model names it, but its fields are unknown.",
    "{topics}: the type is unknown here: {why}",
)


def unknown_types(system: ObservedSystem) -> Iterator[Finding]:
    """Yield a finding for each message that is not installed here.

    The elements are the full names of the topics and of the nodes that have it.
    """
    found = [(port.type, port.topic, node.name) for node, port in system.publishers()]
    found += [(port.type, port.topic, node.name) for node, port in system.subscribers()]
    found += [(topic.type, topic.name, "") for topic in system.topics]
    users: dict[str, list[str]] = defaultdict(list)
    for type, topic, node in sorted(found):
        users[type] += [name for name in (topic, node) if name and name not in users[type]]
    for type, names in users.items():
        try:
            installed_fields(type)
        except UnknownInterfaceError as error:
            topics = sorted({topic for kind, topic, _ in found if kind == type})
            yield UNKNOWN.found(*names, topics=listed(topics), why=error)
