"""Deadlines of subscriptions of ROS 2 (rule D9): the node is notified that no message arrived.

The deadline runs from the first message that the node takes, and restarts at each further one. When it ends,
the node gets one token; if the place is full, it gets the token as soon as there is room, unless a message
arrives before. After that, a further token requires a message before it.
"""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.matching import quality_of
from dineros.metamodel.records import Miss
from dineros.transformations.language import REAL, Made, Meaning, New, Node, Path, Query
from dineros.transformations.rules.histories import R3
from dineros.transformations.rules.notation import Bound, arc, arcs_at, place, transition
from dineros.transformations.rules.phases import Phase, StandardRule


class Deadline(Query):
    """The deadline of a subscription, in seconds."""

    datatype = REAL
    _words = "deadline of {}"

    @staticmethod
    def _answer(reader: sym.SubscriberPort) -> float | None:
        return quality_of(reader).deadline


def _restarts() -> Meaning:
    return Meaning("the deadline of {subscriber} (topic {topic}) begins again", part="follow-up")


class D9(StandardRule, phase=Phase.deliveries, middleware="ros2"):
    """A node that has taken no message for the deadline of a subscription gets a token."""

    channel = Node(sym.TopicChannel)
    reader = Node(sym.SubscriberPort, channel=channel)
    missed = Node(pn.Place, of=reader.missed)
    history = Made(R3.queue, of=reader)

    taken = place(
        "{channel.id}.deadline.{missed.id}.taken",
        means=Meaning("{subscriber} (topic {topic}) has just taken a message", part="watch"),
    )
    idle = place(
        "{channel.id}.deadline.{missed.id}.idle",
        tokens=1,
        means=Meaning("no deadline of {subscriber} (topic {topic}) runs", part="watch", rests=True),
    )
    runs = place(
        "{channel.id}.deadline.{missed.id}.runs",
        means=Meaning("the deadline of {subscriber} (topic {topic}) runs", part="watch", rests=True),
    )
    room = Bound(
        taken,
        1,
        Meaning("{subscriber} (topic {topic}) has not just taken a message", part="watch", rests=True),
    )
    over = place(
        "{channel.id}.deadline.{missed.id}.over",
        means=Meaning("the deadline of {subscriber} (topic {topic}) is over", part="watch"),
    )
    begin = transition("{channel.id}.deadline.{missed.id}.begin", means=_restarts(), at_once=True)
    again = transition("{channel.id}.deadline.{missed.id}.again", means=_restarts(), at_once=True)
    late = transition("{channel.id}.deadline.{missed.id}.late", means=_restarts(), at_once=True)
    end = transition(
        "{channel.id}.deadline.{missed.id}.end",
        means=Meaning("the deadline of {subscriber} (topic {topic}) ends", part="unrecorded"),
    )
    miss = transition(
        "{channel.id}.deadline.{missed.id}.miss",
        means=Meaning("{subscriber} misses a message of topic {topic}", step=Miss, queue="subscriber"),
        at_once=True,
    )
    arcs = [
        arc(history.leave, taken),
        *arcs_at(begin, [taken, idle], [runs]),
        *arcs_at(again, [taken, runs], [runs]),
        *arcs_at(late, [taken, over], [runs]),
        arc(runs, end),
        arc(end, over),
        *arcs_at(miss, [over], [idle, missed]),
    ]


class D9Time(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """The deadline ends after its time, not before."""

    reader = Node(sym.SubscriberPort)
    end = Made(D9.end, of=reader)

    waits = New(
        pn.TimeInterval, into=Path(end, "interval"), earliest=Deadline(reader), latest=Deadline(reader)
    )
