"""Finds the firings of a flattened model that show a message on a topic, or an event of a service."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from functools import cached_property

from dineros.analysis.model.step_roles import StepRole, step_roles
from dineros.analysis.model.subject import Subject, base_subject
from dineros.metamodel import sym
from dineros.metamodel.elements import transitions
from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.records import Publish, Reply, Request, Response, Serve, Transfer
from dineros.metamodel.records.schema import Step
from dineros.observation.systems import (
    REQUEST_RECEIVED,
    REQUEST_SENT,
    RESPONSE_RECEIVED,
    RESPONSE_SENT,
    event_name,
    full_name,
    named,
)

EVENTS: dict[type[Step], str] = {
    Request: REQUEST_SENT,
    Serve: REQUEST_RECEIVED,
    Reply: RESPONSE_SENT,
    Response: RESPONSE_RECEIVED,
}
"""The event of a service for a step."""


@dataclass(frozen=True)
class ShownNet:
    """A flattened model, with the transitions that a recorder sees.

    Signals are ignored: their changes are invisible, and since they may change at any time, they never force
    or prevent a message.
    """

    model: sym.SystemModel
    subject: Subject
    """The flattened net."""
    shown: dict[str, tuple[int, ...]]
    """By full name of a recorded topic, or name of an event: the transitions that show a message on it."""
    hidden: tuple[str, ...]
    """Topics of the model that were not recorded: their messages may come at any time."""

    @cached_property
    def roles(self) -> dict[str, StepRole]:
        """The step that each transition represents, by its id."""
        return step_roles(self.subject.links())

    @cached_property
    def own(self) -> frozenset[int]:
        """The transitions of the model itself: others represent channels, executors and timers."""
        known = self.subject.transition_index
        return frozenset(known[str(each.id)] for each in transitions(self.model) if str(each.id) in known)

    def nodes_of(self, name: str) -> tuple[str, ...]:
        """Return the node nets that publish on a topic or send an event."""
        names = _names(self.model)
        roles = (role for role in self.roles.values() if names.get((role.channel, role.kind)) == name)
        return tuple(dict.fromkeys(role.node for role in roles if role.node))


def shown_net(model: sym.SystemModel, recorded: set[str]) -> ShownNet:
    """Flatten a model, and find the transitions that show the messages of recorded topics.

    By the rules of ``ros2`` a message is seen when it is published. By those of ``ros1`` it is seen when the
    topic delivers it: a message that the publisher's own queue loses does not reach a recorder.

    `recorded`: full names of the recorded topics, and names of events.

    Raises
    ------
    DinerosError
        No topic of the model was recorded.
    """
    subject = base_subject(model)
    names = _names(model)
    delivered = model.middleware == sym.Middleware.ros1
    found: dict[str, list[int]] = defaultdict(list)
    nodes: dict[str, set[str | None]] = defaultdict(set)
    for transition, role in step_roles(subject.links()).items():
        kind = role.kind
        if delivered and kind in (Publish, Transfer):
            kind = Publish if role.stage == "transport" else Transfer
        name = names.get((role.channel, kind))
        if name is not None:
            found[name].append(subject.transition_index[transition])
            nodes[name].add(role.node)
    topics = {full_name(each.topic) for each in model.channels if isinstance(each, sym.TopicChannel)}
    known = sorted(
        name
        for name in {*topics, *found} & recorded
        if len(nodes[name]) < 2 or name in topics or _is_of_all(name, recorded)
    )
    if not known:
        raise DinerosError(
            "no topic of the model was recorded",
            location=Location(str(model.id)),
            hint=f"recorded are {', '.join(sorted(recorded)) or 'none'}"[:500],
        )
    hidden = tuple(sorted(topics - recorded))
    return ShownNet(model, subject, {topic: tuple(found[topic]) for topic in known}, hidden)


def _names(model: sym.SystemModel) -> dict[tuple[str | None, type[Step]], str]:
    """Return the transitions that show a step, by channel and kind of the step."""
    found: dict[tuple[str | None, type[Step]], str] = {}
    for channel in model.channels:
        if isinstance(channel, sym.TopicChannel):
            found[channel.id, Publish] = full_name(channel.topic)
        elif isinstance(channel, sym.ServiceChannel):
            service = full_name(channel.service)
            found |= {(channel.id, kind): event_name(service, event) for kind, event in EVENTS.items()}
    return found


def _is_of_all(event: str, recorded: set[str]) -> bool:
    """Return whether all of several clients publish events of their calls: known if the server also does."""
    return event_name(named(event), REQUEST_RECEIVED) in recorded
