"""The records that change the marking: firings, signals, tokens that pass between nodes and channels."""

from __future__ import annotations

from dataclasses import field
from typing import Any, Literal, TypeAlias

from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.records.base import Data, Record, StoredToken
from dineros.metamodel.records.declarations import Declaration


class Step(Record):
    """A record that changes the marking.

    Attributes
    ----------
    transition : str or None
        Transition of the flattened net, in a witness; the fired transition, in a `Fire`.
    change : dict of str to int
        Tokens gained or lost, by place.
    text : str or None
        Description of the step in terms of the model, in a witness.
    earliest, latest : float or None
        In a witness with times: earliest and latest time of the step, from the start, in all schedules of its
        sequence. An earliest time without a latest one means no upper limit.
    """

    transition: str | None = None
    change: dict[str, int] = field(default_factory=dict)
    text: str | None = None
    earliest: float | None = None
    latest: float | None = None


class Fire(Step, event="fire"):
    """A transition fires.

    Attributes
    ----------
    taken : dict of str to list of int
        Ids of the tokens taken from each place.
    made : dict of str to list of StoredToken
        Tokens put on each place.
    handlers : list of str
        Names of the handlers that ran, in order.
    duration : float or None
        Seconds from the selection to the commit.
    kept : dict
        Values that its handlers keep from now on: name -> JSON value; null: removed.
    """

    transition: str = field()  # without the default of `Step`
    taken: dict[str, list[int]] = field(default_factory=dict)
    made: dict[str, list[StoredToken]] = field(default_factory=dict)
    handlers: list[str] = field(default_factory=list)
    duration: float | None = None
    kept: dict[str, Any] = field(default_factory=dict)


class Signal(Step, event="signal"):
    """A signal changes; `source` names the origin of the value."""

    signal: str
    value: SignalSetting
    source: str | None = None


class Lifecycle(Step, event="lifecycle"):
    """A managed node changes its state, or fails to; then it keeps its state.

    Attributes
    ----------
    label : {"configure", "activate", "deactivate", "cleanup", "shutdown"}
        The requested change.
    state : {"unconfigured", "inactive", "active", "finalized"}
        The state afterwards.
    """

    label: Literal["configure", "activate", "deactivate", "cleanup", "shutdown"]
    state: Literal["unconfigured", "inactive", "active", "finalized"]


class ChannelStep(Step):
    """A token passes between a place of a node net and a channel.

    Attributes
    ----------
    channel : str
        Id of the topic or service channel.
    place : str
        The place of the node net.
    token : int or None
        Id of the token that leaves or arrives; only in runs.
    message : str or None
        Id of the message, ``NODE/PLACE/NUMBER`` by the port's place; a response has that of its request. Only
        in runs.
    """

    channel: str
    place: str
    token: int | None = None
    message: str | None = None


class Publish(ChannelStep, event="publish"):
    """A token leaves for a topic."""

    declared = Declaration(
        does="publishes {message}", does_nameless="publishes a message", token="leaves", port="place"
    )


class Take(ChannelStep, event="take"):
    """A token arrives from a topic, with this `data`."""

    declared = Declaration(
        does="takes {message}",
        does_nameless="takes a message",
        token="arrives",
        port="place",
        receives="publish",
    )
    data: Data = field(default_factory=dict)


class Miss(ChannelStep, event="miss"):
    """A node has taken no message of a topic within its subscription's deadline; `place` gets a token."""

    declared = Declaration(
        does="misses a message",
        does_nameless="misses a message",
        token="arrives",
        port="missed",
        needs_time="node {node} misses a message",
        without_it="no deadline is missed",
    )
    data: Data = field(default_factory=dict)


class ServiceStep(ChannelStep):
    """A step of a service call; `client` is the client's id, `instance` the server instance, from 1."""

    client: str | None = None
    instance: int | None = None


class Request(ServiceStep, event="request"):
    """A client's token leaves as a request."""

    declared = Declaration(
        does="requests {message}",
        does_nameless="requests",
        token="leaves",
        call="begins",
        end="client",
        port="request",
        mark="q",
        state="requested",
        happens="{client} calls service {service}",
    )


class Serve(ServiceStep, event="serve"):
    """A request with this `data` arrives at a server instance."""

    declared = Declaration(
        does="gets request {message}",
        does_nameless="gets a request",
        token="arrives",
        call="is served",
        end="server",
        port="entry",
        receives="request",
        mark="s",
        state="served",
        happens="{server} takes the request of {client}",
    )
    data: Data = field(default_factory=dict)


class Reply(ServiceStep, event="reply"):
    """A server instance's token leaves as a response."""

    declared = Declaration(
        does="replies to {message}",
        does_nameless="replies",
        token="leaves",
        call="is answered",
        end="server",
        port="exit",
        mark="r",
        state="replied",
        happens="{server} answers {client}",
    )


class Response(ServiceStep, event="response"):
    """A response with this `data` arrives at the client that sent the request."""

    declared = Declaration(
        does="gets the response to {message}",
        does_nameless="gets a response",
        token="arrives",
        call="ends",
        end="client",
        port="response",
        receives="reply",
        mark="a",
        state="answered",
        happens="{client} gets its response from service {service}",
    )
    data: Data = field(default_factory=dict)


class GiveUp(Step, event="giveUp"):
    """A client stops waiting for a response; a later response is dropped.

    Attributes
    ----------
    channel : str
        Id of the service channel.
    client : str
        The client's id.
    place : str or None
        The place that gets a token for it, if the model has one.
    token : int or None
        Id of that token; only in runs.
    message : str or None
        Id of the request; only in runs.
    data : dict
        Data of that token; only in runs.
    """

    declared = Declaration(
        does="client {client} gives up {message} ({channel})",
        does_nameless="client {client} gives up a request ({channel})",
        token="may arrive",
        call="is given up",
        end="client",
        port="timedOut",
        mark="g",
        state="given up",
        happens="{client} gives up waiting for service {service}",
        comes_last=True,
        needs_time="client {client} gives up a request",
        without_it="no client gives up",
    )

    channel: str
    client: str
    place: str | None = None
    token: int | None = None
    message: str | None = None
    data: Data = field(default_factory=dict)


CallStep: TypeAlias = ServiceStep | GiveUp
"""A step of a call of a service."""


class Drop(Step, event="drop"):
    """Messages are lost because a queue is full, or because the receiver or sender is not there.

    Attributes
    ----------
    channel : str
        Id of the channel.
    queue : {"publisher", "dispatcher", "subscriber", "request", "feedback", "restart", "inactive"}
        The queue; ``request``: that of a service; ``feedback``: that of an action client; ``restart``: that
        of a restarted publisher, which kept fewer messages than the subscriber still lacked; ``inactive``:
        none, as the managed node that published was not active.
    place : str or None
        Place of the publisher's or subscriber's port, or of the requests.
    token : int or None
        Id of the token that leaves the publisher's place and is lost at once.
    message : str or None
        Id of the request that a service has lost; only in runs.
    count : int
        Number of lost messages.
    """

    channel: str
    queue: Literal["publisher", "dispatcher", "subscriber", "request", "feedback", "restart", "inactive"]
    place: str | None = None
    token: int | None = None
    message: str | None = None
    count: int = 1


class Transfer(Step, event="transfer"):
    """For witnesses only: a silent step inside a channel; `stage` is its position there."""

    channel: str
    stage: str
