"""Topics: publisher, dispatcher and subscriber queues (rules T1 to T5b; paper, Fig. 8)."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.records import Publish, Take, Transfer
from dineros.transformations.language import Absent, Made, Meaning, Node, ancestor, either, enclosing, first
from dineros.transformations.language.meaning import QueueKind
from dineros.transformations.rules.notation import History, OverflowQueue, arc, inhibit, place, transition
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.services import S4, CopiedPublisher, PagePublisher

DISPATCHER_LIMIT = 16
"""Capacity of a dispatcher queue if the model does not give it (paper, Sect. 5.5.2)."""


def _arriving(kind: QueueKind) -> Meaning:
    return Meaning("{queue}: arriving messages", queue=kind, part="received")


class T1(StandardRule, phase=Phase.publications, middleware="ros1"):
    """The topic itself, between the nodes."""

    channel = Node(sym.TopicChannel)

    topic = place(
        "{channel.id}", means=Meaning("messages under way on topic {topic}", part="topic"), carries=True
    )
    transport = transition(
        "{channel.id}.transport",
        means=Meaning("topic {topic} delivers a message", step=Transfer, part="transport"),
    )
    arcs = [arc(topic, transport)]


class T2(StandardRule, phase=Phase.publications, middleware="ros1"):
    """Overflowing send queue of each publisher port."""

    channel = Node(sym.TopicChannel)
    port = Node(sym.PublisherPort, channel=channel)
    source = Node(pn.Place, of=port.place)
    topic = Made(T1.topic, of=channel)

    queue = OverflowQueue(
        "{channel.id}.publisher.{source.id}",
        source=source,
        limit=port.limit,
        sinks=[topic],
        kind="publisher",
        enters=Publish,
    )

    around = Node(pn.Page, of=enclosing(port.place, pn.Page))
    server = Node(sym.ServerPort, page=around)
    slots = Node(sym.ActionServerPort, page=around)
    absent = [Absent(around, server), Absent(around, slots)]


class T2History(StandardRule, phase=Phase.publications, middleware="ros1"):
    """Send queue of a publisher port on a server page: one for all instances."""

    on_page = PagePublisher(sym.ServerPort)
    topic = Made(T1.topic, of=on_page.channel)

    queue = History(
        "{channel.id}.publisher.{port.place.id}", limit=on_page.port.limit, sinks=[topic], kind="publisher"
    )


class T2Instance(StandardRule, phase=Phase.publications, middleware="ros1"):
    """Each instance of a server page writes to the publisher's one send queue, or loses its message."""

    copied = CopiedPublisher(sym.ServerPort, S4.page)
    history = Made(T2History.queue, of=copied.port)

    queue = OverflowQueue(
        "{channel.id}.publisher.{source.id}",
        source=copied.source,
        history=history,
        kind="publisher",
        enters=Publish,
    )


class T3(StandardRule, phase=Phase.deliveries, middleware="ros1"):
    """Overflowing dispatcher queue of each subscribing node net."""

    channel = Node(sym.TopicChannel)
    node = Node(sym.NodeNet, of=ancestor(channel.subscribers.place, sym.NodeNet))
    transport = Made(T1.transport, of=channel)

    received = place("{channel.id}.dispatcher.{node.id}.In", means=_arriving("dispatcher"), carries=True)
    arcs = [arc(transport, received)]
    queue = OverflowQueue(
        "{channel.id}.dispatcher.{node.id}",
        source=received,
        limit=either(first(channel.dispatchers, node=node).limit, DISPATCHER_LIMIT),
        kind="dispatcher",
    )


class T4(StandardRule, phase=Phase.deliveries, middleware="ros1"):
    """Overflowing callback queue of each subscriber port."""

    channel = Node(sym.TopicChannel)
    port = Node(sym.SubscriberPort, channel=channel)
    node = Node(sym.NodeNet, of=ancestor(port.place, sym.NodeNet))
    sink = Node(pn.Place, of=port.place)
    dispatcher = Made(T3.queue, of=[channel, node])

    received = place("{channel.id}.subscriber.{sink.id}.In", means=_arriving("subscriber"), carries=True)
    arcs = [arc(dispatcher.leave, received)]
    queue = OverflowQueue(
        "{channel.id}.subscriber.{sink.id}",
        source=received,
        limit=port.limit,
        sinks=[sink],
        kind="subscriber",
        leaves=Take,
    )


class T5a(StandardRule, phase=Phase.drops, overflow="inhibitor"):
    """A queue drops while it has no capacity left: inhibitor arc, for nets that people read."""

    queue = Made(OverflowQueue)
    arcs = [inhibit(queue.capacity, queue.drop)]


class T5b(StandardRule, phase=Phase.drops, overflow="weighted"):
    """A queue drops while its load is its capacity: normal arcs, for nets that tools reduce."""

    queue = Made(OverflowQueue)
    arcs = [
        arc(queue.load, queue.drop, weight=queue.capacity.tokens),
        arc(queue.drop, queue.load, weight=queue.capacity.tokens),
    ]
