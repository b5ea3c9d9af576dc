"""The queues of a flattened model: what they hold, and where they lose messages."""

from __future__ import annotations

from dataclasses import dataclass

from dineros.analysis.model.subject import Subject
from dineros.analysis.model.wording import queue_words
from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.transformations.flattening.traces import Link


@dataclass(frozen=True)
class Queue:
    """A queue of a flattened model.

    Attributes
    ----------
    link : Link
        How its capacity came to be.
    drops : tuple of str
        Ids of its dropping transitions: one is enabled exactly when a message would be lost. A publisher on a
        server page has one for each server instance.
    """

    link: Link
    drops: tuple[str, ...]

    @property
    def channel(self) -> sym.TopicChannel:
        """The topic it belongs to."""
        return next(source for source in self.link.sources if isinstance(source, sym.TopicChannel))

    @property
    def elements(self) -> tuple[str, ...]:
        """Ids of the topic, and of the publisher's or subscriber's place or the dispatcher's node net."""
        ends = [
            source.place.id if isinstance(source, sym.TopicPort) else source.id
            for source in self.link.sources
            if isinstance(source, (sym.TopicPort, sym.NodeNet))
        ]
        return (self.channel.id, *ends[:1])

    def __str__(self) -> str:
        return queue_words(self.link)


def queues(subject: Subject) -> list[Queue]:
    """Return the queues of a flattened model, publishers' first."""
    drops: dict[tuple[EObject, ...], list[str]] = {}
    for link in subject.links():
        if link.role == "queue.drop" and isinstance(link.target, pn.Transition):
            drops.setdefault(_ends(link), []).append(link.target.id)
    return [
        Queue(link, tuple(drops.get(_ends(link), ())))
        for link in subject.links()
        if link.role == "queue.capacity" and isinstance(link.target, pn.Place)
    ]


def _ends(link: Link) -> tuple[EObject, ...]:
    """Return what tells queues apart: the topic, and the port or the node net of a dispatcher."""
    kinds = (sym.TopicChannel, sym.TopicPort) if link.rule != "T3" else (sym.TopicChannel, sym.NodeNet)
    return tuple(source for source in link.sources if isinstance(source, kinds))
