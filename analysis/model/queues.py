"""The queues of a flattened model: their parts, what they hold, and where they lose messages."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass

from dineros.analysis.model.subject import Subject
from dineros.analysis.model.wording import queue_end, queue_words, source_of, topic_port
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
    together: dict[int, dict[str, Link]] = defaultdict(dict)
    for link in links:
        if link.meaning is not None and link.meaning.queue and isinstance(link.target, pn.Node):
            together[link.application][link.meaning.part] = link
    # The instances of a server page have entrances to the one queue of a publisher on it.
    shared: dict[tuple[EObject, EObject], list[dict[str, Link]]] = defaultdict(list)
    for parts in together.values():
        if "capacity" not in parts and "enter" in parts:
            shared[_ends(parts["enter"])].append(parts)
    return [_queue(parts, shared) for parts in together.values() if "capacity" in parts]


def _ends(link: Link) -> tuple[EObject, EObject]:
    """Return the topic, and the port or the node net of a dispatcher."""
    return source_of(link, sym.TopicChannel), topic_port(link) or source_of(link, sym.NodeNet)


def _queue(parts: dict[str, Link], shared: dict[tuple[EObject, EObject], list[dict[str, Link]]]) -> Queue:
    capacity = parts["capacity"]
    assert capacity.meaning is not None and capacity.meaning.queue is not None
    entering = [parts] if "enter" in parts else shared[_ends(capacity)]
    entrances = tuple(Entrance(found["enter"].target.id, found["drop"].target.id) for found in entering)
    places = parts["load"].target.id, capacity.target.id
    return Queue(capacity.meaning.queue, capacity, *places, parts["leave"].target.id, entrances)
