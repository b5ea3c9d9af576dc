"""The time that the engine of a node needs to fire, and to take arrived messages (rule D7)."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.transformations.language import Index, Made, New, Node, Path, ancestor
from dineros.transformations.rules.histories import R3
from dineros.transformations.rules.notation import service_with_client
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.message_times import CallsArriveInTime, CallsOnTheWay
from dineros.transformations.rules.queries.times import (
    HandledUntil,
    IsHandled,
    Reacts,
    ReactsFrom,
    ReactsUntil,
)
from dineros.transformations.rules.requests import R6Instance
from dineros.transformations.rules.services import S1, S2, Home, instances


class D7(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """A transition without an interval fires within its node's reaction, unless its handler takes time."""

    move = Node(sym.Transition)
    node = Node(sym.NodeNet, of=ancestor(move, sym.NodeNet))

    reaction = New(pn.TimeInterval, into=move.interval, earliest=ReactsFrom(node), latest=ReactsUntil(node))

    where = [Reacts(node, move)]


class D7Handled(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """A transition whose handler takes time fires when that ends; handlers of several tokens may overlap."""

    move = Node(sym.Transition)
    node = Node(sym.NodeNet, of=ancestor(move, sym.NodeNet))

    flight = New(pn.TimeInterval, into=move.interval, earliest=0.0, latest=HandledUntil(node, move))

    where = [IsHandled(node, move)]


class D7Take(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """An engine takes a message within its node's reaction if it has room for it."""

    reader = Node(sym.SubscriberPort)
    node = Node(sym.NodeNet, of=ancestor(reader.place, sym.NodeNet))
    queue = Made(R3.queue, of=reader)
    move = Node(pn.Transition, of=queue.leave)

    reaction = New(
        pn.TimeInterval, into=Path(move, "interval"), earliest=ReactsFrom(node), latest=ReactsUntil(node)
    )

    where = [Reacts(node, move)]


class D7Request(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """An engine takes a request within its reaction if requests have clocks and an instance is free."""

    service, client = service_with_client()
    node = Node(sym.NodeNet, of=Home(service.server.entry))
    instance = Index(upto=instances(service))
    taken = Made(S2.t_call, of=[service, client, instance])
    move = Node(pn.Transition, of=taken)

    reaction = New(
        pn.TimeInterval, into=Path(move, "interval"), earliest=ReactsFrom(node), latest=ReactsUntil(node)
    )

    where = [CallsOnTheWay(client) > 0, Reacts(node, move)]


class D7Late(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """An engine takes a request whose client has given up within its node's reaction."""

    service = Node(sym.ServiceChannel)
    node = Node(sym.NodeNet, of=Home(service.server.entry))
    instance = Index(upto=instances(service))
    taken = Made(R6Instance.t_call, of=[service, instance])
    move = Node(pn.Transition, of=taken)

    reaction = New(
        pn.TimeInterval, into=Path(move, "interval"), earliest=ReactsFrom(node), latest=ReactsUntil(node)
    )

    where = [CallsArriveInTime(service), Reacts(node, move)]


class D7Response(StandardRule, phase=Phase.intervals, middleware="ros2", times=True):
    """An engine takes a response within its node's reaction if responses have clocks."""

    client = Node(sym.ClientPort)
    node = Node(sym.NodeNet, of=ancestor(client.response, sym.NodeNet))
    taken = Made(S1.t_res, of=client)
    move = Node(pn.Transition, of=taken)

    reaction = New(
        pn.TimeInterval, into=Path(move, "interval"), earliest=ReactsFrom(node), latest=ReactsUntil(node)
    )

    where = [CallsOnTheWay(client) > 0, Reacts(node, move)]
