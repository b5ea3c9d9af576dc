"""Service requests of ROS 2: the history of a service, and clients that give up (rules R5 to R7).

A server keeps its last requests, of all clients, until it takes them. Which request a full history loses
makes no difference: requests of different clients may arrive in any order, so any request can be the lost one
(OMG, Data Distribution Service 1.4, 2015, Sect. 2.2.3.18).

A client that gives up is ready at once, and does not notify the server. So its request still uses room in the
history and time of an instance, as a late request, and the response is dropped. Only in this case it matters
which request is lost: a late request was there before its client gave up.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.calls import (
    gives_up,
    loses_requests,
    may_be_deserted,
    may_leave,
    sends_once,
)
from dineros.metamodel.records import Drop, GiveUp, Reply, Serve, Transfer
from dineros.transformations.language import TRUTH, Expression, ForAll, Fragment, Meaning, New, image
from dineros.transformations.language.errors import LANGUAGE
from dineros.transformations.language.functions import Query
from dineros.transformations.language.meaning import QueueKind
from dineros.transformations.language.patterns import Index, Made, Node
from dineros.transformations.rules.notation import (
    OverflowQueue,
    arc,
    arcs_at,
    place,
    service_with_client,
    transition,
)
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.services import S1, S2, S3, S4, Answering, Home, Serving, instances

LANGUAGE.add(__name__)

HISTORY = "request history of service {service}"


class LosesRequests(Query):
    """Whether more requests of a service may wait than its history keeps, or its server may be absent."""

    datatype = TRUTH
    _words = "requests of {} can be lost, also because {} is not there"

    @staticmethod
    def _answer(service: sym.ServiceChannel, server: sym.NodeNet | None) -> bool:
        return loses_requests(service) or may_be_deserted(service, server)


class GivesUp(Query):
    """Whether a client of a service has a time-out."""

    datatype = TRUTH
    _words = "a client of {} has a time-out"
    _answer = staticmethod(gives_up)


class SendsOnce(Query):
    """Whether a client sends each request only once."""

    datatype = TRUTH
    _words = "{} sends each request once"
    _answer = staticmethod(sends_once)


class MayBeDeserted(Query):
    """Whether requests of a service are lost while its server is absent."""

    datatype = TRUTH
    _words = "requests of {} are lost while {} is not there"
    _answer = staticmethod(may_be_deserted)


class MayLeave(Query):
    """Whether requests of a service are lost when its server stops."""

    datatype = TRUTH
    _words = "requests of {} are lost with {}"
    _answer = staticmethod(may_leave)


class AnswersNobody(Query):
    """Whether an instance may work for a client that has given up, or whose request is lost."""

    datatype = TRUTH
    _words = "a client of {} has a time-out, or loses requests that {} works on"

    @staticmethod
    def _answer(service: sym.ServiceChannel, server: sym.NodeNet | None) -> bool:
        return gives_up(service) or may_leave(service, server)


class Entrance(OverflowQueue):
    """Tokens enter a history or are lost; transitions of other rules take them out.

    Parameters
    ----------
    id : str
        Prefix of the ids of its transitions; may have placeholders.
    source : Expression
        The place at which tokens arrive.
    load, capacity : Expression
        The places of the history.
    enters, drops : Meaning
        Meanings of its transitions.
    kept, lost : sequence of Expression
        Places that get a token for each token that has entered, and for each one lost.
    """

    roles: Mapping[str, type[EObject]] = {
        role: kind for role, kind in OverflowQueue.roles.items() if role != "leave"
    }

    def __init__(
        self,
        id: str,
        *,
        source: Expression,
        load: Expression,
        capacity: Expression,
        enters: Meaning,
        drops: Meaning,
        kept: Sequence[Expression] = (),
        lost: Sequence[Expression] = (),
    ) -> None:
        Fragment.__init__(self, load=load, capacity=capacity)
        self.enter = transition(f"{id}.in", means=enters)
        self.drop = transition(f"{id}.drop", means=drops)
        self.arcs = [
            *arcs_at(self.enter, [source, capacity], [load]),
            *(arc(self.enter, each) for each in kept),
            arc(source, self.drop),
            *(arc(self.drop, each) for each in lost),
        ]


def entering(kind: QueueKind, called: str, part: str, words: str, on_server_page: str = "") -> Meaning:
    """Return the meaning of a transition in which a token enters a history, or is lost."""
    step = Drop if part == "drop" else Transfer
    return Meaning(words, on_server_page, step=step, queue=kind, called=called, part=part)


class R5(StandardRule, phase=Phase.services, middleware="ros2"):
    """Request history of each service that can lose requests."""

    service = Node(sym.ServiceChannel)

    load = place(
        "{service.id}.requests.Load",
        means=Meaning("{queue}: load", queue="request", called=HISTORY, part="load"),
    )
    capacity = place(
        "{service.id}.requests.Capacity",
        tokens=service.depth,
        means=Meaning("{queue}: free capacity", queue="request", called=HISTORY, part="capacity", rests=True),
    )

    where = [LosesRequests(service, Home(service.server.entry))]


class R5Client(StandardRule, phase=Phase.services, middleware="ros2"):
    """A client's requests go through the history; each call that takes one makes room."""

    service, client = service_with_client()
    load = Made(R5.load, of=service)
    capacity = Made(R5.capacity, of=service)
    t_req = Made(S1.t_req, of=client)
    requests = Made(S1.requests, of=client)
    past = Node(pn.Arc, source=t_req, target=requests)

    sent = place(
        "{service.id}.client.{client.client}.sent",
        means=Meaning(
            "request of {client} of service {service} arriving",
            on_server_page="request of {client} to service {service} arriving",
        ),
        carries=True,
    )
    lost = place(
        "{service.id}.client.{client.client}.lost",
        means=Meaning(
            "lost request of {client} of service {service}",
            on_server_page="lost request of {client} to service {service}",
        ),
    )
    through = arc(t_req, sent)
    queue = Entrance(
        "{service.id}.client.{client.client}",
        source=sent,
        load=load,
        capacity=capacity,
        enters=entering("request", HISTORY, "enter", "{queue} takes the request of {client}"),
        drops=entering(
            "request",
            HISTORY,
            "drop",
            "a request is lost: {client} of service {service} {waits}",
            "a request to service {service} is lost: {client} {waits}",
        ),
        kept=[requests],
        lost=[lost],
    )
    t_call = Made(S2.t_call, of=client)
    room = ForAll([t_call], make=[arc(load, t_call), arc(t_call, capacity)])

    deletes = [past]


class R6(StandardRule, phase=Phase.services, middleware="ros2"):
    """Late requests of a service: those in its history whose clients have given up."""

    service = Node(sym.ServiceChannel)

    late = place(
        "{service.id}.late.requests",
        means=Meaning("request of a client of service {service} that has given up"),
        carries=True,
    )

    where = [GivesUp(service)]


class R6Client(StandardRule, phase=Phase.services, middleware="ros2"):
    """A full history may discard a late request instead of losing the one that comes."""

    service, client = service_with_client()
    late = Made(R6.late, of=service)
    load = Made(R5.load, of=service)
    sent = Made(R5Client.sent, of=client)
    requests = Made(S1.requests, of=client)

    instead = transition(
        "{service.id}.client.{client.client}.instead",
        means=Meaning(
            "{queue} takes the request of {client}, and discards one whose client has given up",
            step=Transfer,
            queue="request",
            called=HISTORY,
            part="instead",
        ),
    )
    arcs = [
        arc(sent, instead),
        arc(late, instead),
        arc(load, instead, weight=service.depth),
        arc(instead, load, weight=service.depth),
        arc(instead, requests),
    ]


class R6Late(StandardRule, phase=Phase.services, middleware="ros2"):
    """An instance may work for a client that no longer waits; its response is discarded."""

    service = Node(sym.ServiceChannel)
    instance = Index(upto=instances(service))
    active = Made(S3.active, of=[service, instance])
    inactive = Made(S3.inactive, of=[service, instance])
    page = Made(S4.page, of=[service, instance])
    exit = Node(pn.Place, of=image(service.server.exit, page))

    in_use = place(
        "{service.id}.late.inUse[{instance}]",
        means=Meaning("instance {instance} of service {service} works for a client that no longer waits"),
    )
    t_return = transition(
        "{service.id}.late.return[{instance}]",
        means=Meaning(
            "instance {instance} of service {service} answers a client that no longer waits", step=Reply
        ),
        at_once=True,
    )
    arcs = arcs_at(t_return, [exit, active, in_use], [inactive])
    answering = Answering(t_return)

    where = [AnswersNobody(service, Home(service.server.entry))]


class R6Instance(StandardRule, phase=Phase.services, middleware="ros2"):
    """Each instance may take a late request."""

    service = Node(sym.ServiceChannel)
    instance = Index(upto=instances(service))
    late = Made(R6.late, of=service)
    load = Made(R5.load, of=service)
    capacity = Made(R5.capacity, of=service)
    active = Made(S3.active, of=[service, instance])
    inactive = Made(S3.inactive, of=[service, instance])
    page = Made(S4.page, of=[service, instance])
    entry = Node(pn.Place, of=image(service.server.entry, page))
    in_use = Made(R6Late.in_use, of=[service, instance])

    t_call = transition(
        "{service.id}.late.call[{instance}]",
        means=Meaning(
            "instance {instance} of service {service} takes the request of a client that has given up",
            step=Serve,
        ),
    )
    arcs = arcs_at(t_call, [late, load, inactive], [capacity, entry, active, in_use])
    serving = Serving(t_call)


GIVING_UP = "{service.id}.client.{client.client}.giveUp."
"""Prefix of the ids of transitions in which a client gives up."""
GIVES_UP = Meaning("{client} gives up waiting for service {service}", step=GiveUp)
"""Description of a transition in which a client gives up a call."""


class AbandonedCall(Fragment):
    """A client gives up a call and is ready for the next one.

    Parameters
    ----------
    way : str
        Where the call is at that time, as the end of its transition's id; may have placeholders.
    call : Expression
        The place of the call.
    ready : Expression
        The place of the client's readiness.
    """

    roles: Mapping[str, type[EObject]] = {"give_up": pn.Transition}
    give_up: New

    def __init__(self, way: str, call: Expression, ready: Expression) -> None:
        super().__init__()
        self.give_up = transition(GIVING_UP + way, means=GIVES_UP)
        self.arcs = [arc(call, self.give_up), arc(self.give_up, ready)]


class StopsWaiting(AbandonedCall):
    """A client that waits for each response gives up a call."""


class R7(StandardRule, phase=Phase.services, middleware="ros2"):
    """A client with a time-out may give up a request that waits, is lost, or has a response on its way."""

    service, client = service_with_client()
    ready = Made(S1.ready, of=client)
    requests = Made(S1.requests, of=client)
    responses = Made(S1.responses, of=client)
    lost = Made(R5Client.lost, of=client)
    late = Made(R6.late, of=service)

    waiting = StopsWaiting("requests", requests, ready)
    forgotten = StopsWaiting("lost", lost, ready)
    answered = StopsWaiting("responses", responses, ready)
    goes_on = arc(waiting.give_up, late)

    where = [client.timeout > 0]


class R7Instance(StandardRule, phase=Phase.services, middleware="ros2"):
    """A client with a time-out gives up while an instance works for it; the instance continues."""

    service, client = service_with_client()
    instance = Index(upto=instances(service))
    ready = Made(S1.ready, of=client)
    in_use = Made(S2.in_use, of=[client, instance])
    late = Made(R6Late.in_use, of=[service, instance])

    served = StopsWaiting("inUse[{instance}]", in_use, ready)
    goes_on = arc(served.give_up, late)

    where = [client.timeout > 0]


class R7Sent(StandardRule, phase=Phase.services, middleware="ros2"):
    """A client that repeats a request until it gets a response may also give up while the server is away."""

    service, client = service_with_client()
    ready = Made(S1.ready, of=client)
    sent = Made(R5Client.sent, of=client)

    away = StopsWaiting("sent", sent, ready)

    where = [client.timeout > 0, MayBeDeserted(service, Home(service.server.entry)), ~SendsOnce(client)]


class R7Place(StandardRule, phase=Phase.services, middleware="ros2"):
    """A client that gives up puts a token on a place of its node, if it names one."""

    client = Node(sym.ClientPort)
    told = Node(pn.Place, of=client.timedOut)
    given = Made(StopsWaiting, of=client)

    tells = arc(given.give_up, told)
