"""Requests to managed nodes whose server may be absent (rules L6 and L7).

rclpy sends a request once. A request is lost if it is sent while its server is not configured. A request in
the server's history or in an instance is lost when the server is cleaned up or shut down. In both cases, the
client never gets a response (observed with rclpy 7.1.6). A client that calls `wait_for_service` sends no
request meanwhile, but loses the requests that the server has. Nodes that run our engine send a request again
until there is a response.
"""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.metamodel.records import Drop, Transfer
from dineros.transformations.language import Index, Made, Meaning, Node
from dineros.transformations.language.errors import LANGUAGE
from dineros.transformations.rules.clients.requests import R8
from dineros.transformations.rules.lifecycle import L1, Configuring, Leaving
from dineros.transformations.rules.notation import Bound, arc, arcs_at, read, transition
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.requests import (
    HISTORY,
    R5,
    R6,
    MayBeDeserted,
    MayLeave,
    R5Client,
    R6Client,
    R6Late,
    SendsOnce,
)
from dineros.transformations.rules.services import S1, S2, Home, instances

LANGUAGE.add(__name__)


def _lost(part: str, words: str) -> Meaning:
    """Return the meaning of the loss of a client's request, with its reason."""
    return Meaning(
        f"{{client}} of service {{service}} {{waits}}: its request is lost because {words}",
        on_server_page=f"{{client}} {{waits}}: its request to service {{service}} is lost because {words}",
        step=Drop,
        queue="request",
        called=HISTORY,
        part=part,
    )


def _served() -> tuple[Node, Node, Node]:
    """Return a service, the node net of its server, and one of its clients."""
    service = Node(sym.ServiceChannel)
    server = Node(sym.NodeNet, of=Home(service.server.entry))
    return service, server, Node(sym.ClientPort, channel=service)


class L6(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """A request comes to a server that is configured."""

    service, server, client = _served()
    queue = Made(R5Client.queue, of=client)
    configured = Made(L1.configured, of=server)

    waits = [read(configured, queue.enter), read(configured, queue.drop)]

    where = [MayBeDeserted(service, server)]


class L6Instead(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """A request that replaces another one in a full history comes to a server that is configured, too."""

    service, server, client = _served()
    instead = Made(R6Client.instead, of=client)
    configured = Made(L1.configured, of=server)

    waits = read(configured, instead)

    where = [MayBeDeserted(service, server)]


class L6Miss(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """A request that a client sends only once is lost while the server is absent."""

    service, server, client = _served()
    sent = Made(R5Client.sent, of=client)
    lost = Made(R5Client.lost, of=client)
    away = Made(L1.away, of=server)

    miss = transition(
        "{service.id}.client.{client.client}.miss", means=_lost("miss", "node net {serving} is not there")
    )
    arcs = [arc(sent, miss), arc(miss, lost), read(away, miss)]

    where = [MayBeDeserted(service, server), SendsOnce(client)]


class L6Settled(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """A server leaves only after all requests that were sent while it was there are in its history."""

    service, server, client = _served()
    sent = Made(R5Client.sent, of=client)

    bound = Bound(
        sent,
        client.outstanding,
        means=Meaning("{client} of service {service} has no arriving request", rests=True),
    )

    where = [MayLeave(service, server), SendsOnce(client), client.outstanding > 0]


class L6Leave(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """A server leaves only while no request of a client is arriving."""

    service, server, client = _served()
    bound = Made(L6Settled.bound, of=client)
    change = Made(Leaving, of=server)

    waits = read(bound.free, change.move, weight=client.outstanding)


class L6LeaveFree(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """A server leaves only while no request of a client that does not wait is arriving."""

    service, server, client = _served()
    bound = Made(R8.sending, of=client)
    change = Made(Leaving, of=server)

    waits = read(bound.free, change.move)

    where = [MayLeave(service, server), SendsOnce(client)]


class L6Wait(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """A client that waits for its service sends nothing meanwhile."""

    service = Node(sym.ServiceChannel)
    server = Node(sym.NodeNet, of=Home(service.server.entry))
    client = Node(sym.ClientPort, channel=service, waitsForService=True)
    t_req = Made(S1.t_req, of=client)
    configured = Made(L1.configured, of=server)

    waits = read(configured, t_req)

    where = [SendsOnce(client)]


class L7(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """A request in the history of a server that leaves is lost if its client sends each request once."""

    service, server, client = _served()
    requests = Made(S1.requests, of=client)
    load = Made(R5.load, of=service)
    capacity = Made(R5.capacity, of=service)
    lost = Made(R5Client.lost, of=client)
    away = Made(L1.away, of=server)

    left = transition(
        "{service.id}.client.{client.client}.left",
        means=_lost("left", "node net {serving} is not there any more"),
    )
    arcs = arcs_at(left, [requests, load], [lost, capacity], reads=[away])

    where = [MayLeave(service, server), SendsOnce(client)]


class L7Again(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """A request in the history of a server that leaves is sent again if its client repeats requests."""

    service, server, client = _served()
    requests = Made(S1.requests, of=client)
    load = Made(R5.load, of=service)
    capacity = Made(R5.capacity, of=service)
    sent = Made(R5Client.sent, of=client)
    away = Made(L1.away, of=server)

    again = transition(
        "{service.id}.client.{client.client}.again",
        means=Meaning(
            "{client} sends its request to service {service} again",
            step=Transfer,
            queue="request",
            called=HISTORY,
            part="again",
        ),
    )
    arcs = arcs_at(again, [requests, load], [sent, capacity], reads=[away])

    where = [MayLeave(service, server), ~SendsOnce(client)]


class L7Late(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """A request whose client has given up is discarded when its server leaves."""

    service = Node(sym.ServiceChannel)
    server = Node(sym.NodeNet, of=Home(service.server.entry))
    late = Made(R6.late, of=service)
    load = Made(R5.load, of=service)
    capacity = Made(R5.capacity, of=service)
    away = Made(L1.away, of=server)

    gone = transition(
        "{service.id}.late.gone",
        means=Meaning(
            "the request of a client of service {service} that has given up is discarded with node net "
            "{serving}",
            step=Transfer,
            part="late.gone",
        ),
    )
    arcs = [arc(late, gone), arc(load, gone), arc(gone, capacity), read(away, gone)]

    where = [MayLeave(service, server)]


class L7Unanswered(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """A request that an instance works on when its server leaves is lost if the client sends it only once."""

    service, server, client = _served()
    instance = Index(upto=instances(service))
    in_use = Made(S2.in_use, of=[client, instance])
    late = Made(R6Late.in_use, of=[service, instance])
    lost = Made(R5Client.lost, of=client)
    away = Made(L1.away, of=server)

    unanswered = transition(
        "{service.id}.client.{client.client}.unanswered[{instance}]",
        means=_lost("unanswered", "node net {serving} is gone before it answers"),
    )
    arcs = [arc(in_use, unanswered), arc(unanswered, late), arc(unanswered, lost), read(away, unanswered)]
    bound = Bound(
        in_use,
        1,
        means=Meaning("instance {instance} of service {service} does not work for {client}", rests=True),
    )

    where = [MayLeave(service, server), SendsOnce(client)]


class L7Answered(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """No instance works on a request when the server is configured again."""

    service = Node(sym.ServiceChannel)
    server = Node(sym.NodeNet, of=Home(service.server.entry))
    life = Node(sym.Lifecycle, of=server.lifecycle, cleansUp=True)
    client = Node(sym.ClientPort, channel=service)
    instance = Index(upto=instances(service))
    bound = Made(L7Unanswered.bound, of=[client, instance])
    change = Made(Configuring, of=server)

    waits = read(bound.free, change.move)


class L7Emptied(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """The request history of a server is empty when the server is configured again."""

    service = Node(sym.ServiceChannel)
    server = Node(sym.NodeNet, of=Home(service.server.entry))
    life = Node(sym.Lifecycle, of=server.lifecycle, cleansUp=True)
    capacity = Made(R5.capacity, of=service)
    change = Made(Configuring, of=server)

    waits = read(capacity, change.move, weight=service.depth)

    where = [MayLeave(service, server)]
