"""The ports of a node as plain values, and the messages that go through them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.errors import FeatureValueError, near_matches
from dineros.metamodel.matching import Quality
from dineros.metamodel.token_data import TokenType, Value

Data = Mapping[str, Value]
"""The fields of a token or message. It is never changed, so it can be shared without a copy."""

Queue = Literal["publisher", "dispatcher", "subscriber", "request", "feedback", "restart", "inactive"]
"""A queue that loses messages: of a topic, or for the feedback of an action client; ``restart``: the queue of
a publisher whose process ended; ``inactive``: no queue, a managed node published while it was not active."""

OutcomeKind = Literal["succeeded", "aborted", "canceled"]
"""The outcome of a goal of an action."""

OUTCOMES: tuple[OutcomeKind, ...] = ("succeeded", "aborted", "canceled")


class Message(NamedTuple):
    """A message on a channel.

    Attributes
    ----------
    id : str
        ``NODE/PLACE/NUMBER``: the sending node, the place of the port, and the number of messages sent from
        there, including this one. A message that is sent again keeps its id; a response has the id of its
        request. Empty if the sender gives no ids, as programs without DiNeROS do.
    data : mapping
        Values of the fields of the token type.
    """

    id: str
    data: Data


@dataclass(frozen=True, slots=True)
class FieldMapping:
    """A field of an existing ROS interface that carries a field of the token.

    Attributes
    ----------
    part : {"message", "request", "response", "goal", "result", "feedback"}
        Part of the interface.
    message_field : str
        Path in it, such as ``pose.position.x``.
    token_field : str
        Name of the token's field.
    """

    part: str
    message_field: str
    token_field: str


@dataclass(frozen=True, slots=True, eq=False)
class Port:
    """One end of a channel; equal only to itself, so that lookups are fast.

    Attributes
    ----------
    channel : str
        Id of the channel in the system model.
    type : str, optional
        Existing ROS interface (``package/msg/Name``); None: an interface is generated from the token types.
    mappings : tuple of FieldMapping
        Which fields of that interface carry which fields of the token.
    """

    channel: str
    type: str | None
    mappings: tuple[FieldMapping, ...]


@dataclass(frozen=True, slots=True, eq=False)
class TopicPort(Port):
    """One end of a topic.

    Attributes
    ----------
    topic : str
        Its name.
    place : str
        The place in the model.
    limit : int
        Capacity of the queue.
    quality : Quality
        Its quality of service. With an existing type, the durability is that of programs without DiNeROS.
    """

    topic: str
    place: str
    limit: int
    quality: Quality

    @property
    def is_kept(self) -> bool:
        """Whether publishers keep their last messages for subscribers that restart."""
        if self.type is None:
            return self.quality.durability == "transientLocal"
        return self.quality.reliability == "reliable"


@dataclass(frozen=True, slots=True, eq=False)
class PublisherPort(TopicPort):
    """Tokens of a place are published on a topic; the limit is the depth of its history.

    Attributes
    ----------
    places : tuple of str
        The place in the running net: on a server page, one for each server instance. They share the queue.
    """

    places: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class SubscriberPort(TopicPort):
    """Messages of a topic become tokens of a place.

    Under the paper's rules, the node itself enforces the limit: a message that arrives while this number of
    messages waits is dropped, counted and recorded. Under the rules of ROS 2, the limit is the depth of the
    history in the middleware, and the node takes a message when its place has room.

    Attributes
    ----------
    dispatcher_limit : int
        Capacity of the queue that all subscribers of the node to this topic share, under the paper's rules.
    missed : str or None
        Gets a token if no message was taken within the deadline of the quality of service; None: no place
        does.
    """

    dispatcher_limit: int
    missed: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class ClientPort(Port):
    """Tokens of one place are requests of a service; their responses become tokens of another place.

    A client on a server page exists once for each server instance, with its own id and places
    (``Pick[2].c1``): a response returns to the instance that sent the request.

    Attributes
    ----------
    service : str
        Name of the service.
    client : str
        Id of the client.
    request, response : str
        The places.
    outstanding : int
        Maximum number of requests under way.
    timeout : float or None
        Seconds after which it gives up a request; None: it waits without limit.
    timed_out : str or None
        The place that gets a token after a time-out.
    """

    service: str
    client: str
    request: str
    response: str
    outstanding: int = 1
    timeout: float | None = None
    timed_out: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class ServerPort(Port):
    """Requests of a service become tokens; each server instance has an entry and an exit place.

    Attributes
    ----------
    service : str
        Name of the service.
    entries, exits : tuple of str
        The places of each instance.
    depth : int
        Maximum number of requests that wait for an instance, under the rules of ROS 2.
    outstanding : int
        Maximum number of requests that one of its clients has under way.
    """

    service: str
    entries: tuple[str, ...]
    exits: tuple[str, ...]
    depth: int = 10
    outstanding: int = 1

    @property
    def instances(self) -> int:
        """Number of requests that can be handled at a time."""
        return len(self.entries)


@dataclass(frozen=True, slots=True, eq=False)
class ActionPort(Port):
    """One end of an action.

    Attributes
    ----------
    action : str
        Its name.
    depth : int
        Maximum number of feedback messages that wait.
    """

    action: str
    depth: int


@dataclass(frozen=True, slots=True, eq=False)
class ActionClientPort(ActionPort):
    """Tokens of one place are goals of an action; answers, feedback and results go to other places.

    Attributes
    ----------
    client : str
        Its id; on a server page, one for each server instance, like a service client.
    goal : str
        The place of the goals.
    outcomes : mapping of str to str
        Outcome -> the place of the results of goals with this outcome; missing: the model does not use them.
    rejected, cancel, feedback, accepted : str or None
        Places for tokens of refused goals, for cancel requests, for feedback, and for tokens of accepted
        goals.
    outstanding : int
        Maximum number of goals under way.
    """

    client: str
    goal: str
    outcomes: Mapping[OutcomeKind, str]
    rejected: str | None
    cancel: str | None
    feedback: str | None
    outstanding: int
    accepted: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class ActionServerPort(ActionPort):
    """Goals of an action become tokens, each in a slot: a copy of the page that executes it.

    Attributes
    ----------
    entries : tuple of str
        For each slot, the place of its new goal.
    outcomes : mapping of str to tuple of str
        Outcome -> for each slot, the place of results with this outcome.
    cancels, feedbacks : tuple of str
        For each slot, the place for cancel requests, and the place of feedback; empty: there is none.
    may_reject : bool
        Whether it refuses goals if no slot is free.
    """

    entries: tuple[str, ...]
    outcomes: Mapping[OutcomeKind, tuple[str, ...]]
    cancels: tuple[str, ...]
    feedbacks: tuple[str, ...]
    may_reject: bool

    @property
    def slots(self) -> int:
        """Number of goals that can be executed at a time."""
        return len(self.entries)


@dataclass(frozen=True, slots=True, eq=False)
class TimerPort:
    """The timer of a callback (rule C1); equal only to itself.

    Attributes
    ----------
    callback : str
        Id of the callback page.
    period : float
        Seconds, as in the model.
    """

    callback: str
    period: float


@dataclass(frozen=True, slots=True)
class CallbackPort:
    """A callback with the times that its model declares.

    Attributes
    ----------
    callback : str
        Id of the callback page.
    transitions, begins, ends : frozenset of str
        Ids of its transitions, of those that begin it at a tick of its timer, and of those that end it.
    duration : tuple of (float, float or None), or None
        Minimum and maximum run time, in seconds.
    period, jitter : float
        Period and jitter of its timer, in seconds; without a timer: 0.
    """

    callback: str
    transitions: frozenset[str]
    begins: frozenset[str]
    ends: frozenset[str]
    duration: tuple[float, float | None] | None
    period: float
    jitter: float


@dataclass(frozen=True, slots=True)
class SignalPort:
    """An input signal that the outside may set; one without `values` is true or false."""

    id: str
    name: str
    initial: SignalSetting
    values: tuple[str, ...] = ()

    @property
    def formula_names(self) -> list[str]:
        """How formulas call what it can be: ``Danger``, ``Mode.idle``."""
        return [f"{self.id}.{value}" for value in self.values] or [self.id]

    def require(self, value: object) -> None:
        """Refuse what it cannot be, with `FeatureValueError`."""
        if self.values and value not in self.values:
            known = near_matches(str(value), self.values) or f"its values are {', '.join(self.values)}"
            raise FeatureValueError(f"the signal {self.id} has no value {value!r:.80}", hint=known)
        if not self.values and not isinstance(value, bool):
            raise FeatureValueError(f"the signal {self.id} takes True or False, not {value!r:.80}")


@dataclass(frozen=True, slots=True)
class Ports:
    """All ports of a node.

    Attributes
    ----------
    model : str
        Id of the system model.
    node : str
        Id of the node net.
    name, namespace : str
        The ROS node.
    executor : {"single", "multi"}
        Its executor.
    threads : int
        Threads of a multi-threaded executor.
    token_type : TokenType
        Token type of places that name no other type.
    place_types : mapping
        Token types of the other places, by their ids in the running net and in the model.
    middleware : {"ros1", "ros2"}
        The middleware whose queues its topics have.
    start_steps : mapping
        For a managed node, the steps of the start order in which it is configured and activated.
    pauses : bool
        Whether it fires only while it is active; if False, only its publishers are held.
    """

    model: str
    node: str
    name: str
    namespace: str
    executor: str
    threads: int
    middleware: str
    token_type: TokenType
    publishers: tuple[PublisherPort, ...]
    subscribers: tuple[SubscriberPort, ...]
    clients: tuple[ClientPort, ...]
    servers: tuple[ServerPort, ...]
    signals: tuple[SignalPort, ...]
    action_clients: tuple[ActionClientPort, ...] = ()
    action_servers: tuple[ActionServerPort, ...] = ()
    timers: tuple[TimerPort, ...] = ()
    callbacks: tuple[CallbackPort, ...] = ()
    place_types: Mapping[str, TokenType] = field(default_factory=dict)
    start_steps: Mapping[str, float] = field(default_factory=dict)
    pauses: bool = False

    @property
    def is_managed(self) -> bool:
        """Whether it has a lifecycle, so that its net exists only once it is configured."""
        return bool(self.start_steps)

    def type_at(self, place: str) -> TokenType:
        """Return the token type of a place."""
        return self.place_types.get(place, self.token_type)


Check = Callable[[Data], None]
"""Raises an error for data that cannot be sent."""
