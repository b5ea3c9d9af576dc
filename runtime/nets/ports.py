"""What a node shows to the outside, as plain values: its ports, and what goes through them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.errors import FeatureValueError, near_matches
from dineros.metamodel.matching import Quality
from dineros.metamodel.token_data import TokenType, Value

Data = Mapping[str, Value]
"""The fields of a token or message. Nobody changes it once it is made: it is shared, not copied."""

Queue = Literal["publisher", "dispatcher", "subscriber", "request", "feedback", "restart", "inactive"]
"""A queue that can overflow: of a topic, or that of an action's client for feedback; ``restart``: that of a
publisher, which died with its process; ``inactive``: none, a managed node that was not active published."""

OutcomeKind = Literal["succeeded", "aborted", "canceled"]
"""How a goal of an action ends."""

OUTCOMES: tuple[OutcomeKind, ...] = ("succeeded", "aborted", "canceled")


class Message(NamedTuple):
    """What goes through a channel.

    Attributes
    ----------
    id : str
        ``NODE/PLACE/NUMBER``: sending node, place of the port, and how many messages had been sent from there
        with this one. A message that is sent again keeps its id; a response has the id of its request. Empty
        where the sender gives no ids, as programs that know nothing of DiNeROS.
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
    """One end of a channel; each is equal to itself only, so that it is looked up quickly.

    Attributes
    ----------
    channel : str
        Id of the channel in the system model.
    type : str, optional
        Existing ROS interface (``package/msg/Name``); None: one that is generated from the token types.
    mappings : tuple of FieldMapping
        What of that interface carries what of the token.
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
        Its quality of service. With an existing type, the durability is that of programs which know nothing
        of DiNeROS.
    """

    topic: str
    place: str
    limit: int
    quality: Quality

    @property
    def is_kept(self) -> bool:
        """Whether publishers keep their last messages for subscribers that come back."""
        if self.type is None:
            return self.quality.durability == "transientLocal"
        return self.quality.reliability == "reliable"


@dataclass(frozen=True, slots=True, eq=False)
class PublisherPort(TopicPort):
    """Tokens of a place are published on a topic; the limit is the depth of its history.

    Attributes
    ----------
    places : tuple of str
        The place as it runs: on a server page once for each server instance. They share the queue.
    """

    places: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class SubscriberPort(TopicPort):
    """Messages of a topic become tokens of a place.

    Under the paper's rules the node itself keeps to the limit: what arrives while so many messages wait for
    it is dropped, counted and recorded. Under those of ROS 2 the limit is the depth of the history that the
    middleware keeps, and the node takes a message when its place has room.

    Attributes
    ----------
    dispatcher_limit : int
        Capacity of the queue that all subscribers of the node to this topic share, under the paper's rules.
    missed : str or None
        Gets a token when no message was taken for the deadline of the quality; None: nothing does.
    """

    dispatcher_limit: int
    missed: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class ClientPort(Port):
    """Tokens of one place are requests of a service, their responses become tokens of another one.

    A client on a server page is one for each server instance, with an id and places of its own
    (``Pick[2].c1``): a response comes back to the instance that asked.

    Attributes
    ----------
    service : str
        Name of the service.
    client : str
        Id of the client.
    request, response : str
        The places.
    outstanding : int
        Requests that it has under way at most.
    timeout : float or None
        Seconds after which it gives a request up; None: it waits forever.
    timed_out : str or None
        The place that gets a token then.
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
    """Requests of a service become tokens; entry and exit place of each server instance.

    Attributes
    ----------
    service : str
        Name of the service.
    entries, exits : tuple of str
        The places of each instance.
    depth : int
        Requests that wait for an instance at most, under the rules of ROS 2.
    outstanding : int
        Requests that one of its clients has under way at most.
    """

    service: str
    entries: tuple[str, ...]
    exits: tuple[str, ...]
    depth: int = 10
    outstanding: int = 1

    @property
    def instances(self) -> int:
        """How many requests can be served at a time."""
        return len(self.entries)


@dataclass(frozen=True, slots=True, eq=False)
class ActionPort(Port):
    """One end of an action.

    Attributes
    ----------
    action : str
        Its name.
    depth : int
        How much feedback waits at most.
    """

    action: str
    depth: int


@dataclass(frozen=True, slots=True, eq=False)
class ActionClientPort(ActionPort):
    """Tokens of one place are goals of an action; what becomes of them comes onto others.

    Attributes
    ----------
    client : str
        Its id; on a server page one for each server instance, as that of a service's client.
    goal : str
        The place of the goals.
    outcomes : mapping of str to str
        Outcome -> the place of the results of goals that ended so; not there: nobody wants them.
    rejected, cancel, feedback, accepted : str or None
        Places: of tokens for goals that were refused, of requests to cancel, of feedback, of tokens for goals
        that were accepted.
    outstanding : int
        Goals under way at most.
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
    """Goals of an action become tokens, each in a slot: a copy of the page that works on it.

    Attributes
    ----------
    entries : tuple of str
        The place of each slot where its goal comes.
    outcomes : mapping of str to tuple of str
        Outcome -> the place of each slot with the results of goals that end so.
    cancels, feedbacks : tuple of str
        The place of each slot that gets requests to cancel, and that with feedback; empty: there is none.
    may_reject : bool
        Whether it refuses goals for which there is no slot.
    """

    entries: tuple[str, ...]
    outcomes: Mapping[OutcomeKind, tuple[str, ...]]
    cancels: tuple[str, ...]
    feedbacks: tuple[str, ...]
    may_reject: bool

    @property
    def slots(self) -> int:
        """How many goals can be worked on at a time."""
        return len(self.entries)


@dataclass(frozen=True, slots=True, eq=False)
class TimerPort:
    """The timer of a callback, which ticks (rule C1); each is equal to itself only.

    Attributes
    ----------
    callback : str
        Id of the callback page.
    period : float
        Seconds, as the model has it.
    """

    callback: str
    period: float


@dataclass(frozen=True, slots=True)
class CallbackPort:
    """A callback, and what its model declares of its times.

    Attributes
    ----------
    callback : str
        Id of the callback page.
    transitions, begins, ends : frozenset of str
        Ids of its transitions, of those by which its timer begins it, and of those by which it ends.
    duration : tuple of (float, float or None), or None
        Seconds of one run, at least and at most.
    period, jitter : float
        Of its timer, in seconds; no timer: 0.
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
    """All that a node shows to the outside.

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
        What tokens carry in places that name no other type.
    place_types : mapping
        What they carry in the others, by the places' ids as they run and in the model.
    middleware : {"ros1", "ros2"}
        Whose queues its topics have.
    start_steps : mapping
        Of a managed node, in which step of the start order it is configured and activated.
    pauses : bool
        Whether it fires while it is active only; else only its publishers are held back.
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
        """Whether it has a lifecycle, and is nothing before it is configured."""
        return bool(self.start_steps)

    def type_at(self, place: str) -> TokenType:
        """Return what the tokens of a place carry."""
        return self.place_types.get(place, self.token_type)


Check = Callable[[Data], None]
"""Raises an error for data that cannot be sent."""
