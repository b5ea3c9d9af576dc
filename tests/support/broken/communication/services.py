"""Models that break the constraints of `services`."""

from __future__ import annotations

from dineros.metamodel import pn, rtm, sym
from tests.support.broken.cases import Cases
from tests.support.broken.small import Small, runtime

CASES = Cases()


@CASES.breaks(
    "service-has-client",
    "service channel 'ask' has no client",
    "add a client port",
)
def no_client(small: Small) -> None:
    small["ask"].clients.clear()


@CASES.breaks(
    "service-instances",
    "service channel 'ask' has 0 instances",
    "give it 1 instance or more, or none to have one for each client",
)
def no_instance(small: Small) -> None:
    small["ask"].instances = 0


@CASES.breaks(
    "server-places-on-page",
    "server port of service channel 'ask' has place 'Count' outside of its server page 'serve'",
    "move the place to that page",
)
def exit_elsewhere(small: Small) -> None:
    small["ask"].server.exit = small["Count"]


@CASES.breaks(
    "server-entry-is-not-exit",
    "server port of service channel 'ask' has place 'Entry' as entry and exit",
    "use two places with a transition between them",
)
def one_place(small: Small) -> None:
    small["ask"].server.exit = small["Entry"]


@CASES.breaks(
    "server-page-in-node-net",
    "server port of service channel 'ask' has a server page that is all of node net 'server'",
    "put the server's entry and exit on a page of their own inside a node net",
)
def whole_node_net(small: Small) -> None:
    server = small["ask"].server
    small["serve"].kind = "timer"
    small["serve"].timer = 1.0
    net = sym.NodeNet(id="server", net=small.net)
    server.entry, server.exit = sym.Place(id="Entry2", page=net), sym.Place(id="Exit2", page=net)
    server.page = net


@CASES.breaks(
    "server-page-not-shared",
    "server port of service channel 'other' shares its server page with server port of service channel 'ask'",
    "give each service a server page of its own",
)
def two_services(small: Small) -> None:
    request, response = (
        sym.Place(id="Ask2", page=small["talker"]),
        sym.Place(id="Answer2", page=small["talker"]),
    )
    sym.ServiceChannel(
        id="other",
        service="/other",
        server=sym.ServerPort(
            entry=sym.Place(id="Entry2", page=small["serve"]),
            exit=sym.Place(id="Exit2", page=small["serve"]),
            page=small["serve"],
        ),
        clients=[sym.ClientPort(client="c1", request=request, response=response)],
        model=small.net,
    )


@CASES.breaks(
    "server-page-not-nested",
    "server port of service channel 'other' has a server page inside callback page 'serve', which is one too",
    "put the pages side by side",
)
def page_in_page(small: Small) -> None:
    page = pn.Page(id="inner", page=small["serve"])
    request, response = (
        sym.Place(id="Ask2", page=small["talker"]),
        sym.Place(id="Answer2", page=small["talker"]),
    )
    sym.ServiceChannel(
        id="other",
        service="/other",
        server=sym.ServerPort(
            entry=sym.Place(id="Entry2", page=page), exit=sym.Place(id="Exit2", page=page), page=page
        ),
        clients=[sym.ClientPort(client="c1", request=request, response=response)],
        model=small.net,
    )


@CASES.breaks(
    "client-in-one-node-net",
    "client port 'c1' of service channel 'ask' has its request in node net 'talker' and its "
    "response in node net 'listener'",
    "put both places into the node net of the client",
)
def response_elsewhere(small: Small) -> None:
    small["ask"].clients[0].response = small["Count"]


@CASES.breaks(
    "client-request-is-not-response",
    "client port 'c1' of service channel 'ask' has place 'Ask' for requests and responses",
    "use two places",
)
def one_place_2(small: Small) -> None:
    small["ask"].clients[0].response = small["Ask"]


@CASES.breaks(
    "client-unique",
    "client port 'c1' of service channel 'ask' has the id of another client of the service",
    "give it another client id",
)
def same_id(small: Small) -> None:
    request, response = (
        sym.Place(id="Ask2", page=small["talker"]),
        sym.Place(id="Answer2", page=small["talker"]),
    )
    small["ask"].clients.append(sym.ClientPort(client="c1", request=request, response=response))


@CASES.breaks(
    "client-unique",
    "client port 'ask[2].cserve' of service channel 'other' has the id of another client of the service",
    "give it another client id",
)
def same_id_as_an_instance(small: Small) -> None:
    channel = _other(small)
    _call(small, channel, small["serve"])
    _call(small, channel, small["listener"])
    channel.clients[1].client = "ask[2].cserve"


@CASES.breaks(
    "service-circle-has-instances",
    "service channel 'ask' is one of services that call each other in a circle, and each would have an "
    "instance for every client: ask -> ask",
    "set the number of instances of one of them",
)
def client_on_the_server_page(small: Small) -> None:
    small["ask"].instances = None
    _call(small, small["ask"], small["serve"])


@CASES.breaks(
    "service-circle-has-instances",
    "service channel 'ask' is one of services that call each other in a circle, and each would have an "
    "instance for every client: ask -> other -> ask",
    "set the number of instances of one of them",
)
def two_services_in_a_circle(small: Small) -> None:
    small["ask"].instances = None
    _call(small, _other(small), small["serve"])
    _call(small, small["ask"], small["also"])


def _other(small: Small) -> sym.ServiceChannel:
    """Add a second service to the talker."""
    page = sym.CallbackPage(id="also", kind="server", page=small["talker"])
    places = [sym.Place(id=f"{id}2", page=page) for id in ("Entry", "Exit")]
    server = sym.ServerPort(entry=places[0], exit=places[1], page=page)
    return sym.ServiceChannel(id="other", service="/other", server=server, model=small.net)


def _call(small: Small, channel: sym.ServiceChannel, page: pn.Page) -> None:
    """Add a client on a page."""
    places = [sym.Place(id=f"{id}{page.id}", page=page) for id in ("Ask", "Answer")]
    channel.clients.append(sym.ClientPort(client=f"c{page.id}", request=places[0], response=places[1]))


@CASES.breaks(
    "client-in-one-instance",
    "client port 'cserve' of service channel 'other' has its request on the server page 'serve' and its "
    "response outside",
    "put both places on the same server page, or both outside of it",
)
def response_outside(small: Small) -> None:
    channel = _other(small)
    _call(small, channel, small["serve"])
    channel.clients[0].response = sym.Place(id="Away", page=small["listener"])


@CASES.breaks(
    "runtime-client",
    "client port 'c1' of place 'Ask' has its request outside and its response on the server page 'serve'",
    "put both places on the same server page, or both outside of it",
    of=runtime,
)
def response_inside(small: Small) -> None:
    small["Ask"].ports[0].response = rtm.Place(id="Inside", page=small["serve"])


@CASES.breaks(
    "client-not-shared-by-instances",
    "client port 'clistener' of service channel 'other' puts its responses on a place that all instances of "
    "the server page 'serve' share: one instance may take the response to another",
    "put its request and response on the server page: each instance then has its own",
)
def shared_client(small: Small) -> None:
    channel = _other(small)
    _call(small, channel, small["listener"])
    for place in (channel.clients[0].request, channel.clients[0].response):
        pn.ReferencePlace(id=f"{place.id}Here", target=place, page=small["serve"])


@CASES.breaks(
    "server-page-closed",
    "reference place 'EntryThere' refers to place 'Entry', which exists once per server instance",
    "move that out of the server page and refer to it from there",
)
def reference_from_outside(small: Small) -> None:
    pn.ReferencePlace(id="EntryThere", target=small["Entry"], page=small["listener"])


@CASES.breaks(
    "server-shares-places-only",
    "reference transition 'CloseHere' lets all server instances share transition 'Close', which "
    "then needs and serves all instances at once",
    "put the transition on the server page and share places only",
)
def reference_transition(small: Small) -> None:
    sym.Transition(id="Close", page=small["listener"])
    pn.ReferenceTransition(id="CloseHere", target=small["Close"], page=small["serve"])


@CASES.breaks(
    "runtime-server",
    "server port '/serve' of place 'Entry' has 0 instances",
    "use an entry and an exit on the server page and 1 instance or more",
    of=runtime,
)
def no_instance_2(small: Small) -> None:
    small["Entry"].ports[0].instances = 0


@CASES.breaks(
    "runtime-server",
    "server port '/serve' of place 'Entry' has place 'Away' outside of its server page 'serve'",
    "use an entry and an exit on the server page and 1 instance or more",
    of=runtime,
)
def exit_elsewhere_2(small: Small) -> None:
    small["Entry"].ports[0].exit = rtm.Place(id="Away", page=small["talker"])


@CASES.breaks(
    "runtime-server",
    "server port '/serve' of place 'Entry' has place 'Entry' as entry and exit",
    "use an entry and an exit on the server page and 1 instance or more",
    of=runtime,
)
def one_place_3(small: Small) -> None:
    small["Entry"].ports[0].exit = small["Entry"]


@CASES.breaks(
    "server-page-in-node-net",
    "server port of service channel 'ask' has a server page outside of all node nets",
    "put the server's entry and exit on a page of their own inside a node net",
)
def page_outside_of_node_nets(small: Small) -> None:
    page = pn.Page(id="outside", net=small.net)
    server = small["ask"].server
    server.entry, server.exit = sym.Place(id="Entry2", page=page), sym.Place(id="Exit2", page=page)
    server.page = page
    small["serve"].kind = "timer"
    small["serve"].timer = 1.0
