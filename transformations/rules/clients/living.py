"""Which request a full history loses if clients may give up (rule R6).

It loses its oldest request. If all its requests are late, this is one whose client has given up. So a client
loses its request only if the history has a request of a client that still waits.
"""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.transformations.language import ForAll, Made, Meaning, Node, less
from dineros.transformations.rules.notation import arc, place, read, service_with_client
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.tokens import Change, Lowering, Raising
from dineros.transformations.rules.requests import R6, R5Client
from dineros.transformations.rules.services import S1


class R6Live(StandardRule, phase=Phase.services, middleware="ros2"):
    """How many of the requests in the history belong to clients that still wait."""

    service = Node(sym.ServiceChannel)
    late = Made(R6.late, of=service)

    live = place(
        "{service.id}.live.requests", means=Meaning("requests of clients of service {service} that wait")
    )


class R6Drop(StandardRule, phase=Phase.services, middleware="ros2"):
    """A full history discards its oldest request: a late one, if all are late."""

    service, client = service_with_client()
    live = Made(R6Live.live, of=service)
    queue = Made(R5Client.queue, of=client)

    waits = read(live, queue.drop)


class R6Counts(StandardRule, phase=Phase.wiring, middleware="ros2"):
    """Requests of clients that still wait are counted when they enter and leave the history."""

    service, client = service_with_client()
    live = Made(R6Live.live, of=service)
    requests = Made(S1.requests, of=client)
    raising = Node(pn.Transition, of=Raising(requests))
    lowering = Node(pn.Transition, of=Lowering(requests))

    more = ForAll([raising], make=[arc(raising, live, weight=Change(requests, raising))])
    fewer = ForAll([lowering], make=[arc(live, lowering, weight=less(0, Change(requests, lowering)))])
