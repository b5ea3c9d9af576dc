"""Which callbacks bounds follow, why not others, and how many requests and goals are under way at once."""

from __future__ import annotations

from dineros.analysis.bounds.work import NotBoundedError
from dineros.metamodel import sym
from dineros.metamodel.callbacks.groups import holds_thread, works_on_goals
from dineros.metamodel.elements import label, node_net_of
from dineros.metamodel.times.paces import slots


def why_not_followed(page: sym.CallbackPage, is_exclusive: bool, is_server: bool) -> str:
    """Return why nothing bounds when a callback runs, in words; empty if that can be bounded."""
    name = f"callback {label(page)}"
    if page.awaits:
        return f"{name} releases its thread while it waits"
    if page.kind in (sym.CallbackKind.timer, sym.CallbackKind.subscriber):
        return ""
    if not is_server:
        return f"{name} is not called by a timer, messages or requests"
    return "" if is_exclusive else f"runs of {name} overlap, and each needs an instance of its server"


def clients_of(server: sym.ServerPort) -> list[sym.ClientPort]:
    """Return the clients of a service."""
    return [] if server.channel is None else list(server.channel.clients)


def require_held(server: sym.ServerPort) -> None:
    """Refuse a service whose clients can have more requests under way than they may have outstanding."""
    service = f"service {'' if server.channel is None else server.channel.service}"
    for client in clients_of(server):
        node = node_net_of(client.request)
        if node is not None and node.lifecycle is not None:
            raise NotBoundedError(
                f"node {label(node)} calls {service} and is managed: it can be stopped and started"
            )
        if client.timeout or client.timedOut is not None:
            raise NotBoundedError(f"client {client.client} of {service} can time out and repeat its request")


def slots_of(page: sym.CallbackPage) -> int | None:
    """Return how many goals a callback works on at once, with a thread for each; None if it does not."""
    numbers = slots(page)
    return sum(numbers) if numbers and works_on_goals(page) and holds_thread(page) else None
