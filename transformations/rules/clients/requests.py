"""Service clients of ROS 2 that do not wait (rule R8).

Such a client (`dineros.metamodel.callbacks.waiting`) sends as many requests as its node requests. Sending
never blocks: a request goes to the history of the service at once, and is lost if that is full. A response is
lost if the client's own history is full of responses that it has not taken. Both was observed with `rclpy`
7.1.6: of 30 responses that a server sent before the client's executor spun, the client got 10.
"""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.calls import UNLIMITED
from dineros.transformations.language import Made, Meaning, Node, either
from dineros.transformations.rules.notation import Bound, arc, place, service_with_client
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.requests import AbandonedCall, Entrance, R5Client, entering
from dineros.transformations.rules.services import S1

RESPONSES = "response history of {client} of service {service}"


class R8(StandardRule, phase=Phase.services, middleware="ros2"):
    """A client that does not wait has a history of responses."""

    service = Node(sym.ServiceChannel)
    client = Node(sym.ClientPort, channel=service, outstanding=UNLIMITED)
    sent = Made(R5Client.sent, of=client)
    responses = Made(S1.responses, of=client)
    t_res = Made(S1.t_res, of=client)
    past = Node(pn.Arc, source=responses, target=t_res)

    load = place(
        "{service.id}.client.{client.client}.responses.Load",
        means=Meaning("{queue}: load", queue="response", called=RESPONSES, part="load"),
        carries=True,
    )
    capacity = place(
        "{service.id}.client.{client.client}.responses.Capacity",
        tokens=service.depth,
        means=Meaning(
            "{queue}: free capacity", queue="response", called=RESPONSES, part="capacity", rests=True
        ),
    )
    queue = Entrance(
        "{service.id}.client.{client.client}.responses",
        source=responses,
        load=load,
        capacity=capacity,
        enters=entering("response", RESPONSES, "enter", "{queue} takes a response"),
        drops=entering("response", RESPONSES, "drop", "a response to {client} of service {service} is lost"),
    )
    arcs = [arc(load, t_res), arc(t_res, capacity)]
    sending = Bound(
        sent,
        1,
        means=Meaning("room for a request of {client} of service {service}", part="way", rests=True),
    )
    answering = Bound(
        responses,
        1,
        means=Meaning("room for a response to {client} of service {service}", part="way", rests=True),
    )

    deletes = [past]


class R8GiveUp(StandardRule, phase=Phase.services, middleware="ros2"):
    """A client that does not wait and has a time-out also gives up responses in its history."""

    service, client = service_with_client()
    load = Made(R8.load, of=client)
    capacity = Made(R8.capacity, of=client)

    kept = AbandonedCall("kept", load, capacity)

    where = [client.timeout > 0]


class R8Place(StandardRule, phase=Phase.services, middleware="ros2"):
    """A client that gives up puts a token on a place of its node, if it names one."""

    client = Node(sym.ClientPort)
    told = Node(pn.Place, of=client.timedOut)
    given = Made(R8GiveUp.kept, of=client)

    tells = arc(given.give_up, told)


class R8Always(StandardRule, phase=Phase.services, middleware="ros2"):
    """A client that does not wait is always ready to send a request."""

    client = Node(sym.ClientPort, outstanding=UNLIMITED)
    ready = Made(S1.ready, of=client)
    past = Node(pn.Arc, target=ready)

    deletes = [past]


class R8Ready(StandardRule, phase=Phase.services, middleware="ros2"):
    """No place counts whether a client that does not wait is ready to send a request."""

    client = Node(sym.ClientPort, outstanding=UNLIMITED)
    counted = Made(S1.ready, of=client)
    ready = Node(pn.Place, of=counted)
    t_req = Made(S1.t_req, of=client)
    asks = Node(pn.Arc, source=ready, target=t_req)

    deletes = [ready, asks]


class R8Forgets(StandardRule, phase=Phase.forgetting, middleware="ros2"):
    """A client that does not wait and has no time-out does not learn that a request is lost."""

    client = Node(sym.ClientPort, outstanding=UNLIMITED)
    lost = Made(R5Client.lost, of=client)
    past = Node(pn.Arc, target=lost)

    where = [either(client.timeout, 0.0) == 0.0]
    deletes = [past]


class R8Lost(StandardRule, phase=Phase.forgetting, middleware="ros2"):
    """Lost requests of a client that does not learn of them are not counted."""

    client = Node(sym.ClientPort, outstanding=UNLIMITED)
    counted = Made(R5Client.lost, of=client)
    lost = Node(pn.Place, of=counted)

    where = [either(client.timeout, 0.0) == 0.0]
    deletes = [lost]
