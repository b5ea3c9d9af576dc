"""Finds topics and queues in the flattened net."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping

from dineros.analysis.conformance.topics.parts import HistoryTopic, Pair, Queue, Topic
from dineros.analysis.model import queues
from dineros.analysis.model.step_roles import StepRole
from dineros.analysis.model.subject import Subject
from dineros.analysis.model.wording import source_of, topic_port
from dineros.metamodel import sym
from dineros.metamodel.base import EObject
from dineros.metamodel.records import Publish, Take
from dineros.transformations.flattening.traces import Link


class QueueFinder:
    """Finds topics and queues.

    Parameters
    ----------
    roles : mapping of str to StepRole
        Role of each transition.
    states : iterable of int
        The places of the states of managed nodes.
    """

    def __init__(self, subject: Subject, roles: Mapping[str, StepRole], states: Iterable[int]) -> None:
        self._subject, self._roles = subject, roles
        self._queues: dict[EObject, list[queues.Queue]] = defaultdict(list)
        for queue in queues.queues(subject):
            self._queues[queue.channel].append(queue)
        # Places of the room in which writers keep messages for restarting readers.
        rooms = {
            subject.place_index[link.target.id]
            for link in subject.links()
            if link.meaning is not None and link.meaning.part == "room"
        }
        self._beside = {*states, *rooms}

    def topics(self, model: sym.SystemModel) -> dict[str, Topic | HistoryTopic]:
        """Return the topic channels by id."""
        make = self._topic if model.middleware == sym.Middleware.ros1 else self._history_topic
        return {
            channel.id: make(channel) for channel in model.channels if isinstance(channel, sym.TopicChannel)
        }

    def feedback(self) -> dict[tuple[str, str], Queue]:
        """Return the feedback history of each action client that receives feedback, by channel and client."""
        return {
            (channel.id, source_of(queue.link, sym.ActionClientPort).client): self._queue(
                queue, queue.entrances[0]
            )
            for channel, found in self._queues.items()
            if isinstance(channel, sym.ActionChannel)
            for queue in found
        }

    def _topic(self, channel: sym.TopicChannel) -> Topic:
        found: dict[str, dict[str, Queue]] = {"publisher": {}, "dispatcher": {}, "subscriber": {}}
        nodes = {}
        for queue in self._queues[channel]:
            for entrance in queue.entrances:
                role = self._roles[entrance.enter]
                found[queue.kind][role.place or role.node or ""] = self._queue(queue, entrance)
            assert queue.leave is not None, "it is of a topic"
            role = self._roles[queue.leave]
            if role.kind is Take:
                nodes[role.place or ""] = role.node or ""
        between = {
            link.meaning.part: link.target.id
            for link in self._subject.links()
            if channel in link.sources and link.meaning is not None and link.meaning.queue is None
        }
        return Topic(
            self._subject.place_index[between["topic"]],
            self._subject.transition_index[between["transport"]],
            found["publisher"],
            found["dispatcher"],
            found["subscriber"],
            nodes,
        )

    def _history_topic(self, channel: sym.TopicChannel) -> HistoryTopic:
        ports = defaultdict(list)  # places of each publisher's port
        beside = {}
        for link in self._subject.links():
            if channel not in link.sources or link.meaning is None or link.target.id not in self._roles:
                continue
            role = self._roles[link.target.id]
            if role.kind is Publish:
                ports[topic_port(link)].append(role.place or "")
            elif link.meaning.part in ("lose", "miss", "replace"):
                beside[link.meaning.part, _ports_of(link)] = self._subject.transition_index[link.target.id]
        pairs, subscribers, nodes = [], {}, {}
        for queue in self._queues[channel]:
            made = self._queue(queue, queue.entrances[0])
            if queue.kind == "subscriber":
                assert queue.leave is not None, "it is of a topic"
                role = self._roles[queue.leave]
                subscribers[role.place or ""] = made
                nodes[role.place or ""] = role.node or ""
            else:
                writer, reader = _ports_of(queue.link)
                others = [beside.get((part, (writer, reader))) for part in ("lose", "miss", "replace")]
                pairs.append(Pair(writer.place.id, reader.place.id, tuple(ports[writer]), made, *others))
        publishers = {
            place: [pair for pair in pairs if place in pair.publishers]
            for places in ports.values()
            for place in places
        }
        return HistoryTopic(tuple(pairs), publishers, subscribers, nodes)

    def _queue(self, queue: queues.Queue, entrance: queues.Entrance) -> Queue:
        net, transition, place = self._subject.net, self._subject.transition_index, self._subject.place_index
        load, capacity, enter = place[queue.load], place[queue.capacity], transition[entrance.enter]
        (source,) = (at for at, _ in net.pre.row(enter) if at != capacity and at not in self._beside)
        limit = int(net.initial[capacity] + net.initial[load])
        assert queue.leave is not None, "it is of a topic"
        leave, drop = transition[queue.leave], transition[entrance.drop]
        return Queue(source, load, capacity, enter, leave, drop, limit, str(queue))


def _ports_of(link: Link) -> tuple[sym.PublisherPort, sym.SubscriberPort]:
    return source_of(link, sym.PublisherPort), source_of(link, sym.SubscriberPort)
