"""Publishing on the page of a slot while it executes a goal (families A, R and T together)."""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.metamodel.records import Publish
from dineros.transformations.language import ForAll, Made
from dineros.transformations.rules.actions.slots import A6
from dineros.transformations.rules.histories import R2, Publication
from dineros.transformations.rules.notation import History, OverflowQueue, arc
from dineros.transformations.rules.phases import Phase, StandardRule
from dineros.transformations.rules.services import CopiedPublisher, PagePublisher
from dineros.transformations.rules.topics import T1


class T2SlotHistory(StandardRule, phase=Phase.publications, middleware="ros1"):
    """Send queue of a publisher port on the page of an action's server: one for all slots."""

    on_page = PagePublisher(sym.ActionServerPort)
    topic = Made(T1.topic, of=on_page.channel)

    queue = History(
        "{channel.id}.publisher.{port.place.id}", limit=on_page.port.limit, sinks=[topic], kind="publisher"
    )


class T2Slot(StandardRule, phase=Phase.publications, middleware="ros1"):
    """Each slot writes to the publisher's one send queue, or loses its message."""

    copied = CopiedPublisher(sym.ActionServerPort, A6.page)
    history = Made(T2SlotHistory.queue, of=copied.port)

    queue = OverflowQueue(
        "{channel.id}.publisher.{source.id}",
        source=copied.source,
        history=history,
        kind="publisher",
        enters=Publish,
    )


class R1Slot(StandardRule, phase=Phase.publications, middleware="ros2"):
    """Each slot of an action's server writes to the histories of the node's one writer."""

    copied = CopiedPublisher(sym.ActionServerPort, A6.page)

    publication = Publication("{channel.id}.publisher.{source.id}.publish", copied.source)
    written = Made(R2.written, of=copied.port)
    writes = ForAll([written], make=[arc(publication.publish, written)])
