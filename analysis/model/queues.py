"""The queues of a flattened model: their parts, what they hold, and where they lose messages and requests."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from dineros.analysis.model.subject import Subject
from dineros.analysis.model.wording import queue_end, queue_words, source_of, topic_port
from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.matching import quality_of

if TYPE_CHECKING:
    from dineros.transformations.flattening.traces import Link
    from dineros.transformations.language.meaning import QueueKind

Channel: TypeAlias = sym.TopicChannel | sym.ServiceChannel | sym.ActionChannel
_End: TypeAlias = "tuple[EObject, QueueKind | None, EObject | None]"
_LOSSES: dict[QueueKind, str] = {
    "request": "a request is lost",
    "response": "a response is lost",
    "feedback": "feedback is lost",
    "goal": "a goal is lost",
    "result": "a result is lost",
    "answer": "an answer to a goal is lost",
}


@dataclass(frozen=True)
class Entrance:
    """Where messages of one writer enter a queue, or are lost; ids of its transitions.

    The dropping one is enabled exactly when a message would be lost.
    """

    enter: str
    drop: str


@dataclass(frozen=True)
class Queue:
    """A queue of a flattened model."""

    kind: QueueKind
    """Whose it is; ``request``: a service's; ``response``: that of a service's client; ``goal``: an action's;
    ``feedback``, ``result``, ``answer``: that of an action's client.
    """
    link: Link
    """How its capacity came to be."""
    load: str
    capacity: str
    """`load`, `capacity`: ids of its places: how many messages wait, and how many more may."""
    leave: str | None
    """Id of the transition that passes a message on; None of a service, whose calls take requests."""
    entrances: tuple[Entrance, ...]
    """One; of a publisher on a server page one for each server instance, of a service or of an action's goals
    one for each client, of a client's results or answers one for each kind.
    """

    @property
    def drops(self) -> tuple[str, ...]:
        """Ids of its dropping transitions."""
        return tuple(entrance.drop for entrance in self.entrances)

    @property
    def channel(self) -> Channel:
        """The topic, service or action it belongs to."""
        return _channel(self.link)

    @property
    def elements(self) -> tuple[str, ...]:
        """Ids of the channel, and of the port's place, the dispatcher's node net, the server's entry."""
        return (self.channel.id, str(getattr(queue_end(self.link), "id", "")))

    @property
    def may_lose(self) -> bool:
        """Whether the model allows losses: its publishers are best-effort, or it holds feedback."""
        if self.kind == "feedback":
            return True
        if not isinstance(self.channel, sym.TopicChannel):
            return False
        return all(
            quality_of(port).reliability == sym.Reliability.bestEffort for port in self.channel.publishers
        )

    @property
    def reader_of_newest(self) -> sym.SubscriberPort | None:
        """The reader, if it needs the newest message only and the queue forgets older messages first.

        Only the histories of ROS 2 do. With the rules of ``ros1``, a message that arrives at a full queue is
        lost itself.
        """
        from dineros.transformations.rules.histories import R2, R3

        if self.link.maker not in (R2, R3):
            return None
        reader = next(each for each in self.link.sources if isinstance(each, sym.SubscriberPort))
        return reader if reader.newestOnly else None

    @property
    def loss(self) -> str:
        """What happens where it overflows."""
        return _LOSSES.get(self.kind, "a message is lost")

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
    # Instances of a server page enter the one queue of a publisher on it, clients the history of a service.
    shared: dict[_End, list[dict[str, Link]]] = defaultdict(list)
    for parts in together.values():
        if "capacity" not in parts and "enter" in parts:
            shared[_ends(parts["enter"])].append(parts)
    return [_queue(parts, shared) for parts in together.values() if "capacity" in parts]


def _channel(link: Link) -> Channel:
    return next(each for each in link.sources if isinstance(each, Channel))


def _ends(link: Link) -> _End:
    """Return the channel, the kind of queue, and of a topic the port or the node net of a dispatcher.

    Of results and answers it is the client of the action.
    """
    channel, kind = _channel(link), link.meaning.queue if link.meaning is not None else None
    if kind in ("result", "answer"):
        return channel, kind, source_of(link, sym.ActionClientPort)
    if isinstance(channel, sym.TopicChannel):
        return channel, kind, topic_port(link) or source_of(link, sym.NodeNet)
    return channel, kind, None


def _queue(parts: dict[str, Link], shared: dict[_End, list[dict[str, Link]]]) -> Queue:
    capacity = parts["capacity"]
    assert capacity.meaning is not None and capacity.meaning.queue is not None
    entering = [parts] if "enter" in parts else shared[_ends(capacity)]
    entrances = tuple(Entrance(found["enter"].target.id, found["drop"].target.id) for found in entering)
    places = parts["load"].target.id, capacity.target.id
    leave = parts["leave"].target.id if "leave" in parts else None
    return Queue(capacity.meaning.queue, capacity, *places, leave, entrances)
