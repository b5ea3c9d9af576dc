"""Messages under way (rules D5 and D6): each has its own clock.

The clocks do not keep the order of messages. A net counts indistinguishable tokens, so the counts are those
of messages that arrive in order: if the k-th message is sent at time s(k), the k-th arrival is within s(k)
plus the latency in both cases.
"""

from __future__ import annotations

from collections.abc import Mapping

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.transformations.language import Expression, Fragment, Index, Made, Meaning, New, Node, Path, less
from dineros.transformations.rules.histories import PAIR, R2, R3, AnyManaged
from dineros.transformations.rules.notation import (
    arc,
    at_once,
    inhibit,
    place,
    read,
    service_with_client,
    topic_with_ports,
)
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.message_times import (
    ArrivesNext,
    ArrivesUntil,
    CallLatency,
    CallsOnTheWay,
    Latency,
    OnTheWay,
)
from dineros.transformations.rules.queries.times import PublishesWithoutEnd
from dineros.transformations.rules.requests import R5Client, R6Client
from dineros.transformations.rules.services import S1
from dineros.transformations.rules.times.clocks import Clock

REQUEST = "{service.id}.client.{client.client}"
"""Prefix of ids for requests that a client sends and responses that it gets."""


class D5(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A message that leaves a writer history is on its way to the reader history."""

    channel, writer, reader = topic_with_ports()
    queue = Made(R2.queue, of=[writer, reader])
    leave = Node(pn.Transition, of=queue.leave)
    received = Made(R3.received, of=reader)
    past = Node(pn.Arc, source=leave, target=received)

    sent = place(
        f"{PAIR}.sent",
        means=Meaning("a message of {publisher} for {subscriber} (topic {topic}) is sent"),
        carries=True,
    )
    sends = arc(leave, sent)
    prompt = at_once(leave)

    where = [OnTheWay(writer, reader) > 0, ~AnyManaged(writer, reader)]
    deletes = [past]


class D5Clock(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """Each message on its way has a clock."""

    channel, writer, reader = topic_with_ports()
    sent = Made(D5.sent, of=[writer, reader])
    received = Made(R3.received, of=reader)
    number = Index(upto=OnTheWay(writer, reader))

    clock = Clock(
        f"{PAIR}.way[{{number}}]",
        source=sent,
        target=received,
        within=Latency(writer, reader),
        begins="a message of {publisher} for {subscriber} (topic {topic}) leaves",
        runs="a message of {publisher} for {subscriber} (topic {topic}) is on its way",
        ends="a message of {publisher} for {subscriber} (topic {topic}) arrives",
    )


class D5Open(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """Messages that are published without end arrive one at a time, so that none gather in no time."""

    channel, writer, reader = topic_with_ports()
    queue = Made(R2.queue, of=[writer, reader])
    received = Made(R3.received, of=reader)

    waits = inhibit(received, queue.leave)

    where = [~AnyManaged(writer, reader), PublishesWithoutEnd(writer, reader)]


class D5Next(StandardRule, phase=Phase.timing, middleware="ros2", overflow="weighted", times=True):
    """Of messages whose number is unbounded, the first one arrives within the latency after the one before.

    Really it arrives within the latency after its publication, which was not later than it became the first
    one. What displaces messages takes all of them, so the time starts again.
    """

    channel, writer, reader = topic_with_ports()
    queue = Made(R2.queue, of=[writer, reader])
    leave = Node(pn.Transition, of=queue.leave)

    next = New(
        pn.TimeInterval, into=Path(leave, "interval"), earliest=0.0, latest=ArrivesUntil(writer, reader)
    )

    where = [~AnyManaged(writer, reader), ArrivesNext(writer, reader)]


class D5Order(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A message on its way takes the first free clock."""

    channel, writer, reader = topic_with_ports()
    number = Index(upto=OnTheWay(writer, reader))
    clock = Made(D5Clock.clock, of=[writer, reader, number])
    lower = Index(upto=less(number, 1))
    before = Made(D5Clock.clock, of=[writer, reader, lower])

    waits = read(before.busy, clock.begin)


class D5Hand(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A writer that sends its messages at once loses none while a clock is free."""

    channel, writer, reader = topic_with_ports()
    queue = Made(R2.queue, of=[writer, reader])
    number = Index(upto=OnTheWay(writer, reader))
    clock = Made(D5Clock.clock, of=[writer, reader, number])

    waits = read(clock.busy, queue.drop)


class Journey(Fragment):
    """A request is sent at one place and arrives at another."""

    roles: Mapping[str, type[EObject]] = {"sent": pn.Place, "arrived": pn.Place}

    def __init__(self, sent: Expression, arrived: Expression) -> None:
        super().__init__(sent=sent, arrived=arrived)


class D6(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A request of a client is on its way to the server."""

    service, client = service_with_client()
    t_req = Made(S1.t_req, of=client)
    requests = Made(S1.requests, of=client)
    past = Node(pn.Arc, source=t_req, target=requests)

    sent = place(
        REQUEST + ".way", means=Meaning("a request of {client} of service {service} is sent"), carries=True
    )
    sends = arc(t_req, sent)
    journey = Journey(sent, requests)

    where = [CallsOnTheWay(client) > 0]
    deletes = [past]


class D6History(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A request of a client is on its way to the request history."""

    service, client = service_with_client()
    t_req = Made(S1.t_req, of=client)
    arriving = Made(R5Client.sent, of=client)
    past = Node(pn.Arc, source=t_req, target=arriving)

    sent = place(
        REQUEST + ".way", means=Meaning("a request of {client} of service {service} is sent"), carries=True
    )
    sends = arc(t_req, sent)
    journey = Journey(sent, arriving)

    where = [CallsOnTheWay(client) > 0]
    deletes = [past]


class D6Enter(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A request that has arrived there enters that history, or is lost, at once."""

    client = Node(sym.ClientPort)
    queue = Made(R5Client.queue, of=client)
    enter = Node(pn.Transition, of=queue.enter)
    drop = Node(pn.Transition, of=queue.drop)

    enters = at_once(enter)
    drops = at_once(drop)

    where = [CallsOnTheWay(client) > 0]


class D6Instead(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A request that has arrived enters at once in place of one whose client has given up."""

    client = Node(sym.ClientPort)
    instead = Made(R6Client.instead, of=client)
    enter = Node(pn.Transition, of=instead)

    enters = at_once(enter)

    where = [CallsOnTheWay(client) > 0]


class D6Clock(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """Each request on its way has a clock."""

    service, client = service_with_client()
    journey = Made(Journey, of=client)
    number = Index(upto=CallsOnTheWay(client))

    clock = Clock(
        REQUEST + ".way[{number}]",
        source=journey.sent,
        target=journey.arrived,
        within=CallLatency(client),
        begins="a request of {client} of service {service} leaves",
        runs="a request of {client} of service {service} is on its way",
        ends="a request of {client} of service {service} arrives",
    )


class D6Order(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A request on its way takes the first free clock."""

    service, client = service_with_client()
    number = Index(upto=CallsOnTheWay(client))
    clock = Made(D6Clock.clock, of=[client, number])
    lower = Index(upto=less(number, 1))
    before = Made(D6Clock.clock, of=[client, lower])

    waits = read(before.busy, clock.begin)


class D6Back(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """Responses are on their way to the client."""

    service, client = service_with_client()
    responses = Made(S1.responses, of=client)

    answered = place(
        REQUEST + ".back",
        means=Meaning("a response of service {service} to {client} is sent"),
        carries=True,
    )

    where = [CallsOnTheWay(client) > 0]


class D6Answer(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """Each instance sends its responses to the client."""

    client = Node(sym.ClientPort)
    responses = Made(S1.responses, of=client)
    answered = Made(D6Back.answered, of=client)
    past = Node(pn.Arc, target=responses)
    sender = Node(pn.Transition, of=past.source)

    sends = arc(sender, answered)

    deletes = [past]


class D6BackClock(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """Each response on its way has a clock."""

    service, client = service_with_client()
    answered = Made(D6Back.answered, of=client)
    responses = Made(S1.responses, of=client)
    number = Index(upto=CallsOnTheWay(client))

    clock = Clock(
        REQUEST + ".back[{number}]",
        source=answered,
        target=responses,
        within=CallLatency(client),
        begins="a response of service {service} to {client} leaves",
        runs="a response of service {service} to {client} is on its way",
        ends="a response of service {service} to {client} arrives",
    )


class D6BackOrder(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A response on its way takes the first free clock."""

    service, client = service_with_client()
    number = Index(upto=CallsOnTheWay(client))
    clock = Made(D6BackClock.clock, of=[client, number])
    lower = Index(upto=less(number, 1))
    before = Made(D6BackClock.clock, of=[client, lower])

    waits = read(before.busy, clock.begin)
