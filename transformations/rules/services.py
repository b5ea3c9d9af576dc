"""Services: server instances and the clients' calls (rules S1 to S4; paper, Fig. 10).

S4 runs for one service after the other, callers first: a client on a server page becomes one client per
instance (S4-client). So a response returns to the instance that sent the request, and the called service
counts all these clients.
"""

from __future__ import annotations

from collections.abc import Mapping

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.elements import node_net_of
from dineros.metamodel.records import Reply, Request, Response, Serve
from dineros.transformations.language import Copy, Expression, Fragment, Match, Meaning, New, image
from dineros.transformations.language.creation import IMAGES
from dineros.transformations.language.functions import count, either, enclosing, greatest
from dineros.transformations.language.patterns import Index, Made, Node, Pattern
from dineros.transformations.rules.notation import arcs_at, place, service_with_client, transition
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.message_times import CallLatency


def instances(service: Node) -> Expression:
    """Return the number of server instances: by default one per client."""
    return either(service.instances, count(service.clients))


class Serving(Fragment):
    """An instance takes a request: the transition, for any client."""

    roles: Mapping[str, type[EObject]] = {"t_call": pn.Transition}

    def __init__(self, t_call: Expression) -> None:
        super().__init__(t_call=t_call)


class Answering(Fragment):
    """An instance answers a request: the transition, for any client."""

    roles: Mapping[str, type[EObject]] = {"t_return": pn.Transition}

    def __init__(self, t_return: Expression) -> None:
        super().__init__(t_return=t_return)


class Home(Expression):
    """The node net of a place, even if it is on a server page of which only copies remain."""

    eclass = sym.NodeNet

    def __init__(self, place: Expression) -> None:
        super().__init__(place)
        self.place = place

    def evaluate(self, match: Match) -> sym.NodeNet | None:
        """Return the node net; None: there is no copy."""
        place = self.place.evaluate(match)
        copies = (images[place] for images in match[IMAGES].values() if place in images)
        return node_net_of(place) or node_net_of(next(copies, None))

    def __str__(self) -> str:
        return f"node net of {self.place}"


class S4(StandardRule, phase=Phase.instances):
    """A copy of the server page for each instance; what it reaches by references outside is shared."""

    service = Node(sym.ServiceChannel)
    server = Node(sym.ServerPort, channel=service)
    instance = Index(upto=instances(service))

    page = Copy(
        server.page,
        into=server.page.page.objects,
        named=pn.Element,
        id="{service.id}[{instance}].{original.id}",
    )


class PagePublisher(Pattern):
    """A publisher port on the page of a server.

    `kind`: the server's port: of a service or an action.
    """

    def __init__(self, kind: type[sym.ServerPort] | type[sym.ActionServerPort]) -> None:
        self.channel = Node(sym.TopicChannel)
        self.port = Node(sym.PublisherPort, channel=self.channel)
        self.around = Node(pn.Page, of=enclosing(self.port.place, pn.Page))
        self.server = Node(kind, page=self.around)


class CopiedPublisher(PagePublisher):
    """Copies of its place, one on each copy of the page.

    Parameters
    ----------
    kind : type of model object
        The server's port.
    page : Copy
        The element that makes the copies.
    """

    def __init__(self, kind: type[sym.ServerPort] | type[sym.ActionServerPort], page: Copy) -> None:
        super().__init__(kind)
        self.page = Made(page, of=self.server)
        self.source = Node(pn.Place, of=image(self.port.place, self.page))


def copied_client(copy: str, called: Node, original: Node, page: Made) -> New:
    """Return the client of the service `called` on a copy of the page on which the original client is.

    `copy`: the start of its name; may have placeholders.
    """
    return New(
        sym.ClientPort,
        channel=called,
        client=copy + ".{original.client}",
        request=image(original.request, page),
        response=image(original.response, page),
        outstanding=original.outstanding,
        timeout=original.timeout,
        timedOut=image(original.timedOut, page),
        waitsForService=original.waitsForService,
        latency=CallLatency(original),
        group=original.group,
    )


class S4Client(StandardRule, phase=Phase.instances):
    """A client of its own for each instance of the server page that a client is on."""

    service = Node(sym.ServiceChannel)
    server = Node(sym.ServerPort, channel=service)
    instance = Index(upto=instances(service))
    page = Made(S4.page, of=[service, instance])
    called = Node(sym.ServiceChannel)
    original = Node(sym.ClientPort, channel=called)
    around = Node(pn.Page, of=enclosing(original.request, pn.Page))

    client = copied_client("{service.id}[{instance}]", called, original, page)

    where = [around == server.page]
    lhs = [service, server, instance, page, called, around, original]
    rhs = [*lhs, client]


class S3(StandardRule, phase=Phase.services):
    """Whether an instance is working."""

    service = Node(sym.ServiceChannel)
    instance = Index(upto=instances(service))

    active = place(
        "{service.id}[{instance}].active", means=Meaning("instance {instance} of service {service} is active")
    )
    inactive = place(
        "{service.id}[{instance}].inactive",
        tokens=1,
        means=Meaning("instance {instance} of service {service} is inactive", part="inactive", rests=True),
    )


class S1(StandardRule, phase=Phase.services):
    """A client's calls: one request at a time, or as many outstanding ones as it specifies (ROS 2)."""

    service, client = service_with_client()
    request = Node(pn.Place, of=client.request)
    response = Node(pn.Place, of=client.response)

    ready = place(
        "{service.id}.client.{client.client}.ready",
        tokens=greatest(1, client.outstanding),
        means=Meaning(
            "{client} of service {service} is ready",
            on_server_page="{client} is ready to call service {service}",
            rests=True,
        ),
    )
    requests = place(
        "{service.id}.client.{client.client}.requests",
        means=Meaning(
            "request of {client} of service {service} under way",
            on_server_page="request of {client} to service {service} under way",
        ),
        carries=True,
    )
    responses = place(
        "{service.id}.client.{client.client}.responses",
        means=Meaning(
            "response to {client} of service {service} under way",
            on_server_page="response of service {service} to {client} under way",
        ),
        carries=True,
    )
    t_req = transition(
        "{service.id}.client.{client.client}.req",
        means=Meaning("{client} calls service {service}", step=Request),
        at_once=True,
    )
    t_res = transition(
        "{service.id}.client.{client.client}.res",
        means=Meaning("{client} gets its response from service {service}", step=Response),
    )
    arcs = [*arcs_at(t_req, [request, ready], [requests]), *arcs_at(t_res, [responses], [response, ready])]


class S2(StandardRule, phase=Phase.services):
    """Each client may be served by each instance."""

    service, client = service_with_client()
    instance = Index(upto=instances(service))
    requests = Made(S1.requests, of=client)
    responses = Made(S1.responses, of=client)
    active = Made(S3.active, of=[service, instance])
    inactive = Made(S3.inactive, of=[service, instance])
    page = Made(S4.page, of=[service, instance])
    entry = Node(pn.Place, of=image(service.server.entry, page))
    exit = Node(pn.Place, of=image(service.server.exit, page))

    in_use = place(
        "{service.id}.client.{client.client}.inUse[{instance}]",
        means=Meaning("instance {instance} of service {service} works for {client}"),
    )
    t_call = transition(
        "{service.id}.client.{client.client}.call[{instance}]",
        means=Meaning("instance {instance} of service {service} takes the request of {client}", step=Serve),
    )
    t_return = transition(
        "{service.id}.client.{client.client}.return[{instance}]",
        means=Meaning("instance {instance} of service {service} answers {client}", step=Reply),
        at_once=True,
    )
    arcs = [
        *arcs_at(t_call, [requests, inactive], [entry, active, in_use]),
        *arcs_at(t_return, [exit, active, in_use], [responses, inactive]),
    ]
    serving = Serving(t_call)
    answering = Answering(t_return)
