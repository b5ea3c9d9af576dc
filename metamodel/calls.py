"""Services that call each other, and actions: server pages with ports of their own, and their instances.

A server page exists once per server instance, and so do the clients and the publishers' places on it. A
service that declares no number of instances has one for each client, so its callers are counted before it.
An action has slots for goals in the same way; no server page has clients of actions.

>>> from dineros.metamodel import sym
>>> instance_counts(sym.SystemModel(id="empty"))
{}
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from graphlib import CycleError, TopologicalSorter
from typing import TypeAlias

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.elements import channels, node_net_of
from dineros.metamodel.errors import DinerosError

Served: TypeAlias = sym.ServiceChannel | sym.ActionChannel
"""What has a server, whose page exists once per instance or slot."""

OUTCOMES = ("succeeded", "aborted", "canceled")
"""How a goal ends that was accepted; servers and clients have a place for each of them, or none."""
PARTS_OF_GOALS = ("goal", "result", "feedback")
"""Parts of the interface of an action."""
SERVER_PLACES = (*OUTCOMES, "cancel", "feedback")
"""Places that a server may have besides its entry."""
CLIENT_PLACES = (*OUTCOMES, "rejected", "accepted", "cancel", "feedback")
"""Places that a client may have besides that of its goals."""

HISTORY_DEPTH = 10
"""History depth of an action's services: the default of ROS 2, which cannot be changed."""

UNLIMITED = -1
"""Value of `outstanding` of a client that has any number of requests under way."""


class CallCircleError(DinerosError):
    """Services call each other in a circle, and none of them specifies its number of instances."""


def services(model: pn.Net) -> list[sym.ServiceChannel]:
    """Return the service channels of a model, in model order; those that lack a server are left out."""
    return [each for each in channels(model, sym.ServiceChannel) if _has_server(each)]


def actions(model: pn.Net) -> list[sym.ActionChannel]:
    """Return the action channels of a model, in model order; those that lack a server are left out."""
    return [each for each in channels(model, sym.ActionChannel) if _has_server(each)]


def _has_server(channel: Served) -> bool:
    return getattr(channel.server, "page", None) is not None


def server_pages(model: pn.Net) -> dict[pn.Page, Served]:
    """Return the service or the action of each server page."""
    served: list[Served] = [*actions(model), *services(model)]
    return {channel.server.page: channel for channel in served}


def serving(element: EObject | None, pages: dict[pn.Page, Served]) -> Served | None:
    """Return what an element's server page serves; `pages` are those of `server_pages`."""
    holder = element
    while holder is not None and holder not in pages:
        holder = holder.eContainer()
    return pages[holder] if isinstance(holder, pn.Page) else None


def callers(channel: sym.ServiceChannel, pages: dict[pn.Page, Served]) -> list[sym.ServiceChannel]:
    """Return the services whose server pages have a client of this one, each once."""
    found = (serving(client.request, pages) for client in channel.clients)
    return list(dict.fromkeys(caller for caller in found if isinstance(caller, sym.ServiceChannel)))


def callers_first(model: pn.Net) -> list[sym.ServiceChannel]:
    """Return the services in an order in which the number of instances of each can be computed.

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
            hint="set the number of instances of one of them",
        ) from None


def instance_counts(model: pn.Net) -> dict[Served, int]:
    """Return how many server instances each service has, and how many slots each action.

    That is what it declares, else one for each client.

    A client on a server page counts once for each instance of that page.

    Raises
    ------
    CallCircleError
        Services call each other in a circle, and none of it declares a number.
    """
    pages = server_pages(model)
    counts: dict[Served, int] = {
        action: len(action.clients) if action.instances is None else action.instances
        for action in actions(model)
    }
    for channel in callers_first(model):
        if channel.instances is not None:
            counts[channel] = channel.instances
            continue
        served = [serving(client.request, pages) for client in channel.clients]
        counts[channel] = sum(1 if caller is None else counts[caller] for caller in served)
    return counts


def gives_up(channel: sym.ServiceChannel) -> bool:
    """Return whether a client of a service has a time-out."""
    return any(client.timeout is not None for client in channel.clients)


def sends_once(client: sym.ClientPort) -> bool:
    """Return whether a client sends each request once, as rclpy does.

    Nodes that run our engine send a request again until it is answered, so that it outlives its server.
    """
    node = node_net_of(client.request)
    return node is not None and node.execution == sym.Execution.callbacks


def may_be_deserted(channel: sym.ServiceChannel, server: sym.NodeNet | None) -> bool:
    """Return whether a service has clients that send each request once, and its server is a managed node.

    Such a request is lost while the server is not there.

    Parameters
    ----------
    channel : sym.ServiceChannel
        The service; `clients` has those of all instances.
    server : sym.NodeNet or None
        The node net of its server.
    """
    is_managed = server is not None and server.lifecycle is not None
    return is_managed and any(sends_once(client) for client in channel.clients)


def may_leave(channel: sym.ServiceChannel, server: sym.NodeNet | None) -> bool:
    """Return whether such a server may also be cleaned up or shut down, with requests that it has."""
    life = None if server is None else server.lifecycle
    return life is not None and (life.cleansUp or life.shutsDown) and may_be_deserted(channel, server)


def loses_requests(channel: sym.ServiceChannel) -> bool:
    """Return whether more requests may wait for a service than it keeps; `clients` has all instances.

    A client that gives up may ask again while its former requests still wait. Each client says how many
    requests it has under way (`dineros.metamodel.callbacks.waiting`).
    """
    asked = [client.outstanding or 1 for client in channel.clients]
    return gives_up(channel) or UNLIMITED in asked or sum(asked) > channel.depth


def copy_id(channel: str, instance: int, id: str) -> str:
    """Return the id that an element of a server page, or a client on it, has in a server instance."""
    return f"{channel}[{instance}].{id}"


def exits(server: sym.ActionServerPort | rtm.ActionServerPort) -> dict[pn.Place, str]:
    """Return the outcome that each place of a server stands for where a goal ends."""
    places = ((getattr(server, outcome), outcome) for outcome in OUTCOMES)
    return {place: outcome for place, outcome in places if place is not None}


def answers(client: sym.ActionClientPort | rtm.ActionClientPort) -> list[pn.Place]:
    """Return the places of a client where it learns that a goal is over, or was refused."""
    places = (getattr(client, role) for role in (*OUTCOMES, "rejected"))
    return [place for place in places if place is not None]


def goal_parts(channel: sym.ActionChannel) -> dict[str, list[pn.Place]]:
    """Return the places whose tokens each part of an action's interface carries, the server's first."""
    server: sym.ActionServerPort | None = channel.server
    ends: list[tuple[_Port, pn.Place | None]] = []
    if server is not None:
        ends.append((server, server.entry))
    ends.extend((client, client.goal) for client in channel.clients)
    return _parts(ends)


def runtime_goal_parts(port: rtm.ActionServerPort | rtm.ActionClientPort) -> dict[str, list[pn.Place]]:
    """Return the same of one port of a runtime model."""
    own = port.eContainer()
    return _parts([(port, own if isinstance(own, pn.Place) else None)])


_Port: TypeAlias = sym.ActionServerPort | sym.ActionClientPort | rtm.ActionServerPort | rtm.ActionClientPort


def _parts(ends: Iterable[tuple[_Port, pn.Place | None]]) -> dict[str, list[pn.Place]]:
    found = {
        "goal": [own for _, own in ends],
        "result": [getattr(port, outcome) for port, _ in ends for outcome in OUTCOMES],
        "feedback": [port.feedback for port, _ in ends],
    }
    return {part: [place for place in places if place is not None] for part, places in found.items()}


def action_places(channel: sym.ActionChannel) -> Iterator[pn.Place]:
    """Yield the places of all ports of an action."""
    server: sym.ActionServerPort | None = channel.server
    if server is not None:
        places = (server.entry, *(getattr(server, role) for role in SERVER_PLACES))
        yield from (place for place in places if place is not None)
    for client in channel.clients:
        places = (client.goal, *(getattr(client, role) for role in CLIENT_PLACES))
        yield from (place for place in places if place is not None)
