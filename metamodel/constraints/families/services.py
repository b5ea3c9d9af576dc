"""Service channels: servers, their pages and instances, and clients (paper, Sect. 5.3.2)."""

from __future__ import annotations

import re

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.constraints.circles import circles_of
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.constraints.wording import describe, listed
from dineros.metamodel.elements import is_within

_INSTANCE = re.compile(r"(.+)\[[1-9][0-9]*\]\.(.+)", re.DOTALL)
IN_ONE_INSTANCE = "put both places on the same server page, or both outside of it"
_PAGE_FIX = "put the server's entry and exit on a page of their own inside a node net"


def _client_id(port: sym.ClientPort) -> tuple[sym.ServiceChannel | None, str]:
    return (port.channel, port.client)


@constraint("{it} has no client", fix="add a client port", severity="warning")
def service_has_client(channel: sym.ServiceChannel, index: Index) -> Outcome:
    """A service has a client."""
    return len(channel.clients) > 0


@constraint(
    "{it} has {element.instances} instances",
    fix="give it 1 instance or more, or none to have one for each client",
    guard=lambda channel, index: channel.instances is not None,
)
def service_instances(channel: sym.ServiceChannel, index: Index) -> Outcome:
    """A service has 1 server instance or more."""
    return channel.instances is not None and channel.instances >= 1


@constraint(
    "{it} has {found} outside of its server page {element.page.id!r}", fix="move the place to that page"
)
def server_places_on_page(port: sym.ServerPort, index: Index) -> Outcome:
    """Entry and exit of a server are on its server page."""
    outside = [place for place in (port.entry, port.exit) if not is_within(place, port.page)]
    return not outside or listed(outside)


@constraint("{it} has {found} as entry and exit", fix="use two places with a transition between them")
def server_entry_is_not_exit(port: sym.ServerPort, index: Index) -> Outcome:
    """Entry and exit of a server are two places."""
    return port.entry is not port.exit or describe(port.entry)


@constraint("{it} has a server page {found}", fix=_PAGE_FIX)
def server_page_in_node_net(port: sym.ServerPort, index: Index) -> Outcome:
    """A server page is a page inside a node net, not the whole of it."""
    if isinstance(port.page, sym.NodeNet):
        return f"that is all of {describe(port.page)}"
    return index.node_net_of(port.page) is not None or "outside of all node nets"


@constraint("{it} shares its server page with {found}", fix="give each service a server page of its own")
def server_page_not_shared(port: sym.ServerPort, index: Index) -> Outcome:
    """A server page serves one service."""
    first = index.server_pages[port.page][0]
    return first is port or describe(first)


@constraint("{it} has a server page inside {found}, which is one too", fix="put the pages side by side")
def server_page_not_nested(port: sym.ServerPort, index: Index) -> Outcome:
    """A server page is not inside another server page."""
    outer = index.server_page_of(port.page.page) if port.page.page is not None else None
    return outer is None or describe(outer)


@constraint("{it} has its request in {found}", fix="put both places into the node net of the client")
def client_in_one_node_net(port: sym.ClientPort, index: Index) -> Outcome:
    """Request and response of a client belong to the same node net."""
    request, response = index.node_net_of(port.request), index.node_net_of(port.response)
    if request is not None and request is response:
        return True
    return in_two_node_nets(request, response, "its response")


def in_one_node_net(place: EObject, other: EObject, index: Index, what: str) -> Outcome:
    """Return whether two places of a port are in one node net; if not, where both are."""
    first, second = index.node_net_of(place), index.node_net_of(other)
    return first is second or in_two_node_nets(first, second, what)


def in_two_node_nets(asking: sym.NodeNet | None, other: sym.NodeNet | None, what: str) -> str:
    """Name the node nets of two places of a port."""
    first, second = (describe(net) if net else "no node net" for net in (asking, other))
    return f"{first} and {what} in {second}"


@constraint("{it} has {found} for requests and responses", fix="use two places")
def client_request_is_not_response(port: sym.ClientPort, index: Index) -> Outcome:
    """Request and response of a client are two places."""
    return port.request is not port.response or describe(port.request)


@constraint("{it} has the id of another client of the service", fix="give it another client id")
def client_unique(port: sym.ClientPort, index: Index) -> Outcome:
    """The clients of a service have different ids, those of server instances included."""
    if index.earliest(port, sym.ClientPort, _client_id) is not port:
        return False
    found = _INSTANCE.fullmatch(port.client)
    return found is None or (port.channel, *found.groups()) not in index.once(
        "clients of instances", lambda: _clients_of_instances(index)
    )


def _clients_of_instances(index: Index) -> set[tuple[sym.ServiceChannel | None, str, str]]:
    """Return the clients on server pages: the service they call, the one they are in, and their id."""
    found = set()
    for port in index.all(sym.ClientPort):
        page = index.server_page_of(port.request)
        caller = index.server_pages[page][0].eContainer() if page is not None else None
        if isinstance(caller, sym.ServiceChannel):
            found.add((port.channel, caller.id, port.client))
    return found


@constraint("{it} has its request {found}", fix=IN_ONE_INSTANCE)
def client_in_one_instance(port: sym.ClientPort, index: Index) -> Outcome:
    """An answer comes back to the server instance that asked."""
    return in_one_instance(port.request, port.response, index)


@constraint("{it} has its request {found}", fix=IN_ONE_INSTANCE)
def runtime_client(port: rtm.ClientPort, index: Index) -> Outcome:
    """In a run-time model, too, an answer comes back to the server instance that asked."""
    place = port.eContainer()
    return not isinstance(place, pn.Place) or in_one_instance(place, port.response, index)


def in_one_instance(request: pn.Place, other: pn.Place, index: Index, what: str = "its response") -> Outcome:
    """Return whether a client's requests and another place of it are on the same server page, or on none."""
    pages = [index.server_page_of(place) for place in (request, other)]
    if pages[0] is pages[1]:
        return True
    first, second = (f"on the server page {page.id!r}" if page else "outside" for page in pages)
    return f"{first} and {what} {second}"


@constraint(
    "{it} is one of services that call each other in a circle, and each would have an instance for every "
    "client: {found}",
    fix="set the number of instances of one of them",
    guard=lambda channel, index: channel.instances is None,
)
def service_circle_has_instances(channel: sym.ServiceChannel, index: Index) -> Outcome:
    """If services call each other in a circle, one of them specifies its number of instances."""
    return index.once("circles of services", lambda: _service_circles(index)).get(channel, True)


def _service_circles(index: Index) -> dict[sym.ServiceChannel, str]:
    return circles_of({channel: _counted_before(index, channel) for channel in index.all(sym.ServiceChannel)})


def _counted_before(index: Index, channel: sym.ServiceChannel) -> list[sym.ServiceChannel]:
    """Return the services whose instances are clients of one that has an instance for each client."""
    if channel.instances is not None:
        return []
    ports = (port for port in channel.clients if port not in index.incomplete)
    pages = (index.server_page_of(port.request) for port in ports)
    found = [index.server_pages[page][0].eContainer() for page in pages if page is not None]
    return [caller for caller in found if isinstance(caller, sym.ServiceChannel)]


@constraint(
    "{it} puts its responses on a place that all instances of the server page {found} share: one instance "
    "may take the response to another",
    fix="put its request and response on the server page: each instance then has its own",
    severity="warning",
)
def client_not_shared_by_instances(port: sym.ClientPort, index: Index) -> Outcome:
    """Server instances that call a service do not share the places of the call."""
    asking, answered = (_instances_at(place, index) for place in (port.request, port.response))
    shared = next((page for page in asking if page in answered), None)
    return shared is None or repr(shared.id)


def _instances_at(place: pn.Place, index: Index) -> list[pn.Page]:
    """Return the server pages of several instances that refer to a place outside of them."""
    return index.once("pages of instances that share a place", lambda: _sharing(index)).get(place, [])


def _sharing(index: Index) -> dict[pn.Node, list[pn.Page]]:
    found: dict[pn.Node, list[pn.Page]] = {}
    for reference in index.all(pn.ReferencePlace):
        page, target = index.server_page_of(reference), index.final(reference)
        if page is None or target is None or index.server_page_of(target) is page:
            continue
        channel = index.server_pages[page][0].eContainer()
        if isinstance(channel, sym.ServiceChannel) and _has_several_instances(channel, index):
            found.setdefault(target, []).append(page)
    return found


def _has_several_instances(channel: sym.ServiceChannel, index: Index) -> bool:
    if channel.instances is not None:
        return channel.instances > 1
    return len(channel.clients) > 1 or len(_counted_before(index, channel)) > 0


@constraint(
    "{it} refers to {found}, which exists once per server instance",
    fix="move that out of the server page and refer to it from there",
    guard=lambda node, index: isinstance(node, (pn.ReferencePlace, pn.ReferenceTransition)),
)
def server_page_closed(node: pn.Node, index: Index) -> Outcome:
    """Nothing outside of a server page refers to what is on it."""
    assert isinstance(node, (pn.ReferencePlace, pn.ReferenceTransition))
    page = index.server_page_of(node.target)
    return page is None or index.server_page_of(node) is page or describe(node.target)


@constraint(
    "{it} lets all server instances share {found}, which then needs and serves all instances at once",
    fix="put the transition on the server page and share places only",
    severity="warning",
    guard=lambda node, index: index.server_page_of(node) is not None,
)
def server_shares_places_only(node: pn.ReferenceTransition, index: Index) -> Outcome:
    """A server page reaches places outside of it by references, not transitions."""
    return index.server_page_of(node.target) is index.server_page_of(node) or describe(node.target)


@constraint("{it} has {found}", fix="use an entry and an exit on the server page and 1 instance or more")
def runtime_server(port: rtm.ServerPort, index: Index) -> Outcome:
    """A server of a run-time model has an entry and an exit on its server page, and 1 instance or more."""
    if port.instances < 1:
        return f"{port.instances} instances"
    entry = port.eContainer()
    assert isinstance(entry, rtm.Place)
    if entry is port.exit:
        return f"{describe(entry)} as entry and exit"
    outside = [place for place in (entry, port.exit) if not is_within(place, port.page)]
    return not outside or f"{listed(outside)} outside of its server page {port.page.id!r}"
