"""Time-outs of clients (rule D8): a callback gives up when its time-out is over, an engine from then on."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.transformations.language import Index, Made, Meaning, Node, count
from dineros.transformations.rules.notation import (
    arc,
    arcs_at,
    at_once,
    inhibit,
    place,
    read,
    service_with_client,
    transition,
)
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.message_times import CallsOnTheWay, GivesUpInTime, TimeOut
from dineros.transformations.rules.queries.times import RunsCallbacks
from dineros.transformations.rules.requests import GIVES_UP, GIVING_UP, R6, StopsWaiting
from dineros.transformations.rules.services import S1, S2
from dineros.transformations.rules.times.latencies import REQUEST, D6BackClock


class D8(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A client's time-out runs from its request until it has the response or gives up."""

    service, client = service_with_client()
    t_req = Made(S1.t_req, of=client)
    t_res = Made(S1.t_res, of=client)

    asks = place(REQUEST + ".asks", means=Meaning("{client} waits for service {service}"))
    over = place(REQUEST + ".over", means=Meaning("the time-out of {client} of service {service} is over"))
    ring = transition(
        REQUEST + ".ring",
        means=Meaning("the time-out of {client} of service {service} is over"),
        within=TimeOut(client),
    )
    forget = transition(
        REQUEST + ".forget",
        means=Meaning("the time-out of {client} of service {service} is stopped"),
        at_once=True,
    )
    arcs = [
        arc(t_req, asks),
        inhibit(over, t_req),
        arc(asks, t_res),
        read(asks, ring),
        inhibit(over, ring),
        arc(ring, over),
        arc(over, forget),
        inhibit(asks, forget),
    ]

    where = [GivesUpInTime(client)]


class D8Back(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A client may give up while a response is on its way; the response is then discarded."""

    service, client = service_with_client()
    asks = Made(D8.asks, of=client)
    over = Made(D8.over, of=client)
    ready = Made(S1.ready, of=client)
    number = Index(upto=CallsOnTheWay(client))
    clock = Made(D6BackClock.clock, of=[client, number])

    give_up = transition(GIVING_UP + "back[{number}]", means=GIVES_UP)
    arcs = arcs_at(give_up, [clock.busy, asks, over], [clock.free, ready])


class D8BackPlace(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A client that gives up while a response is on its way puts a token on a place of its node."""

    client = Node(sym.ClientPort)
    told = Node(pn.Place, of=client.timedOut)
    give_up = Made(D8Back.give_up, of=client)

    tells = arc(give_up, told)


class D8GiveUp(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A client gives up only after its time-out."""

    client = Node(sym.ClientPort)
    asks = Made(D8.asks, of=client)
    over = Made(D8.over, of=client)
    given = Made(StopsWaiting, of=client)

    arcs = [arc(asks, given.give_up), arc(over, given.give_up)]


class D8Prompt(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A callback that waits for the response gives up as soon as its time-out is over."""

    client = Node(sym.ClientPort)
    given = Made(StopsWaiting, of=client)
    move = Node(pn.Transition, of=given.give_up)

    prompt = at_once(move)

    where = [GivesUpInTime(client), RunsCallbacks(client.request)]


class D8BackPrompt(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A callback that waits gives up as soon as its time-out is over, also if a response is on its way."""

    client = Node(sym.ClientPort)
    given = Made(D8Back.give_up, of=client)
    move = Node(pn.Transition, of=given)

    prompt = at_once(move)

    where = [RunsCallbacks(client.request)]


class D8First(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """The requests of one client are taken in their order; those that it has given up come first."""

    service, client = service_with_client()
    late = Made(R6.late, of=service)
    call = Made(S2.t_call, of=client)

    waits = inhibit(late, call)

    where = [GivesUpInTime(client), count(service.clients) == 1]
