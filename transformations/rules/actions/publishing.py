"""What a slot's page publishes while it works on a goal (families A, R and T together)."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.records import Publish
from dineros.transformations.language.creation import ForAll, image
from dineros.transformations.language.functions import enclosing
from dineros.transformations.language.patterns import Made, Node
from dineros.transformations.rules.actions.slots import A6
from dineros.transformations.rules.histories import R2, Publication
from dineros.transformations.rules.notation import History, OverflowQueue, arc
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.topics import T1


class T2SlotHistory(StandardRule, phase=Phase.publications, middleware="ros1"):
    """Send queue of a publisher port on the page of an action's server: one for all slots."""

    channel = Node(sym.TopicChannel)
    port = Node(sym.PublisherPort, channel=channel)
    around = Node(pn.Page, of=enclosing(port.place, pn.Page))
    server = Node(sym.ActionServerPort, page=around)
    topic = Made(T1.topic, of=channel)

    queue = History(
        "{channel.id}.publisher.{port.place.id}", limit=port.limit, sinks=[topic], kind="publisher"
    )


class T2Slot(StandardRule, phase=Phase.publications, middleware="ros1"):
    """Each slot writes to the publisher's one send queue, or loses its message."""

    channel = Node(sym.TopicChannel)
    port = Node(sym.PublisherPort, channel=channel)
    history = Made(T2SlotHistory.queue, of=port)
    around = Node(pn.Page, of=enclosing(port.place, pn.Page))
    server = Node(sym.ActionServerPort, page=around)
    page = Made(A6.page, of=server)
    source = Node(pn.Place, of=image(port.place, page))

    queue = OverflowQueue(
        "{channel.id}.publisher.{source.id}",
        source=source,
        history=history,
        kind="publisher",
        enters=Publish,
    )


class R1Slot(StandardRule, phase=Phase.publications, middleware="ros2"):
    """Each slot of an action's server writes to the histories of the node's one writer."""

    channel = Node(sym.TopicChannel)
    writer = Node(sym.PublisherPort, channel=channel)
    around = Node(pn.Page, of=enclosing(writer.place, pn.Page))
    server = Node(sym.ActionServerPort, page=around)
    page = Made(A6.page, of=server)
    source = Node(pn.Place, of=image(writer.place, page))

    publication = Publication("{channel.id}.publisher.{source.id}.publish", source)
    written = Made(R2.written, of=writer)
    writes = ForAll([written], make=[arc(publication.publish, written)])
