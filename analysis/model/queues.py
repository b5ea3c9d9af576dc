"""The queues of a flattened model: their parts, what they hold, and where they lose messages."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass

from dineros.analysis.model.subject import Subject
from dineros.analysis.model.wording import queue_end, queue_words, source_of
from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.transformations.flattening.traces import Link
from dineros.transformations.language.meaning import QueueKind


@dataclass(frozen=True)
class Entrance:
    """Where messages of one writer enter a queue, or are lost; ids of its transitions.

    The dropping one is enabled exactly when a message would be lost.
    """

    enter: str
    drop: str


@dataclass(frozen=True)
class Queue:
    """A queue of a flattened model.

    Attributes
    ----------
    kind : {"publisher", "dispatcher", "subscriber"}
        Whose it is.
    link : Link
        How its capacity came to be.
    load, capacity : str
        Ids of its places: how many messages wait, and how many more may.
    leave : str
        Id of the transition that passes a message on.
    entrances : tuple of Entrance
        One; of a publisher on a server page one for each server instance.
    """

    kind: QueueKind
    link: Link
    load: str
    capacity: str
    leave: str
    entrances: tuple[Entrance, ...]

    @property
    def drops(self) -> tuple[str, ...]:
        """Ids of its dropping transitions."""
        return tuple(entrance.drop for entrance in self.entrances)

    @property
    def channel(self) -> sym.TopicChannel:
        """The topic it belongs to."""
        return source_of(self.link, sym.TopicChannel)

    @property
    def elements(self) -> tuple[str, ...]:
        """Ids of the topic, and of the publisher's or subscriber's place or the dispatcher's node net."""
        return (self.channel.id, str(getattr(queue_end(self.link), "id", "")))

    def __str__(self) -> str:
        return queue_words(self.link)


def queues(subject: Subject) -> list[Queue]:
    """Return the queues of a flattened model, publishers' first."""
    return queues_of(subject.links())


def queues_of(links: Iterable[Link]) -> list[Queue]:
    """Return the queues among the elements made, in the order of their capacities."""
    parts: dict[tuple[EObject, EObject], dict[str, list[Link]]] = defaultdict(lambda: defaultdict(list))
    for link in links:
        if link.meaning is not None and link.meaning.queue and isinstance(link.target, pn.Node):
            parts[source_of(link, sym.TopicChannel), _end(link)][link.meaning.part].append(link)
    return [_queue(found) for found in parts.values() if "capacity" in found]


def _end(link: Link) -> EObject:
    """Return what tells the queues of a topic apart: the port, or the node net of a dispatcher."""
    port = next((source for source in link.sources if isinstance(source, sym.TopicPort)), None)
    return source_of(link, sym.NodeNet) if port is None else port


def _queue(parts: dict[str, list[Link]]) -> Queue:
    (load,), (capacity,), (leave,) = parts["load"], parts["capacity"], parts["leave"]
    drops = {link.application: link.target.id for link in parts["drop"]}
    entrances = tuple(Entrance(link.target.id, drops[link.application]) for link in parts["enter"])
    assert capacity.meaning is not None and capacity.meaning.queue is not None
    return Queue(
        capacity.meaning.queue, capacity, load.target.id, capacity.target.id, leave.target.id, entrances
    )
