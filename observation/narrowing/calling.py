"""Determines from a recording whether nodes wait for the responses of the services that they call."""

from __future__ import annotations

from collections.abc import Collection

from dineros.observation.importing.given import Given, GivenNode
from dineros.observation.narrowing.proposals import Verb
from dineros.observation.systems import (
    REQUEST_SENT,
    RESPONSE_RECEIVED,
    ObservedSystem,
    RecordedTopic,
    event_name,
)


def verbs_of(
    system: ObservedSystem, recorded: Collection[RecordedTopic], given: Given | None = None
) -> dict[tuple[str, str], Verb]:
    """Return ``send`` for the nodes and services if the recording shows that the node continues.

    A callback that waits for a response keeps its thread. So if a node with one thread takes a response, no
    callback waits for it. If there are several clients, the recipient of a response is unknown.

    Parameters
    ----------
    system : ObservedSystem
        Nodes with their clients.
    recorded : collection of RecordedTopic
        Topics and events of the recording, with their numbers of messages.
    given : Given, optional
        Hand-written facts about threads, and about callbacks that await.
    """
    seen = {each.name for each in recorded if each.messages}
    clients = [(node.name, each.name) for node in system.nodes for each in node.clients]
    return {
        (node, service): "send"
        for node, service in clients
        if {event_name(service, each) for each in (REQUEST_SENT, RESPONSE_RECEIVED)} <= seen
        and sum(other == service for _, other in clients) == 1
        and _has_one_thread((given or Given()).node(node))
    }


def _has_one_thread(said: GivenNode) -> bool:
    return (said.threads or 1) == 1 and not any(each.awaits for each in said.callbacks.values())
