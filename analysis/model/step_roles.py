"""What each transition of a flattened net is as a step of a trace, found by trace links, never by name.

Every firing of a flattened net is a firing of the model, a change of a signal, or a step of a channel. At the
ends of a channel a node takes part: it publishes, takes, requests, serves, replies, gets a response. What
lies between is silent.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeVar

from dineros.analysis.model.wording import PUBLISHER_QUEUES
from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.calls import copy_id, server_pages, serving
from dineros.metamodel.elements import node_net_of
from dineros.metamodel.records import (
    Drop,
    Fire,
    Publish,
    Reply,
    Request,
    Response,
    Serve,
    Signal,
    Take,
    Transfer,
)
from dineros.metamodel.records.schema import Step
from dineros.transformations.flattening.traces import Link

E = TypeVar("E", bound=EObject)

QUEUES = {**dict.fromkeys(PUBLISHER_QUEUES, "publisher"), "T3": "dispatcher", "T4": "subscriber"}


@dataclass(frozen=True)
class StepRole:
    """What firing a transition is.

    Attributes
    ----------
    kind : type of Step
        The class of its record.
    node : str or None
        The node net that takes part; None inside of a channel, between the nodes.
    channel, queue, stage, place, client, instance, signal, value
        As in the record; None where the record has no such field.
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
    value: bool | None = None

    def fields(self) -> dict[str, object]:
        """Return the fields that it gives its record."""
        names = ("node", "channel", "queue", "stage", "place", "client", "instance", "signal", "value")
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
    if link.rule in QUEUES:
        return _queue_role(link, copies)
    if link.rule == "T1":
        return StepRole(Transfer, channel=_source(link, sym.TopicChannel).id, stage="transport")
    if link.rule in ("S1", "S2"):
        return _service_role(link, copies)
    if link.role.startswith("change."):
        signal = _source(link, sym.InputSignal)
        value = link.role == "change.to_true"
        return StepRole(Signal, node=_node(signal), signal=signal.id, value=value)
    return StepRole(Fire, node=_node(link.sources[0]) if link.sources else None)


def _queue_role(link: Link, copies: dict[tuple[EObject, int | None], str]) -> StepRole:
    channel, queue = _source(link, sym.TopicChannel).id, QUEUES[link.rule]
    port = next((source for source in link.sources if isinstance(source, sym.TopicPort)), None)
    place = None if port is None else copies.get((port.place, link.index), port.place.id)
    node = _node(port.place) if port is not None else _source(link, sym.NodeNet).id
    match link.rule, link.role:
        case "T2" | "T2Instance", "queue.enter":
            return StepRole(Publish, node, channel, place=place)
        case "T4", "queue.leave":
            return StepRole(Take, node, channel, place=place)
        case _, "queue.drop":
            return StepRole(Drop, node, channel, queue, place=place)
    stage = f"{queue}.{link.role.removeprefix('queue.')}"
    return StepRole(Transfer, node, channel, queue, stage, place)


def _service_role(link: Link, copies: dict[tuple[EObject, int | None], str]) -> StepRole:
    channel, client = _source(link, sym.ServiceChannel), _source(link, sym.ClientPort)
    kind: type[Step]
    name = client.client
    if link.client_index is not None and channel.model is not None:  # it stands on a server page
        caller = serving(client.request, server_pages(channel.model))
        assert caller is not None
        name = copy_id(caller.id, link.client_index, name)
    if link.rule == "S1":
        kind, end = (Request, client.request) if link.role == "t_req" else (Response, client.response)
        place = copies[end, link.client_index]
        return StepRole(kind, _node(end), channel.id, place=place, client=name)
    kind, end = (Serve, channel.server.entry) if link.role == "t_call" else (Reply, channel.server.exit)
    place = copies[end, link.index]
    return StepRole(kind, _node(end), channel.id, place=place, client=name, instance=link.index)


def _node(element: EObject) -> str | None:
    node = node_net_of(element)
    return None if node is None else node.id


def _source(link: Link, kind: type[E]) -> E:
    return next(source for source in link.sources if isinstance(source, kind))
