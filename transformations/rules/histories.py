"""Topics of ROS 2: a history for each writer and reader (rules R1 to R4).

A writer that keeps its last messages discards the oldest one, even if some reader has not received it. The
messages that a reader has not received are always the last ones written; so there is one history for each
pair of writer and reader. Losing the oldest or the newest message gives the same numbers of tokens (OMG, Data
Distribution Service 1.4, 2015, Sect. 2.2.3.18).
"""

from __future__ import annotations

from collections.abc import Mapping

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.elements import node_net_of
from dineros.metamodel.matching import are_matched, is_best_effort
from dineros.metamodel.records import Drop, Publish, Take
from dineros.transformations.language import TRUTH, Expression, ForAll, Fragment, Meaning, New
from dineros.transformations.language.errors import LANGUAGE
from dineros.transformations.language.functions import Query, enclosing
from dineros.transformations.language.patterns import Absent, Made, Node
from dineros.transformations.rules.notation import (
    Bound,
    OverflowQueue,
    arc,
    place,
    topic_with_ports,
    transition,
)
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.queries.times import PublishesWithoutEnd
from dineros.transformations.rules.services import S4, CopiedPublisher

LANGUAGE.add(__name__)

PAIR = "{channel.id}.writer.{writer.place.id}.{reader.place.id}"
"""Prefix of ids of the writer history of a pair."""
WRITER = "writer history of {publisher} for {subscriber} (topic {topic})"
READER = "reader history of {subscriber} (topic {topic})"


class Matched(Query):
    """Whether a publisher's messages reach a subscriber, according to their quality of service."""

    datatype = TRUTH
    _words = "{} and {} are matched"
    _answer = staticmethod(are_matched)


def _is_managed(port: sym.TopicPort) -> bool:
    node = node_net_of(port.place)
    return node is not None and node.lifecycle is not None


class Managed(Query):
    """Whether a port belongs to a managed node, which may start and stop."""

    datatype = TRUTH
    _words = "node of {} is managed"
    _answer = staticmethod(_is_managed)


class AnyManaged(Query):
    """Whether one of two ports belongs to a managed node."""

    datatype = TRUTH
    _words = "node of {} or {} is managed"

    @staticmethod
    def _answer(writer: sym.TopicPort, reader: sym.TopicPort) -> bool:
        return _is_managed(writer) or _is_managed(reader)


class BestEffort(Query):
    """Whether one of two ports has best-effort reliability."""

    datatype = TRUTH
    _words = "{} or {} is bestEffort"
    _answer = staticmethod(is_best_effort)


class Publication(Fragment):
    """Messages leave the place of a publisher.

    Parameters
    ----------
    id : str
        Id of the transition; may have placeholders.
    source : Expression
        The place of the publisher.
    """

    roles: Mapping[str, type[EObject]] = {"source": pn.Place, "publish": pn.Transition}
    publish: New

    def __init__(self, id: str, source: Expression) -> None:
        super().__init__(source=source)
        words = "{publisher} publishes a message on topic {topic}{writer}"
        means = Meaning(words, step=Publish, queue="publisher", called=WRITER, part="transport")
        self.publish = transition(id, means, at_once=True)
        self.arcs = [arc(source, self.publish)]


class R3(StandardRule, phase=Phase.publications, middleware="ros2"):
    """Reader history of each subscriber port."""

    channel = Node(sym.TopicChannel)
    reader = Node(sym.SubscriberPort, channel=channel)
    sink = Node(pn.Place, of=reader.place)

    received = place(
        "{channel.id}.reader.{sink.id}.In",
        means=Meaning("{queue}: arriving messages", queue="subscriber", called=READER, part="received"),
        carries=True,
    )
    queue = OverflowQueue(
        "{channel.id}.reader.{sink.id}",
        source=received,
        limit=reader.limit,
        sinks=[sink],
        kind="subscriber",
        called=READER,
        leaves=Take,
    )


class R2(StandardRule, phase=Phase.publications, middleware="ros2"):
    """Writer history of each publisher port for each subscriber port that matches it."""

    channel, writer, reader = topic_with_ports()
    received = Made(R3.received, of=reader)

    written = place(
        f"{PAIR}.In",
        means=Meaning("{queue}: published messages", queue="publisher", called=WRITER, part="received"),
        carries=True,
    )
    queue = OverflowQueue(
        PAIR,
        source=written,
        limit=writer.limit,
        sinks=[received],
        kind="publisher",
        called=WRITER,
    )

    where = [Matched(writer, reader)]


class WriterRoom(Bound):
    """Room for one published message, before the writer history takes it."""

    def __init__(self, written: Expression) -> None:
        means = Meaning("{queue}: room for a published message", called=WRITER, rests=True)
        super().__init__(written, 1, means)


class ReaderRoom(Bound):
    """Room for one arriving message, before the reader history takes it."""

    def __init__(self, received: Expression) -> None:
        means = Meaning("{queue}: room for an arriving message", called=READER, rests=True)
        super().__init__(received, 1, means)


class R3Room(StandardRule, phase=Phase.publications, middleware="ros2", times=False):
    """One message at a time arrives; with times, none waits there."""

    channel = Node(sym.TopicChannel)
    reader = Node(sym.SubscriberPort, channel=channel)
    received = Made(R3.received, of=reader)

    bound = ReaderRoom(received)


class R3RoomManaged(StandardRule, phase=Phase.publications, middleware="ros2", times=True):
    """One message at a time arrives at a node that comes and goes."""

    channel = Node(sym.TopicChannel)
    reader = Node(sym.SubscriberPort, channel=channel)
    received = Made(R3.received, of=reader)

    bound = ReaderRoom(received)

    where = [Managed(reader)]


class R2Room(StandardRule, phase=Phase.publications, middleware="ros2", times=False):
    """One published message at a time is written."""

    channel, writer, reader = topic_with_ports()
    written = Made(R2.written, of=[writer, reader])

    bound = WriterRoom(written)


class R2RoomManaged(StandardRule, phase=Phase.publications, middleware="ros2", times=True):
    """One published message at a time is written if a node at one end comes and goes."""

    channel, writer, reader = topic_with_ports()
    written = Made(R2.written, of=[writer, reader])

    bound = WriterRoom(written)

    where = [AnyManaged(writer, reader)]


class R2RoomOpen(StandardRule, phase=Phase.publications, middleware="ros2", times=True):
    """One published message at a time is written if nothing bounds how many are published in no time."""

    channel, writer, reader = topic_with_ports()
    written = Made(R2.written, of=[writer, reader])

    bound = WriterRoom(written)

    where = [~AnyManaged(writer, reader), PublishesWithoutEnd(writer, reader)]


class R1(StandardRule, phase=Phase.publications, middleware="ros2"):
    """A publisher port writes to all its histories at once; without a history, the message is discarded."""

    channel = Node(sym.TopicChannel)
    writer = Node(sym.PublisherPort, channel=channel)
    source = Node(pn.Place, of=writer.place)

    publication = Publication("{channel.id}.publisher.{source.id}.publish", source)
    written = Made(R2.written, of=writer)
    writes = ForAll([written], make=[arc(publication.publish, written)])

    around = Node(pn.Page, of=enclosing(writer.place, pn.Page))
    server = Node(sym.ServerPort, page=around)
    slots = Node(sym.ActionServerPort, page=around)
    absent = [Absent(around, server), Absent(around, slots)]


class R1Instance(StandardRule, phase=Phase.publications, middleware="ros2"):
    """Each instance of a server page writes to the histories of the node's one writer."""

    copied = CopiedPublisher(sym.ServerPort, S4.page)

    publication = Publication("{channel.id}.publisher.{source.id}.publish", copied.source)
    written = Made(R2.written, of=copied.port)
    writes = ForAll([written], make=[arc(publication.publish, written)])


class R4(StandardRule, phase=Phase.deliveries, middleware="ros2"):
    """A message between two ports may be lost on the way where one of them is best-effort."""

    channel, writer, reader = topic_with_ports()
    queue = Made(R2.queue, of=[writer, reader])

    lose = transition(
        f"{PAIR}.lose",
        Meaning(
            "a message of the {queue} is lost on the way",
            step=Drop,
            queue="publisher",
            called=WRITER,
            part="lose",
        ),
    )
    arcs = [arc(queue.load, lose), arc(lose, queue.capacity)]

    where = [BestEffort(writer, reader)]
