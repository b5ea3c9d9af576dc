"""Messages between managed nodes that start and stop (rules L4 and L5).

A reader that is not configured receives nothing: messages written for it are discarded. If both ends are
transient-local and reliable, its history at the writer fills up instead, and is delivered when the reader is
configured. A reader that is configured again gets the messages that the writer still keeps once more (DDS
1.4, Sect. 2.2.3.4; observed with Fast DDS). Messages that a node had when it was cleaned up no longer exist
when it is configured again.
"""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.metamodel.matching import is_kept
from dineros.metamodel.records import Drop, Transfer
from dineros.metamodel.records.schema import Step
from dineros.transformations.language import TRUTH, Made, Meaning, New, Node, Query, ancestor
from dineros.transformations.language.errors import LANGUAGE
from dineros.transformations.rules.histories import PAIR, R2, R3, WRITER, ReaderRoom, WriterRoom
from dineros.transformations.rules.lifecycle import L1, Configuring, L1Shutdown, Leaves, Leaving
from dineros.transformations.rules.notation import arc, arcs_at, place, read, topic_with_ports, transition
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.services import Home

LANGUAGE.add(__name__)


class Kept(Query):
    """Whether a late reader gets messages written earlier."""

    datatype = TRUTH
    _words = "{} keeps messages for a late {}"
    _answer = staticmethod(is_kept)


def _step(part: str, words: str, step: type[Step] = Drop) -> New:
    """Return a transition of a pair's writer history; usually, a message is lost."""
    return transition(
        f"{PAIR}.{part}", Meaning(words, step=step, queue="publisher", called=WRITER, part=part)
    )


MISSED = "a message of {publisher} on topic {topic} is lost: {subscriber} of node net {reading} is not there"


class L4(StandardRule, phase=Phase.appearing, middleware="ros2"):
    """A message for a reader that is not configured is lost."""

    channel, writer, reader = topic_with_ports()
    node = Node(sym.NodeNet, of=ancestor(reader.place, sym.NodeNet))
    written = Made(R2.written, of=[writer, reader])
    queue = Made(R2.queue, of=[writer, reader])
    configured = Made(L1.configured, of=node)
    away = Made(L1.away, of=node)

    miss = _step("miss", MISSED)
    arcs = [arc(written, miss), read(away, miss)]
    waits = [read(configured, queue.enter), read(configured, queue.drop)]

    where = [~Kept(writer, reader)]


class L4Kept(StandardRule, phase=Phase.appearing, middleware="ros2"):
    """If late readers get what a writer keeps, only messages for a node that was shut down are lost."""

    channel, writer, reader = topic_with_ports()
    node = Node(sym.NodeNet, of=ancestor(reader.place, sym.NodeNet))
    written = Made(R2.written, of=[writer, reader])
    queue = Made(R2.queue, of=[writer, reader])
    existing = Made(L1Shutdown.existing, of=node)
    finalized = Made(L1.finalized, of=node)

    miss = _step("miss", MISSED)
    arcs = [arc(written, miss), read(finalized, miss)]
    waits = [read(existing, queue.enter), read(existing, queue.drop)]

    where = [Kept(writer, reader)]


class L4Deliver(StandardRule, phase=Phase.appearing, middleware="ros2"):
    """Messages are delivered to a reader that is configured."""

    writer = Node(sym.PublisherPort)
    reader = Node(sym.SubscriberPort)
    node = Node(sym.NodeNet, of=ancestor(reader.place, sym.NodeNet))
    queue = Made(R2.queue, of=[writer, reader])
    configured = Made(L1.configured, of=node)

    waits = read(configured, queue.leave)


class L4Settled(StandardRule, phase=Phase.appearing, middleware="ros2"):
    """A node leaves only after all messages written for it while it was there are in the history.

    So each message that is missed was written while its reader was not there.
    """

    writer = Node(sym.PublisherPort)
    reader = Node(sym.SubscriberPort)
    node = Node(sym.NodeNet, of=ancestor(reader.place, sym.NodeNet))
    bound = Made(WriterRoom, of=[writer, reader])
    change = Made(Leaving, of=node)

    waits = read(bound.free, change.move)

    where = [~Kept(writer, reader)]


class L4SettledKept(StandardRule, phase=Phase.appearing, middleware="ros2"):
    """If a late reader gets the message, only a node that is shut down waits for that."""

    writer = Node(sym.PublisherPort)
    reader = Node(sym.SubscriberPort)
    node = Node(sym.NodeNet, of=ancestor(reader.place, sym.NodeNet))
    bound = Made(WriterRoom, of=[writer, reader])
    at_once = Made(L1Shutdown.at_once, of=node)
    while_inactive = Made(L1Shutdown.while_inactive, of=node)
    while_active = Made(L1Shutdown.while_active, of=node)

    waits = [
        read(bound.free, at_once.move),
        read(bound.free, while_inactive.move),
        read(bound.free, while_active.move),
    ]

    where = [Kept(writer, reader)]


LEFT = "a message of the {queue} is lost: node net {reading} is not there any more"


class L4Left(StandardRule, phase=Phase.appearing, middleware="ros2"):
    """Messages that are not delivered before their reader leaves are lost."""

    channel, writer, reader = topic_with_ports()
    node = Node(sym.NodeNet, of=ancestor(reader.place, sym.NodeNet))
    life = Node(sym.Lifecycle, of=node.lifecycle)
    queue = Made(R2.queue, of=[writer, reader])
    away = Made(L1.away, of=node)

    left = _step("left", LEFT)
    arcs = [arc(queue.load, left), arc(left, queue.capacity), read(away, left)]

    where = [~Kept(writer, reader), Leaves(life)]


class L4LeftKept(StandardRule, phase=Phase.appearing, middleware="ros2"):
    """Messages stored for a late reader are lost when it is shut down."""

    channel, writer, reader = topic_with_ports()
    node = Node(sym.NodeNet, of=ancestor(reader.place, sym.NodeNet))
    life = Node(sym.Lifecycle, of=node.lifecycle, shutsDown=True)
    queue = Made(R2.queue, of=[writer, reader])
    finalized = Made(L1.finalized, of=node)

    left = _step("left", LEFT)
    arcs = [arc(queue.load, left), arc(left, queue.capacity), read(finalized, left)]

    where = [Kept(writer, reader)]


class L4Gone(StandardRule, phase=Phase.appearing, middleware="ros2"):
    """Messages that a writer has not delivered when it leaves are lost."""

    channel, writer, reader = topic_with_ports()
    node = Node(sym.NodeNet, of=Home(writer.place))
    life = Node(sym.Lifecycle, of=node.lifecycle)
    queue = Made(R2.queue, of=[writer, reader])
    away = Made(L1.away, of=node)

    gone = _step("gone", "a message of the {queue} is lost: node net {writing} is not there any more")
    arcs = [arc(queue.load, gone), arc(gone, queue.capacity), read(away, gone)]

    where = [Leaves(life)]


class L4Written(StandardRule, phase=Phase.appearing, middleware="ros2"):
    """A writer's history is empty when its node is configured."""

    writer = Node(sym.PublisherPort)
    node = Node(sym.NodeNet, of=Home(writer.place))
    life = Node(sym.Lifecycle, of=node.lifecycle, cleansUp=True)
    queue = Made(R2.queue, of=writer)
    change = Made(Configuring, of=node)

    waits = read(queue.capacity, change.move, weight=queue.capacity.tokens)


class L4Read(StandardRule, phase=Phase.appearing, middleware="ros2"):
    """A history that keeps nothing for a late reader is empty when the reader's node is configured."""

    writer = Node(sym.PublisherPort)
    reader = Node(sym.SubscriberPort)
    node = Node(sym.NodeNet, of=ancestor(reader.place, sym.NodeNet))
    life = Node(sym.Lifecycle, of=node.lifecycle, cleansUp=True)
    queue = Made(R2.queue, of=[writer, reader])
    change = Made(Configuring, of=node)

    waits = read(queue.capacity, change.move, weight=queue.capacity.tokens)

    where = [~Kept(writer, reader), Home(writer.place) != node]


class L4Clear(StandardRule, phase=Phase.appearing, middleware="ros2"):
    """Messages in a reader's history are lost when its node is cleaned up or shut down."""

    channel = Node(sym.TopicChannel)
    reader = Node(sym.SubscriberPort, channel=channel)
    node = Node(sym.NodeNet, of=ancestor(reader.place, sym.NodeNet))
    life = Node(sym.Lifecycle, of=node.lifecycle)
    received = Made(R3.received, of=reader)
    queue = Made(R3.queue, of=reader)
    away = Made(L1.away, of=node)

    words = "a message for {subscriber} on topic {topic} is lost: node net {reading} is not there any more"
    gone = transition(
        "{channel.id}.reader.{reader.place.id}.gone",
        Meaning(words, step=Drop, queue="subscriber", part="gone"),
    )
    clear = transition(
        "{channel.id}.reader.{reader.place.id}.clear",
        Meaning(words, step=Drop, queue="subscriber", part="clear"),
    )
    loses = [arc(received, gone), read(away, gone)]
    clears = [arc(queue.load, clear), arc(clear, queue.capacity), read(away, clear)]

    where = [Leaves(life)]


class L4Cleared(StandardRule, phase=Phase.appearing, middleware="ros2"):
    """A reader's history is empty when its node is configured."""

    reader = Node(sym.SubscriberPort)
    node = Node(sym.NodeNet, of=ancestor(reader.place, sym.NodeNet))
    life = Node(sym.Lifecycle, of=node.lifecycle, cleansUp=True)
    bound = Made(ReaderRoom, of=reader)
    queue = Made(R3.queue, of=reader)
    change = Made(Configuring, of=node)

    waits = [
        read(bound.free, change.move),
        read(queue.capacity, change.move, weight=queue.capacity.tokens),
    ]


class L5(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """A writer keeps what it has delivered, for a late reader that comes again."""

    channel, writer, reader = topic_with_ports()
    node = Node(sym.NodeNet, of=ancestor(reader.place, sym.NodeNet))
    life = Node(sym.Lifecycle, of=node.lifecycle, cleansUp=True)
    queue = Made(R2.queue, of=[writer, reader])

    delivered = place(
        f"{PAIR}.Delivered",
        means=Meaning("{queue}: delivered and kept", called=WRITER, rests=True),
    )
    undelivered = place(
        f"{PAIR}.Undelivered",
        tokens=writer.limit,
        means=Meaning("{queue}: room for more that is delivered", called=WRITER, rests=True),
    )
    kept = place(
        f"{PAIR}.Kept",
        means=Meaning("{queue}: kept", called=WRITER, rests=True),
    )
    room = place(
        f"{PAIR}.Room",
        tokens=writer.limit,
        means=Meaning("{queue}: room for more to keep", called=WRITER, part="room", rests=True),
    )
    arcs = [
        arc(room, queue.enter),
        arc(queue.enter, kept),
        arc(queue.leave, delivered),
        arc(undelivered, queue.leave),
    ]

    where = [Kept(writer, reader)]


class L5Replace(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """In a full history, a new message replaces the oldest one that is delivered."""

    channel, writer, reader = topic_with_ports()
    written = Made(R2.written, of=[writer, reader])
    queue = Made(R2.queue, of=[writer, reader])
    delivered = Made(L5.delivered, of=[writer, reader])
    undelivered = Made(L5.undelivered, of=[writer, reader])
    kept = Made(L5.kept, of=[writer, reader])

    replace = _step("replace", "{queue} takes a message in place of one that is delivered", Transfer)
    arcs = [
        *arcs_at(replace, [written, delivered, queue.capacity], [undelivered, queue.load]),
        read(kept, replace, weight=writer.limit),
    ]


class L5ReplaceFinalized(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """No message is replaced for a reader that is shut down."""

    writer = Node(sym.PublisherPort)
    reader = Node(sym.SubscriberPort)
    node = Node(sym.NodeNet, of=ancestor(reader.place, sym.NodeNet))
    replace = Made(L5Replace.replace, of=[writer, reader])
    existing = Made(L1Shutdown.existing, of=node)

    waits = read(existing, replace)


class L5Again(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """A reader that is configured again receives again what its writer keeps."""

    channel, writer, reader = topic_with_ports()
    node = Node(sym.NodeNet, of=ancestor(reader.place, sym.NodeNet))
    queue = Made(R2.queue, of=[writer, reader])
    delivered = Made(L5.delivered, of=[writer, reader])
    undelivered = Made(L5.undelivered, of=[writer, reader])
    unconfigured = Made(L1.unconfigured, of=node)

    again = _step("again", "{queue} is to deliver a message again", Transfer)
    arcs = arcs_at(again, [delivered, queue.capacity], [undelivered, queue.load], reads=[unconfigured])


class L5Forget(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """A writer that leaves keeps nothing."""

    channel, writer, reader = topic_with_ports()
    node = Node(sym.NodeNet, of=Home(writer.place))
    gone = Made(L4Gone.gone, of=[writer, reader])
    delivered = Made(L5.delivered, of=[writer, reader])
    undelivered = Made(L5.undelivered, of=[writer, reader])
    kept = Made(L5.kept, of=[writer, reader])
    room = Made(L5.room, of=[writer, reader])
    away = Made(L1.away, of=node)

    forget = _step("forget", "{queue} discards a message that is delivered", Transfer)
    arcs = [arc(delivered, forget), arc(forget, undelivered), read(away, forget)]
    frees = [arc(kept, forget), arc(forget, room), arc(kept, gone), arc(gone, room)]


class L5Left(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """Messages lost with a reader that is shut down free their room."""

    writer = Node(sym.PublisherPort)
    reader = Node(sym.SubscriberPort)
    left = Made(L4LeftKept.left, of=[writer, reader])
    kept = Made(L5.kept, of=[writer, reader])
    room = Made(L5.room, of=[writer, reader])

    frees = [arc(kept, left), arc(left, room)]


class L5Drained(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """Nothing counts as delivered when a late reader's node is configured again."""

    writer = Node(sym.PublisherPort)
    reader = Node(sym.SubscriberPort)
    node = Node(sym.NodeNet, of=ancestor(reader.place, sym.NodeNet))
    undelivered = Made(L5.undelivered, of=[writer, reader])
    change = Made(Configuring, of=node)

    waits = read(undelivered, change.move, weight=writer.limit)


class L5Forgotten(StandardRule, phase=Phase.disappearing, middleware="ros2"):
    """A writer keeps nothing when its node is configured again."""

    writer = Node(sym.PublisherPort)
    node = Node(sym.NodeNet, of=Home(writer.place))
    life = Node(sym.Lifecycle, of=node.lifecycle, cleansUp=True)
    room = Made(L5.room, of=writer)
    change = Made(Configuring, of=node)

    waits = read(room, change.move, weight=writer.limit)
