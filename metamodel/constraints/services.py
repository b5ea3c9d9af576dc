"""Service channels: servers, their pages and instances, and clients (paper, Sect. 5.3.2)."""

from __future__ import annotations

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.constraints.wording import describe, listed

_PAGE_FIX = "put the server's entry and exit on a page of their own inside a node net"


def _client_id(port: sym.ClientPort) -> tuple[sym.ServiceChannel | None, str]:
    return (port.channel, port.client)


@constraint("{it} has no client", fix="add a client port", severity="warning")
def service_has_client(channel: sym.ServiceChannel, index: Index) -> Outcome:
    """Somebody calls a service."""
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
    """Entry and exit of a server stand on its server page."""
    outside = [place for place in (port.entry, port.exit) if not _contains(port.page, place)]
    return not outside or listed(outside)


def _contains(page: pn.Page, place: pn.Place) -> bool:
    holder = place.page
    while holder is not None and holder is not page:
        holder = holder.page
    return holder is page


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


@constraint("{it} has a server page inside {found}, which is one too", fix="put the pages beside each other")
def server_page_not_nested(port: sym.ServerPort, index: Index) -> Outcome:
    """A server page stands on no other server page."""
    outer = index.server_page_of(port.page.page) if port.page.page is not None else None
    return outer is None or describe(outer)


@constraint("{it} has its request in {found}", fix="put both places into the node net of the client")
def client_in_one_node_net(port: sym.ClientPort, index: Index) -> Outcome:
    """Request and response of a client belong to the same node net."""
    request, response = index.node_net_of(port.request), index.node_net_of(port.response)
    if request is not None and request is response:
        return True
    places = [describe(node_net) if node_net else "no node net" for node_net in (request, response)]
    return f"{places[0]} and its response in {places[1]}"


@constraint("{it} has {found} for requests and responses", fix="use two places")
def client_request_is_not_response(port: sym.ClientPort, index: Index) -> Outcome:
    """Request and response of a client are two places."""
    return port.request is not port.response or describe(port.request)


@constraint("{it} has the id of another client of the service", fix="give it another client id")
def client_unique(port: sym.ClientPort, index: Index) -> Outcome:
    """The clients of a service have different ids."""
    return index.earliest(port, sym.ClientPort, _client_id) is port


@constraint(
    "{it} calls the service from its own server page {found}",
    fix="put the client on another page: this one is copied for every server instance",
)
def service_does_not_call_itself(port: sym.ClientPort, index: Index) -> Outcome:
    """A service does not call itself."""
    channel = port.channel
    if channel is None or not index.incomplete.isdisjoint([channel, channel.server]):
        return True
    page = channel.server.page
    inside = any(index.server_page_of(place) is page for place in (port.request, port.response))
    return not inside or repr(page.id)


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
    "{it} lets all server instances share {found}, which then needs and serves all of them at once",
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
    outside = [place for place in (entry, port.exit) if not _contains(port.page, place)]
    return not outside or f"{listed(outside)} outside of its server page {port.page.id!r}"
