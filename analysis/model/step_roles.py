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
    """Return the role of every transition of a flattened net, by its id.

    Parameters
    ----------
    links : iterable of Link
        How the elements of the net were made.
    """
    links = list(links)
    copies = {
        (link.sources[0], link.index): link.target.id
        for link in links
        if link.role == "place" and link.sources and isinstance(link.target, pn.Place)
    }
    return {link.target.id: _role(link, copies) for link in links if isinstance(link.target, pn.Transition)}


def _role(link: Link, copies: dict[tuple[EObject, int | None], str]) -> StepRole:
    meaning = link.meaning
    if meaning is None or meaning.step is None:
        return StepRole(Fire, node=_node(link.sources[0]) if link.sources else None)
    if meaning.queue is not None:
        return _queue_role(link, meaning, copies)
    if meaning.step is Lifecycle:
        return _lifecycle_role(link, meaning)
    if meaning.step.declared.goal:
        return _goal_role(link, meaning.step, copies)
    if meaning.step.declared.call:
        return _service_role(link, meaning.step, copies)
    if meaning.step is Signal:
        signal = source_of(link, sym.InputSignal)
        return StepRole(Signal, node=_node(signal), signal=signal.id, value=signal_setting(link))
    channel = next(source for source in link.sources if isinstance(source, sym.Channel))
    return StepRole(meaning.step, channel=channel.id, stage=meaning.part)


def _queue_role(link: Link, meaning: Meaning, copies: dict[tuple[EObject, int | None], str]) -> StepRole:
    assert meaning.step is not None
    stage = None if meaning.step is Drop else f"{meaning.queue}.{meaning.part}"
    if meaning.queue in ("request", "response"):
        return _call_role(link, meaning.queue, meaning.step, stage, copies)
    if meaning.queue == "feedback":
        return _feedback_role(link, meaning.step, stage, copies)
    if meaning.queue in ("goal", "result", "answer"):
        return _history_role(link, meaning.queue, meaning.step, stage, copies)
    channel = source_of(link, sym.TopicChannel).id
    port = topic_port(link)
    end = None if port is None else getattr(port, meaning.step.declared.port or "place")
    place = None if end is None else copies.get((end, link.index), end.id)
    node = _node(port.place) if port is not None else source_of(link, sym.NodeNet).id
    if meaning.step.declared.is_of_topic:
        return StepRole(meaning.step, node, channel, place=place)
    queue = "inactive" if meaning.part in ("discard", "abandon") else meaning.queue
    return StepRole(meaning.step, node, channel, queue, stage, place)


def _history_role(
    link: Link,
    queue: QueueKind,
    kind: type[Step],
    stage: str | None,
    copies: dict[tuple[EObject, int | None], str],
) -> StepRole:
    """Return the step of a history: of goals, which a server has, or of what a client receives about them."""
    channel, client = source_of(link, sym.ActionChannel), source_of(link, sym.ActionClientPort)
    owner = channel.server.entry if queue == "goal" else client.goal
    return StepRole(kind, _node(owner), channel.id, queue, stage, copies[client.goal, None], client.client)


def _service_role(link: Link, kind: type[Step], copies: dict[tuple[EObject, int | None], str]) -> StepRole:
    """Return a step of a call: its place is that of the port which its kind declares."""
    channel, name = source_of(link, sym.ServiceChannel), _client(link)
    if kind.declared.end == "client":
        client = source_of(link, sym.ClientPort)
        end = getattr(client, kind.declared.port)
        place = None if end is None else copies[end, link.client_index]
        return StepRole(kind, _node(client.request), channel.id, place=place, client=name)
    end = getattr(channel.server, kind.declared.port)
    place = copies[end, link.index]
    return StepRole(kind, _node(end), channel.id, place=place, client=name, instance=link.index)


def _lifecycle_role(link: Link, meaning: Meaning) -> StepRole:
    label, _, fails = meaning.part.partition(".")
    state = STATES_BEFORE[label][0] if fails else STATE_AFTER[label]
    return StepRole(Lifecycle, _node(link.sources[0]), label=label, state=state)


def _call_role(
    link: Link,
    queue: QueueKind,
    kind: type[Step],
    stage: str | None,
    copies: dict[tuple[EObject, int | None], str],
) -> StepRole:
    """Return the step of a history: of requests, which a server has, or of responses, which a client has."""
    channel, client = source_of(link, sym.ServiceChannel), source_of(link, sym.ClientPort)
    place = copies[client.request if queue == "request" else client.response, link.client_index]
    owner = channel.server.entry if queue == "request" else client.response
    return StepRole(kind, _node(owner), channel.id, queue, stage, place, _client(link))


def _goal_role(link: Link, kind: type[Step], copies: dict[tuple[EObject, int | None], str]) -> StepRole:
    """Return the step of a goal: its place is the client's or, in the steps of the server, that of a slot."""
    channel = source_of(link, sym.ActionChannel)
    outcomes, server = exits(channel.server), channel.server
    client = next((source for source in link.sources if isinstance(source, sym.ActionClientPort)), None)
    exit_ = next((source for source in link.sources if source in outcomes), None)
    outcome = outcomes[exit_] if isinstance(exit_, pn.Place) else None
    declared = kind.declared
    if declared.end == "server":
        assert link.index is not None
        end = getattr(server, declared.port) if declared.port else exit_
        place = None if end is None else copies[end, link.index]
        name = None if client is None else client.client
        node, slot = _node(server.entry), link.index
        return StepRole(kind, node, channel.id, place=place, client=name, instance=slot, outcome=outcome)
    assert client is not None
    told = getattr(client, declared.port or outcome or "")
    place = None if told is None else copies[told, None]
    asked = link.index if declared.goal == "is asked to cancel" else None
    return StepRole(
        kind,
        _node(client.goal),
        channel.id,
        place=place,
        client=client.client,
        instance=asked,
        outcome=outcome,
    )


def _feedback_role(
    link: Link, kind: type[Step], stage: str | None, copies: dict[tuple[EObject, int | None], str]
) -> StepRole:
    if kind.declared.goal:
        return _goal_role(link, kind, copies)
    channel, client = source_of(link, sym.ActionChannel), source_of(link, sym.ActionClientPort)
    place = None if client.feedback is None else copies[client.feedback, None]
    return StepRole(kind, _node(client.goal), channel.id, "feedback", stage, place, client.client)


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
