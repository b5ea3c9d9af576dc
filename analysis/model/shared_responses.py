"""What answers assume of clients that share a service or an action.

On ROS 2, each client of a service receives the responses to all clients and discards those of the others when
it takes them. Until then they occupy its history. `rclpy` 7.1.6 with Fast DDS was seen to lose the response
of a busy client when 10 responses to another client arrived after it; 9 did no harm. In the net, each client
has a history of its own. So an answer about all runs assumes that no client is busy for so long.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeAlias

from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.groups import callback_page_of, runs_callbacks
from dineros.metamodel.calls import actions, services
from dineros.metamodel.elements import node_net_of, pages

SharingClient: TypeAlias = sym.ClientPort | sym.ActionClientPort

KEPT_ANSWERS = 10
"""Answers that a client of an action keeps, by the QoS profile of services."""


def shared_responses(model: sym.SystemModel) -> list[str]:
    """Return the assumptions that answers about all runs of a model make, one for each service and action.

    A client is named if its node runs callbacks, if it waits without a time-out, if another callback of its
    node can hold the executor while a response waits, and if another node has a client, too. A client with
    a time-out may give up in the net as well, and a node that runs our engine asks again.

    `model`: a model by the rules of ROS 2.
    """
    callbacks = [page for page in pages(model) if isinstance(page, sym.CallbackPage)]
    found = []
    for service in services(model):
        if names := _busy_clients(service.clients, callbacks):
            found.append(_assumption(f"service {service.service}", names, service.depth))
    for action in actions(model):
        if names := _busy_clients(action.clients, callbacks):
            found.append(_assumption(f"action {action.action}", names, KEPT_ANSWERS))
    return found


def _assumption(channel: str, names: list[str], depth: int) -> str:
    clients = f"client {names[0]}" if len(names) == 1 else f"clients {', '.join(names)}"
    return (
        f"fewer than {depth} responses to other clients of {channel} arrive"
        f" while a response waits for the executor of {clients}"
    )


def _busy_clients(clients: Iterable[SharingClient], callbacks: Sequence[sym.CallbackPage]) -> list[str]:
    """Return the clients of one service or action that may lose a response because of the other clients."""
    nodes = {client: node_net_of(_asking_place(client)) for client in clients}
    if len({id(node) for node in nodes.values()}) < 2:
        return []
    busy = {
        client.client
        for client, node in nodes.items()
        if runs_callbacks(node)
        and not getattr(client, "timeout", None)
        and _can_be_busy(client, [page for page in callbacks if node_net_of(page) is node])
    }
    return sorted(busy)


def _asking_place(client: SharingClient) -> pn.Place:
    return client.request if isinstance(client, sym.ClientPort) else client.goal


def _can_be_busy(client: SharingClient, callbacks: Sequence[sym.CallbackPage]) -> bool:
    """Return whether one of the callbacks of its node can run while the client waits."""
    page = callback_page_of(_asking_place(client))
    if page is None or any(each is not page for each in callbacks):
        return True
    return page.group is not None and page.group.kind == sym.CallbackGroupKind.reentrant
