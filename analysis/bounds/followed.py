"""Which callbacks bounds follow, why not others, and how many requests and goals are under way at once."""

from __future__ import annotations

from collections.abc import Iterable

from dineros.analysis.bounds.work import NotBoundedError
from dineros.metamodel import sym
from dineros.metamodel.callbacks.groups import callback_page_of, holds_thread, runs_callbacks, works_on_goals
from dineros.metamodel.callbacks.under_way import outstanding_counts
from dineros.metamodel.calls import UNLIMITED
from dineros.metamodel.elements import channels, label, node_net_of
from dineros.metamodel.times.given import runs_at_once
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


_COPIED = {sym.CallbackKind.server, sym.CallbackKind.goal}
"""Callbacks of which each instance and each slot has a copy."""


class Requests:
    """How many requests clients have under way at once, all runs and copies of their callbacks together.

    Runs of a callback in a reentrant group overlap, and each waits for the response to its own request. The
    page of a goal has a copy for each slot, and that of a server one for each instance.

    Parameters
    ----------
    model : sym.SystemModel
    """

    def __init__(self, model: sym.SystemModel) -> None:
        self._model = model
        self._counts = outstanding_counts(model, runs_overlap=True)
        self._counted: set[sym.ServiceChannel] = set()

    def of(self, client: sym.ClientPort) -> int | None:
        """Return how many requests of a client are under way at most; None without a limit."""
        number, page = self._counts[client], callback_page_of(client.request)
        copies = 1 if page is None else self._copies_of(page)
        return None if number == UNLIMITED or copies is None else number * max(1, copies)

    def all_of(self, clients: Iterable[sym.ClientPort]) -> int | None:
        """Return the sum for some clients."""
        return _sum(map(self.of, clients))

    def _copies_of(self, page: sym.CallbackPage) -> int | None:
        """Return how many copies of a callback can wait for responses at once; None without a limit."""
        if page.kind == sym.CallbackKind.goal:
            numbers = slots(page)
            return None if numbers is None else max(1, sum(numbers))
        is_one = runs_callbacks(node_net_of(page)) and runs_at_once(page) == 1 and not page.awaits
        if page.kind != sym.CallbackKind.server or is_one:
            return 1
        services = [each for each in channels(self._model, sym.ServiceChannel) if each.server.page is page]
        return _sum(map(self._instances, services)) if services else 1

    def _instances(self, service: sym.ServiceChannel) -> int | None:
        """Return how many instances a server has: by default one for each client, and each of its copies."""
        if service.instances is not None or service in self._counted:
            return service.instances
        self._counted.add(service)
        pages = [callback_page_of(each.request) for each in service.clients]
        found = _sum(1 if each is None else self._copies_of(each) for each in pages)
        self._counted.remove(service)
        return found


def _sum(numbers: Iterable[int | None]) -> int | None:
    """Return the sum of some numbers; None if one is not known."""
    found = list(numbers)
    known = [each for each in found if each is not None]
    return sum(known) if len(known) == len(found) else None
