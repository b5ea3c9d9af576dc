"""Feedback of an action, for the client of the goal (rule A5).

It is a ROS topic: feedback that arrives faster than the client takes it is lost. A slot sends all its
feedback before its goal ends.
"""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.records import Feedback, Hear
from dineros.transformations.language import ForAll, Index, Made, Meaning, Node, image
from dineros.transformations.language.functions import count, either, greatest
from dineros.transformations.rules.actions.ends import End
from dineros.transformations.rules.actions.goals import A2, Heard
from dineros.transformations.rules.actions.slots import A6, SlotPage, slots
from dineros.transformations.rules.notation import (
    Bound,
    DeclaredBound,
    OverflowQueue,
    action_with_client,
    arc,
    place,
    read,
    transition,
)
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.tokens import Lowering, MostNeeded, MostPut

HISTORY = "feedback history of {client} of action {action}"


class A5(StandardRule, phase=Phase.outcomes):
    """Feedback history of each client that listens."""

    action = Node(sym.ActionChannel)
    server = Node(sym.ActionServerPort, channel=action)
    told = Node(pn.Place, of=server.feedback)
    client = Node(sym.ActionClientPort, channel=action)
    sink = Node(pn.Place, of=client.feedback)

    received = place(
        "{action.id}.client.{client.client}.feedback.In",
        means=Meaning("{queue}: arriving feedback", queue="feedback", called=HISTORY, part="received"),
        carries=True,
    )
    queue = OverflowQueue(
        "{action.id}.client.{client.client}.feedback",
        source=received,
        limit=action.depth,
        sinks=[sink],
        kind="feedback",
        called=HISTORY,
        leaves=Hear,
    )
    bound = Bound(
        received, 1, means=Meaning("{queue}: room for arriving feedback", called=HISTORY, rests=True)
    )

    heard = Heard(queue.leave)


class A5Tell(StandardRule, phase=Phase.outcomes):
    """A slot sends feedback to the client of its goal; if the client does not listen, it is discarded."""

    action, client = action_with_client()
    slot = Index(upto=slots(action))
    page = Made(A6.page, of=[action, slot])
    source = Node(pn.Place, of=image(action.server.feedback, page))
    in_use = Made(A2.in_use, of=[client, slot])

    tell = transition(
        "{action.id}.client.{client.client}.feedback[{slot}]",
        means=Meaning("slot {instance} of action {action} gives feedback to {client}", step=Feedback),
    )
    arcs = [arc(source, tell), read(in_use, tell)]
    received = Made(A5.received, of=client)
    arrives = ForAll([received], make=[arc(tell, received)])


class A5Room(StandardRule, phase=Phase.rooms):
    """Feedback that waits to be published: at most that of one firing, since it is sent at once."""

    served = SlotPage()
    source = Node(pn.Place, of=image(served.action.server.feedback, served.page))

    bound = DeclaredBound(
        source,
        greatest(1, source.tokens, MostPut(source)),
        means=Meaning("free room for feedback of slot {instance} of action {action}", rests=True),
    )

    where = [either(source.capacity, 0) == 0]


class A5First(StandardRule, phase=Phase.rooms):
    """A goal is over only when all feedback about it has been published."""

    served = SlotPage()
    source = Node(pn.Place, of=image(served.action.server.feedback, served.page))
    bound = Made(DeclaredBound)
    end = Made(End, of=[served.action, served.slot])

    all_told = read(bound.free, end.move, weight=bound.free.tokens)

    where = [bound.place == source]


class A5Hand(StandardRule, phase=Phase.rooms):
    """Feedback that a client has taken and not yet processed, if something takes it."""

    action, client = action_with_client()
    sink = Node(pn.Place, of=client.feedback)
    queue = Made(A5.queue, of=client)

    bound = Bound(
        sink,
        greatest(1, sink.tokens, MostNeeded(sink)),
        means=Meaning("free room for feedback to {client} of action {action}", rests=True),
    )

    where = [either(sink.capacity, 0) == 0, count(Lowering(sink)) > 0]
