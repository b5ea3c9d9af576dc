"""System model (SyM): one model of a whole distributed ROS application (paper, Sect. 5.3).

Generated from `sym.ecore` by `make regenerate`; edits are lost.
"""

from __future__ import annotations

import sys
from functools import partial
from typing import Any, ClassVar

import pyecore.ecore as Ecore

from dineros.metamodel import pn
from dineros.metamodel.base import (
    Choice,
    EnumLiteral,
    EObject,
    Mandatory,
    MetaEClass,
    ModelList,
    complete,
    enumeration,
    reference,
)

name = "sym"
nsURI = "http://dineros.org/sym/1.0"
nsPrefix = "sym"

eClass = Ecore.EPackage(name=name, nsURI=nsURI, nsPrefix=nsPrefix)
eClassifiers: dict[str, Any] = {}
getEClassifier = partial(Ecore.getEClassifier, searchspace=eClassifiers)
eSubpackages: list[Any] = []
eSuperPackage = None


@enumeration
class Executor(EnumLiteral):
    """How a ROS node runs its callbacks."""

    single: ClassVar[Executor]
    """Single-threaded."""
    multi: ClassVar[Executor]
    """Multi-threaded."""


@enumeration
class CallbackGroupKind(EnumLiteral):
    """Which callbacks of a group may run at the same time."""

    exclusive: ClassVar[CallbackGroupKind]
    """One at a time."""
    reentrant: ClassVar[CallbackGroupKind]
    """Any number."""


@enumeration
class CallbackKind(EnumLiteral):
    """What calls a callback page."""

    timer: ClassVar[CallbackKind]
    """A timer."""
    subscriber: ClassVar[CallbackKind]
    """A message of a topic."""
    server: ClassVar[CallbackKind]
    """A request of a service."""
    client: ClassVar[CallbackKind]
    """A response of a service, without waiting for it."""
    goal: ClassVar[CallbackKind]
    """A goal of an action that has been accepted: the page is what works on it."""


@enumeration
class PlaceKind(EnumLiteral):
    """Role of a place in the workflow of its node."""

    ordinary: ClassVar[PlaceKind]
    """No special role."""
    start: ClassVar[PlaceKind]
    """Where the workflow starts."""
    end: ClassVar[PlaceKind]
    """Where the workflow ends."""


@enumeration
class TransitionKind(EnumLiteral):
    """Role of a transition in the workflow of its node."""

    discrete: ClassVar[TransitionKind]
    """Fires when enabled."""
    timed: ClassVar[TransitionKind]
    """Fires within its interval."""
    start: ClassVar[TransitionKind]
    """Starts the workflow."""
    end: ClassVar[TransitionKind]
    """Ends the workflow."""


@enumeration
class FieldKind(EnumLiteral):
    """Type of a token field."""

    text: ClassVar[FieldKind]
    """Character string."""
    integer: ClassVar[FieldKind]
    """Whole number."""
    number: ClassVar[FieldKind]
    """Floating-point number."""
    boolean: ClassVar[FieldKind]
    """True or false."""
    list: ClassVar[FieldKind]
    """List of elements of one kind."""
    map: ClassVar[FieldKind]
    """Map from text to elements of one kind."""


@enumeration
class Reliability(EnumLiteral):
    """QoS reliability of a topic."""

    reliable: ClassVar[Reliability]
    """Sent again until received."""
    bestEffort: ClassVar[Reliability]
    """Sent once."""


@enumeration
class Durability(EnumLiteral):
    """QoS durability of a topic."""

    volatile: ClassVar[Durability]
    """Late subscribers miss what was sent."""
    transientLocal: ClassVar[Durability]
    """Late subscribers get what the publisher kept."""


@enumeration
class Middleware(EnumLiteral):
    """Whose queues a flattened model has."""

    ros1: ClassVar[Middleware]
    """The paper's: publisher, dispatcher and subscriber queues."""
    ros2: ClassVar[Middleware]
    """Writer and reader histories, and capacities."""


@enumeration
class Liveliness(EnumLiteral):
    """QoS liveliness of a topic: who says that a publisher is alive."""

    automatic: ClassVar[Liveliness]
    """The middleware, while the process runs."""
    manualByTopic: ClassVar[Liveliness]
    """The publisher itself, by publishing or asserting."""


@enumeration
class Execution(EnumLiteral):
    """How the callbacks of a node run."""

    net: ClassVar[Execution]
    """The net interleaves them: the node runs our engine, and its callbacks only put tokens."""
    callbacks: ClassVar[Execution]
    """One after another where executor and callback groups say so: the node is written by hand."""


@enumeration
class CallbackOrder(EnumLiteral):
    """Which of the callbacks that are ready an executor takes."""

    any: ClassVar[CallbackOrder]
    """Each may be next."""
    rclcpp: ClassVar[CallbackOrder]
    """As the executors of rclcpp take them."""
    rclpy: ClassVar[CallbackOrder]
    """As the executors of rclpy take them."""


@enumeration
class MessagePart(EnumLiteral):
    """Part of a ROS interface."""

    message: ClassVar[MessagePart]
    """Message of a topic."""
    request: ClassVar[MessagePart]
    """Request of a service."""
    response: ClassVar[MessagePart]
    """Response of a service."""
    goal: ClassVar[MessagePart]
    """Goal of an action."""
    result: ClassVar[MessagePart]
    """Result of an action."""
    feedback: ClassVar[MessagePart]
    """Feedback of an action."""


@enumeration
class PropertyLanguage(EnumLiteral):
    """What a property is written in."""

    words: ClassVar[PropertyLanguage]
    """A pattern in words, such as never or leads to."""
    ltl: ClassVar[PropertyLanguage]
    """Linear temporal logic."""
    ctl: ClassVar[PropertyLanguage]
    """Branching temporal logic."""


@enumeration
class SignalVariant(EnumLiteral):
    """What of the input signals is in the net that is asked."""

    none: ClassVar[SignalVariant]
    """Nothing."""
    fullyEnabled: ClassVar[SignalVariant]
    """Each signal, changed one at a time."""
    inputEnabled: ClassVar[SignalVariant]
    """Each signal, tested by the transitions."""
    ioEnabled: ClassVar[SignalVariant]
    """Changes of signals together with what tests them."""


class DefaultTimes(EObject, metaclass=MetaEClass):
    """Times, in seconds, of what gives none of its own."""

    latency: pn.TimeInterval | None = reference("pn.TimeInterval", containment=True)
    """Of the messages of channels."""
    duration: pn.TimeInterval | None = reference("pn.TimeInterval", containment=True)
    """Of the runs of callbacks, and of handlers in flight."""
    reaction: pn.TimeInterval | None = reference("pn.TimeInterval", containment=True)
    """Of engines of the execution net."""


class Lifecycle(EObject, metaclass=MetaEClass):
    """Life of a managed node (ROS 2 design: Managed nodes): unconfigured, inactive, active, finalized. It
    may always be configured and activated.
    """

    deactivates: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    """It may be deactivated."""
    cleansUp: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    """It may be cleaned up: what its configuring made is gone."""
    shutsDown: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    """It may be shut down forever."""
    configureFails: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    """Configuring may fail, which leaves it unconfigured."""
    activateFails: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    """Activating may fail, which leaves it inactive."""
    pauses: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    """The node's own timers stop while it is inactive; by default only its publishers do."""
    configureStep: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=0)
    """Step of the start order in which it is configured: after all that earlier steps do; 0: at any time."""
    activateStep: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=0)
    """Step of the start order in which it is activated: after all that earlier steps do; 0: at any time."""


class BalloonToken(EObject, metaclass=MetaEClass):
    """Data of one token (paper, Sect. 5.2); influences enabling only by guards."""

    data: str = Ecore.EAttribute(eType=Ecore.EString, default_value="{}")
    """JSON object: field name to value."""


class SignalValue(EObject, metaclass=MetaEClass):
    """One of the values of an input signal."""

    signal: InputSignal | None = reference("InputSignal")
    """The signal."""
    name: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """What it is called."""


class InputClause(EObject, metaclass=MetaEClass):
    """Named boolean expression over signals of the same node net."""

    transition: Transition | None = reference("Transition", opposite="clause")
    """The transition it guards."""
    name: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """Name of the clause."""
    text: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """The expression as its author wrote it."""
    disjunctions: ModelList[Disjunction] = reference("Disjunction", containment=True, upper=-1)
    """Conjunctive normal form of the text; none: always true."""


class Disjunction(EObject, metaclass=MetaEClass):
    """True when one of its literals is; without literals it is false."""

    clause: InputClause | None = reference("InputClause", opposite="disjunctions")
    """The clause it is part of."""
    literals: ModelList[Literal] = reference("Literal", opposite="disjunction", containment=True, upper=-1)
    """Its literals."""


class Literal(EObject, metaclass=MetaEClass):
    """A boolean signal, or that a signal has a value; or the negation."""

    disjunction: Disjunction | None = reference("Disjunction")
    """The disjunction it is part of."""
    signal: Mandatory[InputSignal] = reference("InputSignal", lower=1, required=True)
    """The signal."""
    negated: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    """True for the negation."""
    value: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """The value that the signal is compared with; absent: it is a boolean."""


class TokenField(EObject, metaclass=MetaEClass):
    """One field of the token type."""

    name: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Name of the field."""
    kind: Choice[FieldKind] = Ecore.EAttribute(eType=FieldKind, default_value=FieldKind.text)
    """Type of its value."""
    elementKind: Choice[FieldKind] = Ecore.EAttribute(eType=FieldKind, default_value=FieldKind.text)
    """Type of the elements of a list or map."""
    length: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    """Number of elements of a list of fixed length."""
    default: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """Default value as JSON; absent: the kind's empty value."""
    ros: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """ROS type of the value, or of the elements, such as uint8 or string<=20; absent: that of the kind."""
    bound: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    """Number of elements of a list at most."""
    minimum: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    """Least value of an integer; absent: that of its ROS type."""
    maximum: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    """Greatest value of an integer; absent: that of its ROS type."""
    values: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """Named values of an integer, the only ones that it has: IDLE=0, BUSY=1."""


class FieldMapping(EObject, metaclass=MetaEClass):
    """A field of a ROS interface that carries a token field."""

    part: Choice[MessagePart] = Ecore.EAttribute(eType=MessagePart, default_value=MessagePart.message)
    """Part of the interface."""
    messageField: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Path in the interface, such as pose.position.x."""
    tokenField: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Name of the token field."""


class QualityOfService(EObject, metaclass=MetaEClass):
    """QoS policies of a topic."""

    reliability: Choice[Reliability] = Ecore.EAttribute(eType=Reliability, default_value=Reliability.reliable)
    """Reliability."""
    durability: Choice[Durability] = Ecore.EAttribute(eType=Durability, default_value=Durability.volatile)
    """Durability."""
    deadline: float | None = Ecore.EAttribute(eType=Ecore.EDoubleObject)
    """Longest time between two messages, in seconds; absent: any."""
    lifespan: float | None = Ecore.EAttribute(eType=Ecore.EDoubleObject)
    """How long a message is kept, in seconds; absent: forever."""
    liveliness: Choice[Liveliness] = Ecore.EAttribute(eType=Liveliness, default_value=Liveliness.automatic)
    """Liveliness."""
    leaseDuration: float | None = Ecore.EAttribute(eType=Ecore.EDoubleObject)
    """Longest time between two signs of life, in seconds; absent: any."""


@Ecore.abstract
class TopicPort(EObject, metaclass=MetaEClass):
    """Where a topic meets a node net."""

    place: Mandatory[pn.Place] = reference("pn.Place", lower=1, required=True)
    """The place whose tokens are the messages."""
    limit: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=10)
    """Capacity of the port's queue, 1 or more."""
    qos: QualityOfService | None = reference("QualityOfService", containment=True)
    """Quality of service of the port; absent: the topic's. The depth of its history is the limit."""
    assumed: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """What is assumed about it, as neither an observation nor a person states it; words separated by blanks:
    limit, qos. Absent: nothing.
    """
    latency: pn.TimeInterval | None = reference("pn.TimeInterval", containment=True)
    """How long messages of this port are on their way, in seconds; absent: as long as those of its channel."""


class Dispatcher(EObject, metaclass=MetaEClass):
    """Dispatcher queue of a subscribing node net."""

    channel: TopicChannel | None = reference("TopicChannel", opposite="dispatchers")
    """The topic."""
    node: Mandatory[NodeNet] = reference("NodeNet", lower=1, required=True)
    """The subscribing node net."""
    limit: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=16)
    """Capacity, 1 or more."""


class ServerPort(EObject, metaclass=MetaEClass):
    """The server page's entry and exit."""

    channel: ServiceChannel | None = reference("ServiceChannel", opposite="server")
    """The service."""
    entry: Mandatory[pn.Place] = reference("pn.Place", lower=1, required=True)
    """Receives requests."""
    exit: Mandatory[pn.Place] = reference("pn.Place", lower=1, required=True)
    """Holds responses."""
    page: Mandatory[pn.Page] = reference("pn.Page", lower=1, required=True)
    """The server page: a prototype, replicated per instance."""


class ClientPort(EObject, metaclass=MetaEClass):
    """A client of a service."""

    channel: ServiceChannel | None = reference("ServiceChannel", opposite="clients")
    """The service."""
    client: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Id of the client, unique in its service."""
    request: Mandatory[pn.Place] = reference("pn.Place", lower=1, required=True)
    """Holds requests."""
    response: Mandatory[pn.Place] = reference("pn.Place", lower=1, required=True)
    """Receives responses."""
    group: CallbackGroup | None = reference("CallbackGroup")
    """Callback group that takes its responses; absent: that of the node, which is exclusive."""
    outstanding: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    """Requests that the client has under way at most, -1 for any number; absent: 1 where the client waits
    for the response, else any number.
    """
    timeout: float | None = Ecore.EAttribute(eType=Ecore.EDoubleObject)
    """Seconds until the client gives up; absent: it waits forever."""
    timedOut: pn.Place | None = reference("pn.Place")
    """Gets a token when the client gives up; absent: it is ready to ask again."""
    waitsForService: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    """Of a node written by hand: it calls `wait_for_service` before each request, so it sends none while the
    server's node is not configured. False: it sends at once, and the request is lost. Nodes that run our
    engine send again what was not answered.
    """
    latency: pn.TimeInterval | None = reference("pn.TimeInterval", containment=True)
    """How long messages of this port are on their way, in seconds; absent: as long as those of its channel."""
    assumed: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """What is assumed about it, as neither an observation nor a person states it; words separated by blanks:
    group. Absent: nothing.
    """


class ActionServerPort(EObject, metaclass=MetaEClass):
    """The server of an action."""

    channel: ActionChannel | None = reference("ActionChannel")
    """The action."""
    page: Mandatory[pn.Page] = reference("pn.Page", lower=1, required=True)
    """What works on a goal: a prototype, replicated per slot. In its callback group, goals and requests to
    cancel are accepted or refused; what works on a goal is in none.
    """
    entry: Mandatory[pn.Place] = reference("pn.Place", lower=1, required=True)
    """Receives goals that are accepted."""
    succeeded: pn.Place | None = reference("pn.Place")
    """Holds results of goals that succeed; absent: none does."""
    aborted: pn.Place | None = reference("pn.Place")
    """Holds results of goals that are aborted; absent: none is."""
    canceled: pn.Place | None = reference("pn.Place")
    """Holds results of goals that are canceled, which only goals with a request to cancel may be; absent:
    none is.
    """
    cancel: pn.Place | None = reference("pn.Place")
    """Gets a token when the goal is to be canceled, once for each goal; absent: all requests to cancel are
    refused.
    """
    feedback: pn.Place | None = reference("pn.Place")
    """Holds feedback for the client whose goal it is; absent: it gives none."""
    mayReject: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    """Whether the server may refuse a goal."""


class ActionClientPort(EObject, metaclass=MetaEClass):
    """A client of an action."""

    channel: ActionChannel | None = reference("ActionChannel")
    """The action."""
    client: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Id of the client, unique in its action."""
    goal: Mandatory[pn.Place] = reference("pn.Place", lower=1, required=True)
    """Holds goals to be sent."""
    succeeded: pn.Place | None = reference("pn.Place")
    """Receives results of goals that succeeded; absent: no client fetches them."""
    aborted: pn.Place | None = reference("pn.Place")
    """Receives results of goals that were aborted; absent: no client fetches them."""
    canceled: pn.Place | None = reference("pn.Place")
    """Receives results of goals that were canceled; absent: no client fetches them."""
    accepted: pn.Place | None = reference("pn.Place")
    """Gets a token when the client learns that the server has accepted a goal; absent: it does not ask."""
    rejected: pn.Place | None = reference("pn.Place")
    """Gets a token when the server refuses a goal; absent: the client is just ready for the next one."""
    cancel: pn.Place | None = reference("pn.Place")
    """A token here asks the server to cancel the goal that it works on; absent: the client never asks."""
    feedback: pn.Place | None = reference("pn.Place")
    """Receives feedback about its goals; absent: it listens to none."""
    group: CallbackGroup | None = reference("CallbackGroup")
    """Callback group that takes answers, results and feedback; absent: that of the node, which is exclusive."""
    outstanding: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    """Goals that the client has under way at most, 1 or more; absent: 1 where the client waits for the end
    of a goal or its node runs our engine, else any number.
    """
    latency: pn.TimeInterval | None = reference("pn.TimeInterval", containment=True)
    """How long messages of this port are on their way, in seconds; absent: as long as those of its channel."""
    assumed: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """What is assumed about it, as neither an observation nor a person states it; words separated by blanks:
    group. Absent: nothing.
    """


class CallbackGroup(pn.Element):
    """A ROS callback group."""

    kind: Choice[CallbackGroupKind] = Ecore.EAttribute(
        eType=CallbackGroupKind, default_value=CallbackGroupKind.exclusive
    )
    """Which callbacks may run together."""
    priority: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=0)
    """Higher runs first."""


class InputSignal(pn.Element):
    """A boolean, or one of several values, set from outside (paper, Sect. 5.3.3)."""

    node: NodeNet | None = reference("NodeNet", opposite="signals")
    """The node net it belongs to."""
    initial: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    """Value at the start, of a boolean."""
    values: ModelList[SignalValue] = reference("SignalValue", opposite="signal", containment=True, upper=-1)
    """Its values by name, two or more; none: it is true or false."""
    start: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """Which of its values it has at the start; absent: the first."""
    literals: ModelList[Literal] = reference("Literal", opposite="signal", upper=-1, transient=True)
    """Where clauses use it."""


class TokenType(pn.Element):
    """What tokens of some places carry."""

    fields: ModelList[TokenField] = reference("TokenField", containment=True, upper=-1)
    """Its fields, in order."""
    ros: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """Installed ROS message (package/msg/Name) whose fields its tokens have; absent: one is generated."""


@Ecore.abstract
class Channel(pn.Element):
    """Joins node nets; nothing else may."""

    model: SystemModel | None = reference("SystemModel", opposite="channels")
    """The system model."""
    canvas: pn.Page | None = reference("pn.Page")
    """The page a net editor draws it on."""
    type: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """ROS interface (package/msg/Name or package/srv/Name); absent: that of the token types of its places."""
    mappings: ModelList[FieldMapping] = reference("FieldMapping", containment=True, upper=-1)
    """How fields of an existing ROS interface map to token fields."""
    assumed: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """What is assumed about it, as neither an observation nor a person states it; words separated by blanks:
    depth, server. Absent: nothing.
    """
    latency: pn.TimeInterval | None = reference("pn.TimeInterval", containment=True)
    """How long a message is on its way, in seconds: from publisher to reader history, or of each request and
    each response; absent: that of the model.
    """


class PublisherPort(TopicPort):
    """Sends the tokens of its place."""

    channel: TopicChannel | None = reference("TopicChannel", opposite="publishers")
    """The topic."""


class SubscriberPort(TopicPort):
    """Puts received messages on its place."""

    channel: TopicChannel | None = reference("TopicChannel", opposite="subscribers")
    """The topic."""
    inHand: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    """Messages that the node takes before it has worked on them, -1 for any number; absent: as many as one
    transition takes.
    """
    newestOnly: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    """Whether the reader needs the newest message only: that a newer message displaces an older one is then
    no loss.
    """
    missed: pn.Place | None = reference("pn.Place")
    """Gets a token when the node has taken no message for the deadline of the port's quality of service,
    once until the next message; absent: nothing does.
    """


class Property(pn.Element):
    """What is asked of a model, and what is expected."""

    text: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """The pattern or the formula."""
    language: Choice[PropertyLanguage] = Ecore.EAttribute(
        eType=PropertyLanguage, default_value=PropertyLanguage.words
    )
    """What the text is written in."""
    signals: Choice[SignalVariant] = Ecore.EAttribute(eType=SignalVariant, default_value=SignalVariant.none)
    """What of the signals is in the net that is asked."""
    expected: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=True)
    """Whether it is to hold."""


@Ecore.abstract
class Assumption(pn.Element):
    """What all properties of a model may rely on."""


class SystemModel(pn.Net):
    """The whole application: node nets on pages, joined by channels."""

    tokenType: TokenType | None = reference("TokenType", containment=True)
    """The first token type: what tokens carry in places that name no other."""
    otherTokenTypes: ModelList[TokenType] = reference("TokenType", containment=True, upper=-1)
    """Further token types, which places name."""
    channels: ModelList[Channel] = reference("Channel", containment=True, upper=-1)
    """Topics, services and actions, in order."""
    middleware: Choice[Middleware] = Ecore.EAttribute(eType=Middleware, default_value=Middleware.ros1)
    """The rules that flatten it."""
    properties: ModelList[Property] = reference("Property", containment=True, upper=-1)
    """What is asked of it, in order."""
    assumptions: ModelList[Assumption] = reference("Assumption", containment=True, upper=-1)
    """What its properties may rely on."""
    finalCondition: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """Condition on markings: where it holds, the application may come to rest. Absent: places of the kind
    end decide.
    """
    times: DefaultTimes | None = reference("DefaultTimes", containment=True)
    """Times of what gives none of its own, in seconds; absent: any times."""


class TopicChannel(Channel):
    """Takes a token from one publisher place, puts one into every subscriber place (paper, Sect. 5.3.1)."""

    topic: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Topic name; one channel per name."""
    qos: QualityOfService | None = reference("QualityOfService", containment=True)
    """Quality of service; the depths are the ports' limits."""
    publishers: ModelList[PublisherPort] = reference("PublisherPort", containment=True, upper=-1)
    """Publishers, in order."""
    subscribers: ModelList[SubscriberPort] = reference("SubscriberPort", containment=True, upper=-1)
    """Subscribers, in order."""
    dispatchers: ModelList[Dispatcher] = reference("Dispatcher", containment=True, upper=-1)
    """Limits of the dispatcher queues that differ from 16."""


class ServiceChannel(Channel):
    """Carries requests of clients to server instances and the responses back (paper, Sect. 5.3.2)."""

    service: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Service name; one channel per name."""
    server: Mandatory[ServerPort] = reference("ServerPort", containment=True, lower=1, required=True)
    """The server."""
    clients: ModelList[ClientPort] = reference("ClientPort", containment=True, upper=-1)
    """The clients, in order."""
    instances: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    """Number of server instances; absent: the number of clients."""
    depth: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=10)
    """Requests that wait for the server before one is lost, 1 or more."""


class ActionChannel(Channel):
    """An action (exactly one channel for each action name): goals that are accepted or rejected, may be
    canceled, and end with a result.
    """

    action: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Action name."""
    server: Mandatory[ActionServerPort] = reference(
        "ActionServerPort", opposite="channel", containment=True, lower=1, required=True
    )
    """The server."""
    clients: ModelList[ActionClientPort] = reference(
        "ActionClientPort", opposite="channel", containment=True, upper=-1
    )
    """The clients."""
    instances: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    """Goals that the server works on at once, each in a slot of its own; absent: the number of clients."""
    depth: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=10)
    """QoS depth of the feedback."""


class Fairness(Assumption):
    """No run neglects these transitions forever."""

    of: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """A transition, all, signals, node:ID or all-but:T1,T2."""
    strong: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    """Whether those that are enabled again and again must fire, not only those enabled all the time."""


class ExclusiveSignals(Assumption):
    """These signals are never true together."""

    signals: ModelList[InputSignal] = reference("InputSignal", upper=-1)
    """The signals, two or more."""


class SourceAssumption(Assumption):
    """The model was made from code or observations, and lacks or presumes this: answers about all runs hold
    if it changes nothing. Properties are decided without it.
    """

    text: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """What is lacking or presumed, with its place in the code."""


class NodeNet(pn.Page):
    """A page that is exactly one ROS node (paper, Sect. 5.1)."""

    package: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """ROS package of the node; by default its name."""
    namespace: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """ROS namespace of the node."""
    executor: Choice[Executor] = Ecore.EAttribute(eType=Executor, default_value=Executor.single)
    """Executor of the node."""
    threads: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=1)
    """Threads of a multi-threaded executor, 1 or more."""
    signals: ModelList[InputSignal] = reference("InputSignal", containment=True, upper=-1)
    """Input signals of the node."""
    callbackGroups: ModelList[CallbackGroup] = reference("CallbackGroup", containment=True, upper=-1)
    """Callback groups of the node."""
    execution: Choice[Execution] = Ecore.EAttribute(eType=Execution, default_value=Execution.net)
    """What its callbacks wait for."""
    lifecycle: Lifecycle | None = reference("Lifecycle", containment=True)
    """How the node comes up, where it is a managed node; absent: it is there from the start."""
    assumed: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """What is assumed about it, as neither an observation nor a person states it; words separated by blanks:
    executor, timers, lifecycle; node: it is invented, and stands for unknown nodes at the other end of a
    channel. Absent: nothing.
    """
    reaction: pn.TimeInterval | None = reference("pn.TimeInterval", containment=True)
    """How long an engine of the execution net takes, in seconds, to fire what is enabled and has no
    interval; absent: that of the model.
    """
    order: Choice[CallbackOrder] = Ecore.EAttribute(eType=CallbackOrder, default_value=CallbackOrder.any)
    """Which callback that is ready the executor takes, with the execution callbacks."""


class CallbackPage(pn.Page):
    """A page that models one ROS callback."""

    kind: Choice[CallbackKind] = Ecore.EAttribute(eType=CallbackKind, default_value=CallbackKind.subscriber)
    """What calls it."""
    group: CallbackGroup | None = reference("CallbackGroup")
    """Its callback group; absent: that of the node, which is exclusive. A client callback that names none is
    in none.
    """
    timer: float | None = Ecore.EAttribute(eType=Ecore.EDoubleObject)
    """Period of a timer callback."""
    priority: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=0)
    """Higher runs first."""
    awaits: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    """Its callback awaits the answers to its calls, and gives its thread back meanwhile (`async def`)."""
    assumed: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """What is assumed about it, as neither an observation nor a person states it; words separated by blanks:
    group, behaviour, period. Absent: nothing.
    """
    duration: pn.TimeInterval | None = reference("pn.TimeInterval", containment=True)
    """Processor time of one run of the callback, in seconds, without what it waits for; absent: that of the
    model.
    """
    offset: pn.TimeInterval | None = reference("pn.TimeInterval", containment=True)
    """Of a timer: when it strikes first, in seconds from the start of the system; absent: from 0 to the
    period.
    """
    jitter: float | None = Ecore.EAttribute(eType=Ecore.EDoubleObject)
    """Of a timer: how late, in seconds, a single strike may be; later strikes do not shift. Absent: 0."""


class Place(pn.Place):
    """A place whose tokens carry data."""

    balloons: ModelList[BalloonToken] = reference("BalloonToken", containment=True, upper=-1)
    """Data of the first initial tokens; the others carry the defaults."""
    kind: Choice[PlaceKind] = Ecore.EAttribute(eType=PlaceKind, default_value=PlaceKind.ordinary)
    """Role in the workflow."""
    tokenType: TokenType | None = reference("TokenType")
    """What its tokens carry; absent: the model's first token type."""


class Transition(pn.Transition):
    """A transition that may depend on input signals."""

    kind: Choice[TransitionKind] = Ecore.EAttribute(
        eType=TransitionKind, default_value=TransitionKind.discrete
    )
    """Role in the workflow."""
    clause: InputClause | None = reference("InputClause", containment=True)
    """It may fire only while this holds."""
    duration: pn.TimeInterval | None = reference("pn.TimeInterval", containment=True)
    """How long its handler is in flight, in seconds, in a node net of the execution net; absent: that of the
    model.
    """
    guard: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """It takes and reads only tokens whose fields fulfil this: Response.success = false."""
    assigns: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """Fields of the tokens that it puts: Answer.success := true, Log.mode := Entry.mode. Others may have any
    value.
    """


complete(sys.modules[__name__])
