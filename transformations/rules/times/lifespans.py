"""Lifespans of messages of ROS 2 (rule D10): a message that is too old is removed before it is taken.

Each message has a clock for its age from its publication on. A reader history is first in, first out, and
lifespans of a pair are equal; so the oldest message is the first to go, whether it is taken, displaced or too
old. The number of those that went before their time shows whether the message of a clock that ends is still
there. If it is still on its way, it goes when it arrives, and does not enter the history.

If clocks are not possible, a message may go at any time.
"""

from __future__ import annotations

from dineros.metamodel.records import Drop
from dineros.transformations.language import Index, Made, Meaning, less
from dineros.transformations.rules.histories import PAIR, R2, R3, READER
from dineros.transformations.rules.notation import (
    arc,
    arcs_at,
    inhibit,
    place,
    read,
    topic_with_ports,
    transition,
)
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.message_times import AgesAtOnce, HasLifespan, Lifespan
from dineros.transformations.rules.times.clocks import Clock


def _expires() -> Meaning:
    return Meaning(
        "a message of {publisher} for {subscriber} (topic {topic}) is older than its lifespan",
        step=Drop,
        queue="subscriber",
        called=READER,
        part="expire",
    )


class D10(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """A message that is too old leaves the reader history."""

    channel, writer, reader = topic_with_ports()
    written = Made(R2.queue, of=[writer, reader])
    received = Made(R3.received, of=reader)
    history = Made(R3.queue, of=reader)

    ages = place(
        f"{PAIR}.ages", means=Meaning("a message of {publisher} for {subscriber} (topic {topic}) is new")
    )
    old = place(
        f"{PAIR}.old",
        means=Meaning("the lifespan of a message of {publisher} for {subscriber} (topic {topic}) is over"),
    )
    gone = place(
        f"{PAIR}.gone",
        means=Meaning("a message of {publisher} for {subscriber} (topic {topic}) went before its lifespan"),
    )
    lapse = transition(
        f"{PAIR}.lapse",
        means=Meaning("the age of a message of {publisher} for {subscriber} (topic {topic}) is over"),
        at_once=True,
    )
    expire = transition(f"{PAIR}.expire", means=_expires(), at_once=True)
    stale = transition(f"{PAIR}.stale", means=_expires(), at_once=True)
    arcs = [
        arc(written.leave, ages),
        arc(history.leave, gone),
        arc(history.drop, gone),
        arc(old, lapse),
        arc(gone, lapse),
        *arcs_at(expire, [old, history.load], [history.capacity], without=[gone]),
        *arcs_at(stale, [old, received], [], without=[gone, history.load]),
        inhibit(old, history.enter),
        inhibit(old, history.drop),
        inhibit(old, history.leave),
    ]

    where = [AgesAtOnce(writer, reader) > 0]


class D10Clock(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """Each message in a reader history has a clock for its age."""

    channel, writer, reader = topic_with_ports()
    ages = Made(D10.ages, of=[writer, reader])
    old = Made(D10.old, of=[writer, reader])
    number = Index(upto=AgesAtOnce(writer, reader))

    clock = Clock(
        f"{PAIR}.age[{{number}}]",
        source=ages,
        target=old,
        within=Lifespan(writer, reader),
        begins="the age of a message of {publisher} for {subscriber} (topic {topic}) begins",
        runs="a message of {publisher} for {subscriber} (topic {topic}) is younger than its lifespan",
        ends="the lifespan of a message of {publisher} for {subscriber} (topic {topic}) ends",
    )


class D10Order(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """The age of a message takes the first free clock."""

    channel, writer, reader = topic_with_ports()
    number = Index(upto=AgesAtOnce(writer, reader))
    clock = Made(D10Clock.clock, of=[writer, reader, number])
    lower = Index(upto=less(number, 1))
    before = Made(D10Clock.clock, of=[writer, reader, lower])

    waits = read(before.busy, clock.begin)


class D10Open(StandardRule, phase=Phase.timing, middleware="ros2", times=True):
    """Without clocks for ages, a message may leave the reader history at any time."""

    channel, writer, reader = topic_with_ports()
    written = Made(R2.queue, of=[writer, reader])
    history = Made(R3.queue, of=reader)

    expire = transition(f"{PAIR}.expire", means=_expires())
    arcs = [arc(history.load, expire), arc(expire, history.capacity)]

    where = [HasLifespan(writer, reader), ~(AgesAtOnce(writer, reader) > 0)]
