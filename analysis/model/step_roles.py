"""What each transition of a flattened net is as a step of a trace, found by trace links, never by name.

Every firing of a flattened net is a firing of the model, a change of a signal, or a step of a channel. At the
ends of a channel a node takes part: it publishes, takes, requests, serves, replies, gets a response. What
lies between is silent.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from dineros.analysis.model.wording import signal_setting, source_of, topic_port
from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.calls import copy_id, exits, server_pages, serving
from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.elements import node_net_of
from dineros.metamodel.lifecycles.states import STATE_AFTER, STATES_BEFORE
from dineros.metamodel.records import (
    Drop,
    Fire,
    Lifecycle,
    Signal,
)
from dineros.metamodel.records.schema import Step
from dineros.transformations.flattening.traces import Link
from dineros.transformations.language.meaning import Meaning, QueueKind


@dataclass(frozen=True)
class StepRole:
    """What firing a transition is.

    Attributes
    ----------
    kind : type of Step
        The class of its record.
    node : str or None
        The node net that takes part; None inside of a channel, between the nodes.
    channel, queue, stage, place, client, instance, signal, value, outcome, label, state
        As in the record; None if the record has no such field.
    """

    kind: type[Step]
    node: str | None = None
    channel: str | None = None
    queue: str | None = None
    stage: str | None = None
    place: str | None = None
    client: str | None = None
    instance: int | None = None
    signal: str | None = None
    value: SignalSetting | None = None
    outcome: str | None = None
    label: str | None = None
    state: str | None = None

    def fields(self) -> dict[str, object]:
        """Return the fields that it gives its record."""
        names = [name for name in self.__dataclass_fields__ if name != "kind"]
        known = self.kind.__dataclass_fields__
        return {name: value for name in names if name in known and (value := getattr(self, name)) is not None}


def step_roles(links: Iterable[Link]) -> dict[str, StepRole]:
    """Return the role of every transition of a flattened net, by its id."""
    links = list(links)
    roles = _Roles(links)
    return {link.target.id: roles.of(link) for link in links if isinstance(link.target, pn.Transition)}


class _Roles:
    """The roles of transitions, with the places of the net that are copies of those of the model."""

    def __init__(self, links: Iterable[Link]) -> None:
        self._copies = {
            (link.sources[0], link.index): link.target.id
            for link in links
            if link.role == "place" and link.sources and isinstance(link.target, pn.Place)
        }

    def of(self, link: Link) -> StepRole:
        meaning = link.meaning
        if meaning is None or meaning.step is None:
            return StepRole(Fire, node=_node(link.sources[0]) if link.sources else None)
        if meaning.queue is not None:
            return self._of_queue(link, meaning.queue, meaning.step, meaning.part)
        if meaning.step is Lifecycle:
            return _lifecycle_role(link, meaning)
        if meaning.step.declared.goal:
            return self._of_goal(link, meaning.step)
        if meaning.step.declared.call:
            return self._of_call(link, meaning.step)
        if meaning.step is Signal:
            signal = source_of(link, sym.InputSignal)
            return StepRole(Signal, node=_node(signal), signal=signal.id, value=signal_setting(link))
        channel = next(source for source in link.sources if isinstance(source, sym.Channel))
        return StepRole(meaning.step, channel=channel.id, stage=meaning.part)

    def _of_queue(self, link: Link, queue: QueueKind, kind: type[Step], part: str) -> StepRole:
        stage = None if kind is Drop else f"{queue}.{part}"
        if queue in ("request", "response"):
            return self._of_calls_history(link, queue, kind, stage)
        if queue in ("feedback", "goal", "result", "answer"):
            return self._of_goals_history(link, queue, kind, stage)
        channel = source_of(link, sym.TopicChannel).id
        port = topic_port(link)
        end = None if port is None else getattr(port, kind.declared.port or "place")
        place = None if end is None else self._copies.get((end, link.index), end.id)
        node = _node(port.place) if port is not None else source_of(link, sym.NodeNet).id
        if kind.declared.is_of_topic:
            return StepRole(kind, node, channel, place=place)
        return StepRole(
            kind, node, channel, "inactive" if part in ("discard", "abandon") else queue, stage, place
        )

    def _of_calls_history(
        self, link: Link, queue: QueueKind, kind: type[Step], stage: str | None
    ) -> StepRole:
        """Return the step of a history of requests (a server's) or of responses (a client's)."""
        channel, client = source_of(link, sym.ServiceChannel), source_of(link, sym.ClientPort)
        place = self._copies[client.request if queue == "request" else client.response, link.client_index]
        owner = channel.server.entry if queue == "request" else client.response
        return StepRole(kind, _node(owner), channel.id, queue, stage, place, _client(link))

    def _of_goals_history(
        self, link: Link, queue: QueueKind, kind: type[Step], stage: str | None
    ) -> StepRole:
        """Return the step of a history of goals (a server's) or of what a client receives about them."""
        if queue == "feedback" and kind.declared.goal:
            return self._of_goal(link, kind)
        channel, client = source_of(link, sym.ActionChannel), source_of(link, sym.ActionClientPort)
        owner = channel.server.entry if queue == "goal" else client.goal
        end = client.feedback if queue == "feedback" else client.goal
        place = None if end is None else self._copies[end, None]
        return StepRole(kind, _node(owner), channel.id, queue, stage, place, client.client)

    def _of_call(self, link: Link, kind: type[Step]) -> StepRole:
        """Return a step of a call: its place is that of the port which its kind declares."""
        channel, name = source_of(link, sym.ServiceChannel), _client(link)
        if kind.declared.end == "client":
            client = source_of(link, sym.ClientPort)
            end = getattr(client, kind.declared.port)
            place = None if end is None else self._copies[end, link.client_index]
            return StepRole(kind, _node(client.request), channel.id, place=place, client=name)
        end = getattr(channel.server, kind.declared.port)
        place = self._copies[end, link.index]
        return StepRole(kind, _node(end), channel.id, place=place, client=name, instance=link.index)

    def _of_goal(self, link: Link, kind: type[Step]) -> StepRole:
        """Return the step of a goal: its place is the client's or, in steps of the server, that of a slot."""
        channel = source_of(link, sym.ActionChannel)
        outcomes, server = exits(channel.server), channel.server
        client = next((source for source in link.sources if isinstance(source, sym.ActionClientPort)), None)
        exit_ = next((source for source in link.sources if source in outcomes), None)
        outcome = outcomes[exit_] if isinstance(exit_, pn.Place) else None
        declared, name, instance = kind.declared, None if client is None else client.client, link.index
        if declared.end == "server":
            assert instance is not None
            end = getattr(server, declared.port) if declared.port else exit_
            node, place = _node(server.entry), None if end is None else self._copies[end, instance]
        else:
            assert client is not None
            end = getattr(client, declared.port or outcome or "")
            node, place = _node(client.goal), None if end is None else self._copies[end, None]
            instance = instance if declared.goal == "is asked to cancel" else None
        return StepRole(kind, node, channel.id, place=place, client=name, instance=instance, outcome=outcome)


def _lifecycle_role(link: Link, meaning: Meaning) -> StepRole:
    label, _, fails = meaning.part.partition(".")
    state = STATES_BEFORE[label][0] if fails else STATE_AFTER[label]
    return StepRole(Lifecycle, _node(link.sources[0]), label=label, state=state)


def _client(link: Link) -> str | None:
    """Return the id of a call's client, its instance included; None if it has given up."""
    client = next((source for source in link.sources if isinstance(source, sym.ClientPort)), None)
    if client is None:
        return None
    channel = client.channel
    if link.client_index is None or channel is None or channel.model is None:
        return client.client
    caller = serving(client.request, server_pages(channel.model))
    assert caller is not None
    return copy_id(caller.id, link.client_index, client.client)


def _node(element: EObject) -> str | None:
    node = node_net_of(element)
    return None if node is None else node.id
