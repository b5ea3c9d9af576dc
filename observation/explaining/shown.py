"""Which firings of a flattened model show a message on a topic, and which nobody sees."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from functools import cached_property

from dineros.analysis.model.step_roles import StepRole, step_roles
from dineros.analysis.model.subject import Subject, base_subject
from dineros.metamodel import sym
from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.records import Publish, Transfer


def full_name(topic: str) -> str:
    """Return the full name of a topic of a model: names without a slash stand in the root namespace."""
    return topic if topic.startswith("/") else f"/{topic}"


@dataclass(frozen=True)
class ShownNet:
    """A flattened model, and what of it a recorder sees.

    Signals are left out: nobody sees them change, and as they may change at any time, no message comes or
    stays away for them.

    Attributes
    ----------
    model : sym.SystemModel
        The model.
    subject : Subject
        What it is flattened to.
    shown : dict of str to tuple of int
        By full name of a recorded topic: the transitions that show a message on it.
    hidden : tuple of str
        Topics of the model that were not recorded: their messages may come at any time.
    """

    model: sym.SystemModel
    subject: Subject
    shown: dict[str, tuple[int, ...]]
    hidden: tuple[str, ...]

    @cached_property
    def roles(self) -> dict[str, StepRole]:
        """What firing each transition is, by its id."""
        return step_roles(self.subject.links())

    def nodes_of(self, topic: str) -> tuple[str, ...]:
        """Return the node nets that publish on a topic."""
        channels = [
            channel
            for channel in self.model.channels
            if isinstance(channel, sym.TopicChannel) and full_name(channel.topic) == topic
        ]
        found = {
            role.node: None
            for role in self.roles.values()
            if role.kind is Publish and role.channel in {channel.id for channel in channels} and role.node
        }
        return tuple(found)


def shown_net(model: sym.SystemModel, recorded: set[str]) -> ShownNet:
    """Flatten a model, and find what shows the messages of recorded topics.

    By the rules of ``ros2`` a message is seen when it is published. By those of ``ros1`` it is seen when the
    topic delivers it: one that the publisher's own queue loses reaches nobody, a recorder neither.

    Parameters
    ----------
    model : sym.SystemModel
        The model.
    recorded : set of str
        Full names of the recorded topics.

    Raises
    ------
    DinerosError
        No topic of the model was recorded.
    """
    subject = base_subject(model)
    topics = {
        channel.id: full_name(channel.topic)
        for channel in model.channels
        if isinstance(channel, sym.TopicChannel)
    }
    delivered = model.middleware == sym.Middleware.ros1
    found: dict[str, list[int]] = defaultdict(list)
    for name, role in step_roles(subject.links()).items():
        is_seen = role.kind is Transfer and role.stage == "transport" if delivered else role.kind is Publish
        if is_seen and role.channel in topics:
            found[topics[role.channel]].append(subject.transition_index[name])
    known = sorted({*topics.values()} & recorded)
    if not known:
        raise DinerosError(
            "no topic of the model was recorded",
            location=Location(str(model.id)),
            hint=f"recorded are {', '.join(sorted(recorded)) or 'none'}"[:500],
        )
    hidden = tuple(sorted({*topics.values()} - recorded))
    return ShownNet(model, subject, {topic: tuple(found[topic]) for topic in known}, hidden)
