"""Services that call each other: server pages with ports of their own, and how many instances there are.

A server page exists once per server instance, and so do the clients and the publishers' places on it. A
service that declares no number of instances has one for each client, so its callers are counted before it.

>>> from dineros.metamodel import sym
>>> instance_counts(sym.SystemModel(id="empty"))
{}
"""

from __future__ import annotations

from graphlib import CycleError, TopologicalSorter

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.errors import DinerosError


class CallCircleError(DinerosError):
    """Services call each other in a circle, and none of them says how many instances it has."""


def services(model: pn.Net) -> list[sym.ServiceChannel]:
    """Return the service channels of a model, in model order; those that lack a server are left out."""
    channels = model.channels if isinstance(model, sym.SystemModel) else ()
    return [
        channel
        for channel in channels
        if isinstance(channel, sym.ServiceChannel) and getattr(channel.server, "page", None) is not None
    ]


def server_pages(model: pn.Net) -> dict[pn.Page, sym.ServiceChannel]:
    """Return the service of each server page."""
    return {channel.server.page: channel for channel in services(model)}


def serving(element: EObject | None, pages: dict[pn.Page, sym.ServiceChannel]) -> sym.ServiceChannel | None:
    """Return the service whose server page an element stands on; `pages` are those of `server_pages`."""
    holder = element
    while holder is not None and holder not in pages:
        holder = holder.eContainer()
    return pages[holder] if isinstance(holder, pn.Page) else None


def callers(
    channel: sym.ServiceChannel, pages: dict[pn.Page, sym.ServiceChannel]
) -> list[sym.ServiceChannel]:
    """Return the services whose server pages have a client of this one, each once."""
    found = (serving(client.request, pages) for client in channel.clients)
    return list(dict.fromkeys(caller for caller in found if caller is not None))


def callers_first(model: pn.Net) -> list[sym.ServiceChannel]:
    """Return the services in an order in which the number of instances of each can be told.

    Raises
    ------
    CallCircleError
        They call each other in a circle, and none of it declares a number.
    """
    pages = server_pages(model)
    order = {
        channel: callers(channel, pages) if channel.instances is None else [] for channel in services(model)
    }
    try:
        return list(TopologicalSorter(order).static_order())
    except CycleError as error:
        circle = error.args[1]
        raise CallCircleError(
            f"services call each other in a circle: {' -> '.join(each.id for each in circle)}",
            element=circle[0].id,
            hint="say how many instances one of them has",
        ) from None


def instance_counts(model: pn.Net) -> dict[sym.ServiceChannel, int]:
    """Return how many server instances each service has: what it declares, else one for each client.

    A client on a server page counts once for each instance of that page.

    Raises
    ------
    CallCircleError
        Services call each other in a circle, and none of it declares a number.
    """
    pages = server_pages(model)
    counts: dict[sym.ServiceChannel, int] = {}
    for channel in callers_first(model):
        if channel.instances is not None:
            counts[channel] = channel.instances
            continue
        served = [serving(client.request, pages) for client in channel.clients]
        counts[channel] = sum(1 if caller is None else counts[caller] for caller in served)
    return counts


def gives_up(channel: sym.ServiceChannel) -> bool:
    """Tell whether a client of a service has a time-out."""
    return any(client.timeout is not None for client in channel.clients)


def loses_requests(channel: sym.ServiceChannel) -> bool:
    """Tell whether more requests may wait for a service than it keeps; `clients` has those of all instances.

    A client that gives up may ask again while its former requests still wait.
    """
    return gives_up(channel) or sum(client.outstanding for client in channel.clients) > channel.depth


def copy_id(channel: str, instance: int, id: str) -> str:
    """Return the id that an element of a server page, or a client on it, has in a server instance."""
    return f"{channel}[{instance}].{id}"
