"""System model (SyM): one model of a whole distributed ROS application (paper, Sect. 5.3).

Generated from `sym.ecore` by `make regenerate`; edits are lost.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Never

import pyecore.ecore as Ecore
from pyecore.resources import global_registry

from dineros.metamodel import pn
from dineros.metamodel.base import (
    EnumLiteral,
    EObject,
    MetaEClass,
    ModelList,
    enumeration,
    initialise,
    notify_listeners,
    refuse_unknown,
    resolve_references,
    show,
)

name = "sym"
nsURI = "http://dineros.org/sym/1.0"
nsPrefix = "sym"

eClass = Ecore.EPackage(name=name, nsURI=nsURI, nsPrefix=nsPrefix)
eClassifiers: dict[str, Any] = {}
getEClassifier = partial(Ecore.getEClassifier, searchspace=eClassifiers)
eSubpackages: list[Any] = []
eSuperPackage = None

__all__ = [
    "ActionChannel",
    "ActionClientPort",
    "ActionServerPort",
    "Assumption",
    "BalloonToken",
    "CallbackGroup",
    "CallbackGroupKind",
    "CallbackKind",
    "CallbackOrder",
    "CallbackPage",
    "Channel",
    "ClientPort",
    "DefaultTimes",
    "Disjunction",
    "Dispatcher",
    "Durability",
    "ExclusiveSignals",
    "Execution",
    "Executor",
    "Fairness",
    "FieldKind",
    "FieldMapping",
    "InputClause",
    "InputSignal",
    "Lifecycle",
    "Literal",
    "Liveliness",
    "MessagePart",
    "Middleware",
    "NodeNet",
    "Place",
    "PlaceKind",
    "Property",
    "PropertyLanguage",
    "PublisherPort",
    "QualityOfService",
    "Reliability",
    "ServerPort",
    "ServiceChannel",
    "SignalValue",
    "SignalVariant",
    "SubscriberPort",
    "SystemModel",
    "TokenField",
    "TokenType",
    "TopicChannel",
    "TopicPort",
    "Transition",
    "TransitionKind",
]

if TYPE_CHECKING:

    class Executor(EnumLiteral):
        """How a ROS node runs its callbacks."""

        single: ClassVar[Executor]
        """Single-threaded."""
        multi: ClassVar[Executor]
        """Multi-threaded."""

    class CallbackGroupKind(EnumLiteral):
        """Which callbacks of a group may run at the same time."""

        exclusive: ClassVar[CallbackGroupKind]
        """One at a time."""
        reentrant: ClassVar[CallbackGroupKind]
        """Any number."""

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

    class PlaceKind(EnumLiteral):
        """Role of a place in the workflow of its node."""

        ordinary: ClassVar[PlaceKind]
        """No special role."""
        start: ClassVar[PlaceKind]
        """Where the workflow starts."""
        end: ClassVar[PlaceKind]
        """Where the workflow ends."""

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

    class Reliability(EnumLiteral):
        """QoS reliability of a topic."""

        reliable: ClassVar[Reliability]
        """Sent again until received."""
        bestEffort: ClassVar[Reliability]
        """Sent once."""

    class Durability(EnumLiteral):
        """QoS durability of a topic."""

        volatile: ClassVar[Durability]
        """Late subscribers miss what was sent."""
        transientLocal: ClassVar[Durability]
        """Late subscribers get what the publisher kept."""

    class Middleware(EnumLiteral):
        """Whose queues a flattened model has."""

        ros1: ClassVar[Middleware]
        """The paper's: publisher, dispatcher and subscriber queues."""
        ros2: ClassVar[Middleware]
        """Writer and reader histories, and capacities."""

    class Liveliness(EnumLiteral):
        """QoS liveliness of a topic: who says that a publisher is alive."""

        automatic: ClassVar[Liveliness]
        """The middleware, while the process runs."""
        manualByTopic: ClassVar[Liveliness]
        """The publisher itself, by publishing or asserting."""

    class Execution(EnumLiteral):
        """How the callbacks of a node run."""

        net: ClassVar[Execution]
        """The net interleaves them: the node runs our engine, and its callbacks only put tokens."""
        callbacks: ClassVar[Execution]
        """One after another where executor and callback groups say so: the node is written by hand."""

    class CallbackOrder(EnumLiteral):
        """Which of the callbacks that are ready an executor takes."""

        any: ClassVar[CallbackOrder]
        """Each may be next."""
        rclcpp: ClassVar[CallbackOrder]
        """As the executors of rclcpp take them."""
        rclpy: ClassVar[CallbackOrder]
        """As the executors of rclpy take them."""

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

    class PropertyLanguage(EnumLiteral):
        """What a property is written in."""

        words: ClassVar[PropertyLanguage]
        """A pattern in words, such as never or leads to."""
        ltl: ClassVar[PropertyLanguage]
        """Linear temporal logic."""
        ctl: ClassVar[PropertyLanguage]
        """Branching temporal logic."""

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

else:
    Executor = enumeration(
        "Executor",
        [
            "single",
            "multi",
        ],
    )
    CallbackGroupKind = enumeration(
        "CallbackGroupKind",
        [
            "exclusive",
            "reentrant",
        ],
    )
    CallbackKind = enumeration(
        "CallbackKind",
        [
            "timer",
            "subscriber",
            "server",
            "client",
            "goal",
        ],
    )
    PlaceKind = enumeration(
        "PlaceKind",
        [
            "ordinary",
            "start",
            "end",
        ],
    )
    TransitionKind = enumeration(
        "TransitionKind",
        [
            "discrete",
            "timed",
            "start",
            "end",
        ],
    )
    FieldKind = enumeration(
        "FieldKind",
        [
            "text",
            "integer",
            "number",
            "boolean",
            "list",
            "map",
        ],
    )
    Reliability = enumeration(
        "Reliability",
        [
            "reliable",
            "bestEffort",
        ],
    )
    Durability = enumeration(
        "Durability",
        [
            "volatile",
            "transientLocal",
        ],
    )
    Middleware = enumeration(
        "Middleware",
        [
            "ros1",
            "ros2",
        ],
    )
    Liveliness = enumeration(
        "Liveliness",
        [
            "automatic",
            "manualByTopic",
        ],
    )
    Execution = enumeration(
        "Execution",
        [
            "net",
            "callbacks",
        ],
    )
    CallbackOrder = enumeration(
        "CallbackOrder",
        [
            "any",
            "rclcpp",
            "rclpy",
        ],
    )
    MessagePart = enumeration(
        "MessagePart",
        [
            "message",
            "request",
            "response",
            "goal",
            "result",
            "feedback",
        ],
    )
    PropertyLanguage = enumeration(
        "PropertyLanguage",
        [
            "words",
            "ltl",
            "ctl",
        ],
    )
    SignalVariant = enumeration(
        "SignalVariant",
        [
            "none",
            "fullyEnabled",
            "inputEnabled",
            "ioEnabled",
        ],
    )


class DefaultTimes(EObject, metaclass=MetaEClass):
    """Times, in seconds, of what gives none of its own.

    Attributes
    ----------
    latency : pn.TimeInterval | None
        Of the messages of channels.
    duration : pn.TimeInterval | None
        Of the runs of callbacks, and of handlers in flight.
    reaction : pn.TimeInterval | None
        Of engines of the execution net.
    """

    latency: pn.TimeInterval | None = Ecore.EReference(containment=True)
    duration: pn.TimeInterval | None = Ecore.EReference(containment=True)
    reaction: pn.TimeInterval | None = Ecore.EReference(containment=True)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

    def __init__(
        self,
        *,
        latency: pn.TimeInterval | None = None,
        duration: pn.TimeInterval | None = None,
        reaction: pn.TimeInterval | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class Lifecycle(EObject, metaclass=MetaEClass):
    """Life of a managed node (ROS 2 design: Managed nodes): unconfigured, inactive, active, finalized. It
    may always be configured and activated.

    Attributes
    ----------
    deactivates : bool
        It may be deactivated.
    cleansUp : bool
        It may be cleaned up: what its configuring made is gone.
    shutsDown : bool
        It may be shut down forever.
    configureFails : bool
        Configuring may fail, which leaves it unconfigured.
    activateFails : bool
        Activating may fail, which leaves it inactive.
    pauses : bool
        What the node does of itself rests while it is inactive; by default only its publishers do.
    configureStep : int
        Step of the start order in which it is configured: after all that earlier steps do; 0: at any
        time.
    activateStep : int
        Step of the start order in which it is activated: after all that earlier steps do; 0: at any time.
    """

    deactivates: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    cleansUp: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    shutsDown: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    configureFails: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    activateFails: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    pauses: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    configureStep: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=0)
    activateStep: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=0)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

    def __init__(
        self,
        *,
        deactivates: bool | None = None,
        cleansUp: bool | None = None,
        shutsDown: bool | None = None,
        configureFails: bool | None = None,
        activateFails: bool | None = None,
        pauses: bool | None = None,
        configureStep: int | None = None,
        activateStep: int | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class BalloonToken(EObject, metaclass=MetaEClass):
    """Data of one token (paper, Sect. 5.2); influences enabling only by guards.

    Attributes
    ----------
    data : str
        JSON object: field name to value.
    """

    data: str = Ecore.EAttribute(eType=Ecore.EString, default_value="{}")

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

    def __init__(self, *, data: str | None = None, **unknown: Never) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class SignalValue(EObject, metaclass=MetaEClass):
    """One of the values of an input signal.

    Attributes
    ----------
    signal : InputSignal | None
        The signal.
    name : str
        What it is called.
    """

    signal: InputSignal | None = Ecore.EReference()
    name: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

    def __init__(
        self, *, signal: InputSignal | None = None, name: str | None = None, **unknown: Never
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class InputClause(EObject, metaclass=MetaEClass):
    """Named boolean expression over signals of the same node net.

    Attributes
    ----------
    transition : Transition | None
        The transition it guards.
    name : str | None
        Name of the clause.
    text : str
        The expression as its author wrote it.
    disjunctions : ModelList[Disjunction]
        Conjunctive normal form of the text; none: always true.
    """

    transition: Transition | None = Ecore.EReference()
    name: str | None = Ecore.EAttribute(eType=Ecore.EString)
    text: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    disjunctions: ModelList[Disjunction] = Ecore.EReference(containment=True, upper=-1)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

    def __init__(
        self,
        *,
        transition: Transition | None = None,
        name: str | None = None,
        text: str | None = None,
        disjunctions: Iterable[Disjunction] | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class Disjunction(EObject, metaclass=MetaEClass):
    """True when one of its literals is; without literals it is false.

    Attributes
    ----------
    clause : InputClause | None
        The clause it is part of.
    literals : ModelList[Literal]
        Its literals.
    """

    clause: InputClause | None = Ecore.EReference()
    literals: ModelList[Literal] = Ecore.EReference(containment=True, upper=-1)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

    def __init__(
        self,
        *,
        clause: InputClause | None = None,
        literals: Iterable[Literal] | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class Literal(EObject, metaclass=MetaEClass):
    """A boolean signal, or that a signal has a value; or the negation.

    Attributes
    ----------
    disjunction : Disjunction | None
        The disjunction it is part of.
    signal : InputSignal
        The signal.
    negated : bool
        True for the negation.
    value : str | None
        The value that the signal is compared with; absent: it is a boolean.
    """

    disjunction: Disjunction | None = Ecore.EReference()
    signal: InputSignal = Ecore.EReference(lower=1, required=True)
    negated: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    value: str | None = Ecore.EAttribute(eType=Ecore.EString)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

    def __init__(
        self,
        *,
        disjunction: Disjunction | None = None,
        signal: InputSignal | None = None,
        negated: bool | None = None,
        value: str | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class TokenField(EObject, metaclass=MetaEClass):
    """One field of the token type.

    Attributes
    ----------
    name : str
        Name of the field.
    kind : FieldKind
        Type of its value.
    elementKind : FieldKind
        Type of the elements of a list or map.
    length : int | None
        Number of elements of a list of fixed length.
    default : str | None
        Default value as JSON; absent: the kind's empty value.
    ros : str | None
        ROS type of the value, or of the elements, such as uint8 or string<=20; absent: that of the kind.
    bound : int | None
        Number of elements of a list at most.
    minimum : int | None
        Least value of an integer; absent: that of its ROS type.
    maximum : int | None
        Greatest value of an integer; absent: that of its ROS type.
    values : str | None
        Named values of an integer, the only ones that it has: IDLE=0, BUSY=1.
    """

    name: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    kind: FieldKind = Ecore.EAttribute(eType=FieldKind, default_value=FieldKind.text)
    elementKind: FieldKind = Ecore.EAttribute(eType=FieldKind, default_value=FieldKind.text)
    length: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    default: str | None = Ecore.EAttribute(eType=Ecore.EString)
    ros: str | None = Ecore.EAttribute(eType=Ecore.EString)
    bound: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    minimum: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    maximum: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    values: str | None = Ecore.EAttribute(eType=Ecore.EString)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

    def __init__(
        self,
        *,
        name: str | None = None,
        kind: FieldKind | str | None = None,
        elementKind: FieldKind | str | None = None,
        length: int | None = None,
        default: str | None = None,
        ros: str | None = None,
        bound: int | None = None,
        minimum: int | None = None,
        maximum: int | None = None,
        values: str | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class FieldMapping(EObject, metaclass=MetaEClass):
    """A field of a ROS interface that carries a token field.

    Attributes
    ----------
    part : MessagePart
        Part of the interface.
    messageField : str
        Path in the interface, such as pose.position.x.
    tokenField : str
        Name of the token field.
    """

    part: MessagePart = Ecore.EAttribute(eType=MessagePart, default_value=MessagePart.message)
    messageField: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    tokenField: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

    def __init__(
        self,
        *,
        part: MessagePart | str | None = None,
        messageField: str | None = None,
        tokenField: str | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class QualityOfService(EObject, metaclass=MetaEClass):
    """QoS policies of a topic.

    Attributes
    ----------
    reliability : Reliability
        Reliability.
    durability : Durability
        Durability.
    deadline : float | None
        Longest time between two messages, in seconds; absent: any.
    lifespan : float | None
        How long a message is kept, in seconds; absent: forever.
    liveliness : Liveliness
        Liveliness.
    leaseDuration : float | None
        Longest time between two signs of life, in seconds; absent: any.
    """

    reliability: Reliability = Ecore.EAttribute(eType=Reliability, default_value=Reliability.reliable)
    durability: Durability = Ecore.EAttribute(eType=Durability, default_value=Durability.volatile)
    deadline: float | None = Ecore.EAttribute(eType=Ecore.EDoubleObject)
    lifespan: float | None = Ecore.EAttribute(eType=Ecore.EDoubleObject)
    liveliness: Liveliness = Ecore.EAttribute(eType=Liveliness, default_value=Liveliness.automatic)
    leaseDuration: float | None = Ecore.EAttribute(eType=Ecore.EDoubleObject)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

    def __init__(
        self,
        *,
        reliability: Reliability | str | None = None,
        durability: Durability | str | None = None,
        deadline: float | None = None,
        lifespan: float | None = None,
        liveliness: Liveliness | str | None = None,
        leaseDuration: float | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


@Ecore.abstract
class TopicPort(EObject, metaclass=MetaEClass):
    """Where a topic meets a node net.

    Attributes
    ----------
    place : pn.Place
        The place whose tokens are the messages.
    limit : int
        Capacity of the port's queue, 1 or more.
    qos : QualityOfService | None
        Quality of service of the port; absent: the topic's. The depth of its history is the limit.
    assumed : str | None
        What is assumed about it, as neither an observation nor a person states it; words separated by
        blanks: limit, qos. Absent: nothing.
    latency : pn.TimeInterval | None
        How long messages of this port are on their way, in seconds; absent: as long as those of its
        channel.
    """

    place: pn.Place = Ecore.EReference(lower=1, required=True)
    limit: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=10)
    qos: QualityOfService | None = Ecore.EReference(containment=True)
    assumed: str | None = Ecore.EAttribute(eType=Ecore.EString)
    latency: pn.TimeInterval | None = Ecore.EReference(containment=True)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

    def __init__(
        self,
        *,
        place: pn.Place | None = None,
        limit: int | None = None,
        qos: QualityOfService | None = None,
        assumed: str | None = None,
        latency: pn.TimeInterval | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class Dispatcher(EObject, metaclass=MetaEClass):
    """Dispatcher queue of a subscribing node net.

    Attributes
    ----------
    channel : TopicChannel | None
        The topic.
    node : NodeNet
        The subscribing node net.
    limit : int
        Capacity, 1 or more.
    """

    channel: TopicChannel | None = Ecore.EReference()
    node: NodeNet = Ecore.EReference(lower=1, required=True)
    limit: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=16)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

    def __init__(
        self,
        *,
        channel: TopicChannel | None = None,
        node: NodeNet | None = None,
        limit: int | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class ServerPort(EObject, metaclass=MetaEClass):
    """The server page's entry and exit.

    Attributes
    ----------
    channel : ServiceChannel | None
        The service.
    entry : pn.Place
        Receives requests.
    exit : pn.Place
        Holds responses.
    page : pn.Page
        The server page: a prototype, replicated per instance.
    """

    channel: ServiceChannel | None = Ecore.EReference()
    entry: pn.Place = Ecore.EReference(lower=1, required=True)
    exit: pn.Place = Ecore.EReference(lower=1, required=True)
    page: pn.Page = Ecore.EReference(lower=1, required=True)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

    def __init__(
        self,
        *,
        channel: ServiceChannel | None = None,
        entry: pn.Place | None = None,
        exit: pn.Place | None = None,
        page: pn.Page | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class ClientPort(EObject, metaclass=MetaEClass):
    """A client of a service.

    Attributes
    ----------
    channel : ServiceChannel | None
        The service.
    client : str
        Id of the client, unique in its service.
    request : pn.Place
        Holds requests.
    response : pn.Place
        Receives responses.
    group : CallbackGroup | None
        Callback group that takes its responses; absent: that of the node, which is exclusive.
    outstanding : int | None
        Requests that the client has under way at most, -1 for any number; absent: 1 where the client
        waits for the response, else any number.
    timeout : float | None
        Seconds until the client gives up; absent: it waits forever.
    timedOut : pn.Place | None
        Gets a token when the client gives up; absent: it is ready to ask again.
    waitsForService : bool
        Of a node written by hand: it calls `wait_for_service` before each request, so it sends none while
        the server's node is not configured. False: it sends at once, and the request is lost. Nodes that
        run our engine send again what was not answered.
    latency : pn.TimeInterval | None
        How long messages of this port are on their way, in seconds; absent: as long as those of its
        channel.
    assumed : str | None
        What is assumed about it, as neither an observation nor a person states it; words separated by
        blanks: group. Absent: nothing.
    """

    channel: ServiceChannel | None = Ecore.EReference()
    client: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    request: pn.Place = Ecore.EReference(lower=1, required=True)
    response: pn.Place = Ecore.EReference(lower=1, required=True)
    group: CallbackGroup | None = Ecore.EReference()
    outstanding: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    timeout: float | None = Ecore.EAttribute(eType=Ecore.EDoubleObject)
    timedOut: pn.Place | None = Ecore.EReference()
    waitsForService: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    latency: pn.TimeInterval | None = Ecore.EReference(containment=True)
    assumed: str | None = Ecore.EAttribute(eType=Ecore.EString)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

    def __init__(
        self,
        *,
        channel: ServiceChannel | None = None,
        client: str | None = None,
        request: pn.Place | None = None,
        response: pn.Place | None = None,
        group: CallbackGroup | None = None,
        outstanding: int | None = None,
        timeout: float | None = None,
        timedOut: pn.Place | None = None,
        waitsForService: bool | None = None,
        latency: pn.TimeInterval | None = None,
        assumed: str | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class ActionServerPort(EObject, metaclass=MetaEClass):
    """The server of an action.

    Attributes
    ----------
    channel : ActionChannel | None
        The action.
    page : pn.Page
        What works on a goal: a prototype, replicated per slot. In its callback group, goals and requests
        to cancel are accepted or refused; what works on a goal is in none.
    entry : pn.Place
        Receives goals that are accepted.
    succeeded : pn.Place | None
        Holds results of goals that succeed; absent: none does.
    aborted : pn.Place | None
        Holds results of goals that are aborted; absent: none is.
    canceled : pn.Place | None
        Holds results of goals that are canceled, which only goals with a request to cancel may be;
        absent: none is.
    cancel : pn.Place | None
        Gets a token when the goal is to be canceled, once for each goal; absent: all requests to cancel
        are refused.
    feedback : pn.Place | None
        Holds feedback for the client whose goal it is; absent: it gives none.
    mayReject : bool
        Whether the server may refuse a goal.
    """

    channel: ActionChannel | None = Ecore.EReference()
    page: pn.Page = Ecore.EReference(lower=1, required=True)
    entry: pn.Place = Ecore.EReference(lower=1, required=True)
    succeeded: pn.Place | None = Ecore.EReference()
    aborted: pn.Place | None = Ecore.EReference()
    canceled: pn.Place | None = Ecore.EReference()
    cancel: pn.Place | None = Ecore.EReference()
    feedback: pn.Place | None = Ecore.EReference()
    mayReject: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

    def __init__(
        self,
        *,
        channel: ActionChannel | None = None,
        page: pn.Page | None = None,
        entry: pn.Place | None = None,
        succeeded: pn.Place | None = None,
        aborted: pn.Place | None = None,
        canceled: pn.Place | None = None,
        cancel: pn.Place | None = None,
        feedback: pn.Place | None = None,
        mayReject: bool | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class ActionClientPort(EObject, metaclass=MetaEClass):
    """A client of an action.

    Attributes
    ----------
    channel : ActionChannel | None
        The action.
    client : str
        Id of the client, unique in its action.
    goal : pn.Place
        Holds goals to be sent.
    succeeded : pn.Place | None
        Receives results of goals that succeeded; absent: no client fetches them.
    aborted : pn.Place | None
        Receives results of goals that were aborted; absent: no client fetches them.
    canceled : pn.Place | None
        Receives results of goals that were canceled; absent: no client fetches them.
    accepted : pn.Place | None
        Gets a token when the client learns that the server has accepted a goal; absent: it does not ask.
    rejected : pn.Place | None
        Gets a token when the server refuses a goal; absent: the client is just ready for the next one.
    cancel : pn.Place | None
        A token here asks the server to cancel the goal that it works on; absent: the client never asks.
    feedback : pn.Place | None
        Receives feedback about its goals; absent: it listens to none.
    group : CallbackGroup | None
        Callback group that takes answers, results and feedback; absent: that of the node, which is
        exclusive.
    outstanding : int | None
        Goals that the client has under way at most, 1 or more; absent: 1 where the client waits for the
        end of a goal or its node runs our engine, else any number.
    latency : pn.TimeInterval | None
        How long messages of this port are on their way, in seconds; absent: as long as those of its
        channel.
    assumed : str | None
        What is assumed about it, as neither an observation nor a person states it; words separated by
        blanks: group. Absent: nothing.
    """

    channel: ActionChannel | None = Ecore.EReference()
    client: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    goal: pn.Place = Ecore.EReference(lower=1, required=True)
    succeeded: pn.Place | None = Ecore.EReference()
    aborted: pn.Place | None = Ecore.EReference()
    canceled: pn.Place | None = Ecore.EReference()
    accepted: pn.Place | None = Ecore.EReference()
    rejected: pn.Place | None = Ecore.EReference()
    cancel: pn.Place | None = Ecore.EReference()
    feedback: pn.Place | None = Ecore.EReference()
    group: CallbackGroup | None = Ecore.EReference()
    outstanding: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    latency: pn.TimeInterval | None = Ecore.EReference(containment=True)
    assumed: str | None = Ecore.EAttribute(eType=Ecore.EString)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

    def __init__(
        self,
        *,
        channel: ActionChannel | None = None,
        client: str | None = None,
        goal: pn.Place | None = None,
        succeeded: pn.Place | None = None,
        aborted: pn.Place | None = None,
        canceled: pn.Place | None = None,
        accepted: pn.Place | None = None,
        rejected: pn.Place | None = None,
        cancel: pn.Place | None = None,
        feedback: pn.Place | None = None,
        group: CallbackGroup | None = None,
        outstanding: int | None = None,
        latency: pn.TimeInterval | None = None,
        assumed: str | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class CallbackGroup(pn.Element):
    """A ROS callback group.

    Attributes
    ----------
    kind : CallbackGroupKind
        Which callbacks may run together.
    priority : int
        Higher runs first.
    """

    kind: CallbackGroupKind = Ecore.EAttribute(
        eType=CallbackGroupKind, default_value=CallbackGroupKind.exclusive
    )
    priority: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=0)

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: pn.Graphics | None = None,
        labels: Iterable[pn.Label] | None = None,
        toolInfos: Iterable[pn.ToolInfo] | None = None,
        suppressions: Iterable[pn.Suppression] | None = None,
        kind: CallbackGroupKind | str | None = None,
        priority: int | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class InputSignal(pn.Element):
    """A boolean, or one of several values, set from outside (paper, Sect. 5.3.3).

    Attributes
    ----------
    node : NodeNet | None
        The node net it belongs to.
    initial : bool
        Value at the start, of a boolean.
    values : ModelList[SignalValue]
        Its values by name, two or more; none: it is true or false.
    start : str | None
        Which of its values it has at the start; absent: the first.
    literals : ModelList[Literal]
        Where clauses use it.
    """

    node: NodeNet | None = Ecore.EReference()
    initial: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    values: ModelList[SignalValue] = Ecore.EReference(containment=True, upper=-1)
    start: str | None = Ecore.EAttribute(eType=Ecore.EString)
    literals: ModelList[Literal] = Ecore.EReference(upper=-1, transient=True)

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: pn.Graphics | None = None,
        labels: Iterable[pn.Label] | None = None,
        toolInfos: Iterable[pn.ToolInfo] | None = None,
        suppressions: Iterable[pn.Suppression] | None = None,
        node: NodeNet | None = None,
        initial: bool | None = None,
        values: Iterable[SignalValue] | None = None,
        start: str | None = None,
        literals: Iterable[Literal] | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class TokenType(pn.Element):
    """What tokens of some places carry.

    Attributes
    ----------
    fields : ModelList[TokenField]
        Its fields, in order.
    ros : str | None
        Installed ROS message (package/msg/Name) whose fields its tokens have; absent: one is generated.
    """

    fields: ModelList[TokenField] = Ecore.EReference(containment=True, upper=-1)
    ros: str | None = Ecore.EAttribute(eType=Ecore.EString)

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: pn.Graphics | None = None,
        labels: Iterable[pn.Label] | None = None,
        toolInfos: Iterable[pn.ToolInfo] | None = None,
        suppressions: Iterable[pn.Suppression] | None = None,
        fields: Iterable[TokenField] | None = None,
        ros: str | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


@Ecore.abstract
class Channel(pn.Element):
    """Joins node nets; nothing else may.

    Attributes
    ----------
    model : SystemModel | None
        The system model.
    canvas : pn.Page | None
        The page a net editor draws it on.
    type : str | None
        ROS interface (package/msg/Name or package/srv/Name); absent: that of the token types of its
        places.
    mappings : ModelList[FieldMapping]
        How fields of an existing ROS interface map to token fields.
    assumed : str | None
        What is assumed about it, as neither an observation nor a person states it; words separated by
        blanks: depth, server. Absent: nothing.
    latency : pn.TimeInterval | None
        How long a message is on its way, in seconds: from publisher to reader history, or of each request
        and each response; absent: that of the model.
    """

    model: SystemModel | None = Ecore.EReference()
    canvas: pn.Page | None = Ecore.EReference()
    type: str | None = Ecore.EAttribute(eType=Ecore.EString)
    mappings: ModelList[FieldMapping] = Ecore.EReference(containment=True, upper=-1)
    assumed: str | None = Ecore.EAttribute(eType=Ecore.EString)
    latency: pn.TimeInterval | None = Ecore.EReference(containment=True)

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: pn.Graphics | None = None,
        labels: Iterable[pn.Label] | None = None,
        toolInfos: Iterable[pn.ToolInfo] | None = None,
        suppressions: Iterable[pn.Suppression] | None = None,
        model: SystemModel | None = None,
        canvas: pn.Page | None = None,
        type: str | None = None,
        mappings: Iterable[FieldMapping] | None = None,
        assumed: str | None = None,
        latency: pn.TimeInterval | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class PublisherPort(TopicPort):
    """Sends the tokens of its place.

    Attributes
    ----------
    channel : TopicChannel | None
        The topic.
    """

    channel: TopicChannel | None = Ecore.EReference()

    def __init__(
        self,
        *,
        place: pn.Place | None = None,
        limit: int | None = None,
        qos: QualityOfService | None = None,
        assumed: str | None = None,
        latency: pn.TimeInterval | None = None,
        channel: TopicChannel | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class SubscriberPort(TopicPort):
    """Puts received messages on its place.

    Attributes
    ----------
    channel : TopicChannel | None
        The topic.
    inHand : int | None
        Messages that the node takes before it has worked on them, -1 for any number; absent: as many as
        one transition takes.
    newestOnly : bool
        Whether the reader needs the newest message only: that a newer message displaces an older one is
        then no loss.
    missed : pn.Place | None
        Gets a token when the node has taken no message for the deadline of the port's quality of service,
        once until the next message; absent: nothing does.
    """

    channel: TopicChannel | None = Ecore.EReference()
    inHand: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    newestOnly: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    missed: pn.Place | None = Ecore.EReference()

    def __init__(
        self,
        *,
        place: pn.Place | None = None,
        limit: int | None = None,
        qos: QualityOfService | None = None,
        assumed: str | None = None,
        latency: pn.TimeInterval | None = None,
        channel: TopicChannel | None = None,
        inHand: int | None = None,
        newestOnly: bool | None = None,
        missed: pn.Place | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class Property(pn.Element):
    """What is asked of a model, and what is expected.

    Attributes
    ----------
    text : str
        The pattern or the formula.
    language : PropertyLanguage
        What the text is written in.
    signals : SignalVariant
        What of the signals is in the net that is asked.
    expected : bool
        Whether it is to hold.
    """

    text: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    language: PropertyLanguage = Ecore.EAttribute(
        eType=PropertyLanguage, default_value=PropertyLanguage.words
    )
    signals: SignalVariant = Ecore.EAttribute(eType=SignalVariant, default_value=SignalVariant.none)
    expected: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=True)

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: pn.Graphics | None = None,
        labels: Iterable[pn.Label] | None = None,
        toolInfos: Iterable[pn.ToolInfo] | None = None,
        suppressions: Iterable[pn.Suppression] | None = None,
        text: str | None = None,
        language: PropertyLanguage | str | None = None,
        signals: SignalVariant | str | None = None,
        expected: bool | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


@Ecore.abstract
class Assumption(pn.Element):
    """What all properties of a model may rely on."""

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: pn.Graphics | None = None,
        labels: Iterable[pn.Label] | None = None,
        toolInfos: Iterable[pn.ToolInfo] | None = None,
        suppressions: Iterable[pn.Suppression] | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class SystemModel(pn.Net):
    """The whole application: node nets on pages, joined by channels.

    Attributes
    ----------
    tokenType : TokenType | None
        The first token type: what tokens carry in places that name no other.
    otherTokenTypes : ModelList[TokenType]
        Further token types, which places name.
    channels : ModelList[Channel]
        Topics, services and actions, in order.
    middleware : Middleware
        The rules that flatten it.
    properties : ModelList[Property]
        What is asked of it, in order.
    assumptions : ModelList[Assumption]
        What its properties may rely on.
    finalCondition : str | None
        Condition on markings: where it holds, the application may come to rest. Absent: places of the
        kind end decide.
    times : DefaultTimes | None
        Times of what gives none of its own, in seconds; absent: any times.
    """

    tokenType: TokenType | None = Ecore.EReference(containment=True)
    otherTokenTypes: ModelList[TokenType] = Ecore.EReference(containment=True, upper=-1)
    channels: ModelList[Channel] = Ecore.EReference(containment=True, upper=-1)
    middleware: Middleware = Ecore.EAttribute(eType=Middleware, default_value=Middleware.ros1)
    properties: ModelList[Property] = Ecore.EReference(containment=True, upper=-1)
    assumptions: ModelList[Assumption] = Ecore.EReference(containment=True, upper=-1)
    finalCondition: str | None = Ecore.EAttribute(eType=Ecore.EString)
    times: DefaultTimes | None = Ecore.EReference(containment=True)

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: pn.Graphics | None = None,
        labels: Iterable[pn.Label] | None = None,
        toolInfos: Iterable[pn.ToolInfo] | None = None,
        suppressions: Iterable[pn.Suppression] | None = None,
        pages: Iterable[pn.Page] | None = None,
        tokenType: TokenType | None = None,
        otherTokenTypes: Iterable[TokenType] | None = None,
        channels: Iterable[Channel] | None = None,
        middleware: Middleware | str | None = None,
        properties: Iterable[Property] | None = None,
        assumptions: Iterable[Assumption] | None = None,
        finalCondition: str | None = None,
        times: DefaultTimes | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class TopicChannel(Channel):
    """Takes a token from one publisher place, puts one into every subscriber place (paper, Sect. 5.3.1).

    Attributes
    ----------
    topic : str
        Topic name; one channel per name.
    qos : QualityOfService | None
        Quality of service; the depths are the ports' limits.
    publishers : ModelList[PublisherPort]
        Publishers, in order.
    subscribers : ModelList[SubscriberPort]
        Subscribers, in order.
    dispatchers : ModelList[Dispatcher]
        Limits of the dispatcher queues that differ from 16.
    """

    topic: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    qos: QualityOfService | None = Ecore.EReference(containment=True)
    publishers: ModelList[PublisherPort] = Ecore.EReference(containment=True, upper=-1)
    subscribers: ModelList[SubscriberPort] = Ecore.EReference(containment=True, upper=-1)
    dispatchers: ModelList[Dispatcher] = Ecore.EReference(containment=True, upper=-1)

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: pn.Graphics | None = None,
        labels: Iterable[pn.Label] | None = None,
        toolInfos: Iterable[pn.ToolInfo] | None = None,
        suppressions: Iterable[pn.Suppression] | None = None,
        model: SystemModel | None = None,
        canvas: pn.Page | None = None,
        type: str | None = None,
        mappings: Iterable[FieldMapping] | None = None,
        assumed: str | None = None,
        latency: pn.TimeInterval | None = None,
        topic: str | None = None,
        qos: QualityOfService | None = None,
        publishers: Iterable[PublisherPort] | None = None,
        subscribers: Iterable[SubscriberPort] | None = None,
        dispatchers: Iterable[Dispatcher] | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class ServiceChannel(Channel):
    """Carries requests of clients to server instances and the responses back (paper, Sect. 5.3.2).

    Attributes
    ----------
    service : str
        Service name; one channel per name.
    server : ServerPort
        The server.
    clients : ModelList[ClientPort]
        The clients, in order.
    instances : int | None
        Number of server instances; absent: the number of clients.
    depth : int
        Requests that wait for the server before one is lost, 1 or more.
    """

    service: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    server: ServerPort = Ecore.EReference(containment=True, lower=1, required=True)
    clients: ModelList[ClientPort] = Ecore.EReference(containment=True, upper=-1)
    instances: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    depth: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=10)

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: pn.Graphics | None = None,
        labels: Iterable[pn.Label] | None = None,
        toolInfos: Iterable[pn.ToolInfo] | None = None,
        suppressions: Iterable[pn.Suppression] | None = None,
        model: SystemModel | None = None,
        canvas: pn.Page | None = None,
        type: str | None = None,
        mappings: Iterable[FieldMapping] | None = None,
        assumed: str | None = None,
        latency: pn.TimeInterval | None = None,
        service: str | None = None,
        server: ServerPort | None = None,
        clients: Iterable[ClientPort] | None = None,
        instances: int | None = None,
        depth: int | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class ActionChannel(Channel):
    """An action (exactly one channel for each action name): goals that are accepted or rejected, may be
    canceled, and end with a result.

    Attributes
    ----------
    action : str
        Action name.
    server : ActionServerPort
        The server.
    clients : ModelList[ActionClientPort]
        The clients.
    instances : int | None
        Goals that the server works on at once, each in a slot of its own; absent: the number of clients.
    depth : int
        QoS depth of the feedback.
    """

    action: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    server: ActionServerPort = Ecore.EReference(containment=True, lower=1, required=True)
    clients: ModelList[ActionClientPort] = Ecore.EReference(containment=True, upper=-1)
    instances: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    depth: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=10)

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: pn.Graphics | None = None,
        labels: Iterable[pn.Label] | None = None,
        toolInfos: Iterable[pn.ToolInfo] | None = None,
        suppressions: Iterable[pn.Suppression] | None = None,
        model: SystemModel | None = None,
        canvas: pn.Page | None = None,
        type: str | None = None,
        mappings: Iterable[FieldMapping] | None = None,
        assumed: str | None = None,
        latency: pn.TimeInterval | None = None,
        action: str | None = None,
        server: ActionServerPort | None = None,
        clients: Iterable[ActionClientPort] | None = None,
        instances: int | None = None,
        depth: int | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class Fairness(Assumption):
    """No run neglects these transitions forever.

    Attributes
    ----------
    of : str
        A transition, all, signals, node:ID or all-but:T1,T2.
    strong : bool
        Whether those that are enabled again and again must fire, not only those enabled all the time.
    """

    of: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    strong: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: pn.Graphics | None = None,
        labels: Iterable[pn.Label] | None = None,
        toolInfos: Iterable[pn.ToolInfo] | None = None,
        suppressions: Iterable[pn.Suppression] | None = None,
        of: str | None = None,
        strong: bool | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class ExclusiveSignals(Assumption):
    """These signals are never true together.

    Attributes
    ----------
    signals : ModelList[InputSignal]
        The signals, two or more.
    """

    signals: ModelList[InputSignal] = Ecore.EReference(upper=-1)

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: pn.Graphics | None = None,
        labels: Iterable[pn.Label] | None = None,
        toolInfos: Iterable[pn.ToolInfo] | None = None,
        suppressions: Iterable[pn.Suppression] | None = None,
        signals: Iterable[InputSignal] | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class NodeNet(pn.Page):
    """A page that is exactly one ROS node (paper, Sect. 5.1).

    Attributes
    ----------
    package : str | None
        ROS package of the node; by default its name.
    namespace : str | None
        ROS namespace of the node.
    executor : Executor
        Executor of the node.
    threads : int
        Threads of a multi-threaded executor, 1 or more.
    signals : ModelList[InputSignal]
        Input signals of the node.
    callbackGroups : ModelList[CallbackGroup]
        Callback groups of the node.
    execution : Execution
        What its callbacks wait for.
    lifecycle : Lifecycle | None
        How the node comes up, where it is a managed node; absent: it is there from the start.
    assumed : str | None
        What is assumed about it, as neither an observation nor a person states it; words separated by
        blanks: executor, timers, lifecycle; node: it is invented, and stands for unknown nodes at the
        other end of a channel. Absent: nothing.
    reaction : pn.TimeInterval | None
        How long an engine of the execution net takes, in seconds, to fire what is enabled and has no
        interval; absent: that of the model.
    order : CallbackOrder
        Which callback that is ready the executor takes, with the execution callbacks.
    """

    package: str | None = Ecore.EAttribute(eType=Ecore.EString)
    namespace: str | None = Ecore.EAttribute(eType=Ecore.EString)
    executor: Executor = Ecore.EAttribute(eType=Executor, default_value=Executor.single)
    threads: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=1)
    signals: ModelList[InputSignal] = Ecore.EReference(containment=True, upper=-1)
    callbackGroups: ModelList[CallbackGroup] = Ecore.EReference(containment=True, upper=-1)
    execution: Execution = Ecore.EAttribute(eType=Execution, default_value=Execution.net)
    lifecycle: Lifecycle | None = Ecore.EReference(containment=True)
    assumed: str | None = Ecore.EAttribute(eType=Ecore.EString)
    reaction: pn.TimeInterval | None = Ecore.EReference(containment=True)
    order: CallbackOrder = Ecore.EAttribute(eType=CallbackOrder, default_value=CallbackOrder.any)

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: pn.Graphics | None = None,
        labels: Iterable[pn.Label] | None = None,
        toolInfos: Iterable[pn.ToolInfo] | None = None,
        suppressions: Iterable[pn.Suppression] | None = None,
        page: pn.Page | None = None,
        net: pn.Net | None = None,
        objects: Iterable[pn.PageObject] | None = None,
        arcs: Iterable[pn.Arc] | None = None,
        package: str | None = None,
        namespace: str | None = None,
        executor: Executor | str | None = None,
        threads: int | None = None,
        signals: Iterable[InputSignal] | None = None,
        callbackGroups: Iterable[CallbackGroup] | None = None,
        execution: Execution | str | None = None,
        lifecycle: Lifecycle | None = None,
        assumed: str | None = None,
        reaction: pn.TimeInterval | None = None,
        order: CallbackOrder | str | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class CallbackPage(pn.Page):
    """A page that models one ROS callback.

    Attributes
    ----------
    kind : CallbackKind
        What calls it.
    group : CallbackGroup | None
        Its callback group; absent: that of the node, which is exclusive. A client callback that names
        none is in none.
    timer : float | None
        Period of a timer callback.
    priority : int
        Higher runs first.
    awaits : bool
        Its callback awaits the answers to its calls, and gives its thread back meanwhile (`async def`).
    assumed : str | None
        What is assumed about it, as neither an observation nor a person states it; words separated by
        blanks: group, behaviour, period. Absent: nothing.
    duration : pn.TimeInterval | None
        Processor time of one run of the callback, in seconds, without what it waits for; absent: that of
        the model.
    offset : pn.TimeInterval | None
        Of a timer: when it strikes first, in seconds from the start of the system; absent: from 0 to the
        period.
    jitter : float | None
        Of a timer: how late, in seconds, a single strike may be; later strikes do not shift. Absent: 0.
    """

    kind: CallbackKind = Ecore.EAttribute(eType=CallbackKind, default_value=CallbackKind.subscriber)
    group: CallbackGroup | None = Ecore.EReference()
    timer: float | None = Ecore.EAttribute(eType=Ecore.EDoubleObject)
    priority: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=0)
    awaits: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    assumed: str | None = Ecore.EAttribute(eType=Ecore.EString)
    duration: pn.TimeInterval | None = Ecore.EReference(containment=True)
    offset: pn.TimeInterval | None = Ecore.EReference(containment=True)
    jitter: float | None = Ecore.EAttribute(eType=Ecore.EDoubleObject)

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: pn.Graphics | None = None,
        labels: Iterable[pn.Label] | None = None,
        toolInfos: Iterable[pn.ToolInfo] | None = None,
        suppressions: Iterable[pn.Suppression] | None = None,
        page: pn.Page | None = None,
        net: pn.Net | None = None,
        objects: Iterable[pn.PageObject] | None = None,
        arcs: Iterable[pn.Arc] | None = None,
        kind: CallbackKind | str | None = None,
        group: CallbackGroup | None = None,
        timer: float | None = None,
        priority: int | None = None,
        awaits: bool | None = None,
        assumed: str | None = None,
        duration: pn.TimeInterval | None = None,
        offset: pn.TimeInterval | None = None,
        jitter: float | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class Place(pn.Place):
    """A place whose tokens carry data.

    Attributes
    ----------
    balloons : ModelList[BalloonToken]
        Data of the first initial tokens; the others carry the defaults.
    kind : PlaceKind
        Role in the workflow.
    tokenType : TokenType | None
        What its tokens carry; absent: the model's first token type.
    """

    balloons: ModelList[BalloonToken] = Ecore.EReference(containment=True, upper=-1)
    kind: PlaceKind = Ecore.EAttribute(eType=PlaceKind, default_value=PlaceKind.ordinary)
    tokenType: TokenType | None = Ecore.EReference()

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: pn.Graphics | None = None,
        labels: Iterable[pn.Label] | None = None,
        toolInfos: Iterable[pn.ToolInfo] | None = None,
        suppressions: Iterable[pn.Suppression] | None = None,
        page: pn.Page | None = None,
        outgoing: Iterable[pn.Arc] | None = None,
        incoming: Iterable[pn.Arc] | None = None,
        tokens: int | None = None,
        capacity: int | None = None,
        balloons: Iterable[BalloonToken] | None = None,
        kind: PlaceKind | str | None = None,
        tokenType: TokenType | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class Transition(pn.Transition):
    """A transition that may depend on input signals.

    Attributes
    ----------
    kind : TransitionKind
        Role in the workflow.
    clause : InputClause | None
        It may fire only while this holds.
    duration : pn.TimeInterval | None
        How long its handler is in flight, in seconds, in a node net of the execution net; absent: that of
        the model.
    guard : str | None
        It takes and reads only tokens whose fields fulfil this: Response.success = false.
    assigns : str | None
        Fields of the tokens that it puts: Answer.success := true, Log.mode := Entry.mode. Others may have
        any value.
    """

    kind: TransitionKind = Ecore.EAttribute(eType=TransitionKind, default_value=TransitionKind.discrete)
    clause: InputClause | None = Ecore.EReference(containment=True)
    duration: pn.TimeInterval | None = Ecore.EReference(containment=True)
    guard: str | None = Ecore.EAttribute(eType=Ecore.EString)
    assigns: str | None = Ecore.EAttribute(eType=Ecore.EString)

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: pn.Graphics | None = None,
        labels: Iterable[pn.Label] | None = None,
        toolInfos: Iterable[pn.ToolInfo] | None = None,
        suppressions: Iterable[pn.Suppression] | None = None,
        page: pn.Page | None = None,
        outgoing: Iterable[pn.Arc] | None = None,
        incoming: Iterable[pn.Arc] | None = None,
        interval: pn.TimeInterval | None = None,
        overrides: Iterable[pn.Transition] | None = None,
        kind: TransitionKind | str | None = None,
        clause: InputClause | None = None,
        duration: pn.TimeInterval | None = None,
        guard: str | None = None,
        assigns: str | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


resolve_references(
    types=[
        (DefaultTimes.latency, pn.TimeInterval),
        (DefaultTimes.duration, pn.TimeInterval),
        (DefaultTimes.reaction, pn.TimeInterval),
        (SignalValue.signal, InputSignal),
        (InputClause.transition, Transition),
        (InputClause.disjunctions, Disjunction),
        (Disjunction.clause, InputClause),
        (Disjunction.literals, Literal),
        (Literal.disjunction, Disjunction),
        (Literal.signal, InputSignal),
        (TopicPort.place, pn.Place),
        (TopicPort.qos, QualityOfService),
        (TopicPort.latency, pn.TimeInterval),
        (Dispatcher.channel, TopicChannel),
        (Dispatcher.node, NodeNet),
        (ServerPort.channel, ServiceChannel),
        (ServerPort.entry, pn.Place),
        (ServerPort.exit, pn.Place),
        (ServerPort.page, pn.Page),
        (ClientPort.channel, ServiceChannel),
        (ClientPort.request, pn.Place),
        (ClientPort.response, pn.Place),
        (ClientPort.group, CallbackGroup),
        (ClientPort.timedOut, pn.Place),
        (ClientPort.latency, pn.TimeInterval),
        (ActionServerPort.channel, ActionChannel),
        (ActionServerPort.page, pn.Page),
        (ActionServerPort.entry, pn.Place),
        (ActionServerPort.succeeded, pn.Place),
        (ActionServerPort.aborted, pn.Place),
        (ActionServerPort.canceled, pn.Place),
        (ActionServerPort.cancel, pn.Place),
        (ActionServerPort.feedback, pn.Place),
        (ActionClientPort.channel, ActionChannel),
        (ActionClientPort.goal, pn.Place),
        (ActionClientPort.succeeded, pn.Place),
        (ActionClientPort.aborted, pn.Place),
        (ActionClientPort.canceled, pn.Place),
        (ActionClientPort.accepted, pn.Place),
        (ActionClientPort.rejected, pn.Place),
        (ActionClientPort.cancel, pn.Place),
        (ActionClientPort.feedback, pn.Place),
        (ActionClientPort.group, CallbackGroup),
        (ActionClientPort.latency, pn.TimeInterval),
        (InputSignal.node, NodeNet),
        (InputSignal.values, SignalValue),
        (InputSignal.literals, Literal),
        (TokenType.fields, TokenField),
        (Channel.model, SystemModel),
        (Channel.canvas, pn.Page),
        (Channel.mappings, FieldMapping),
        (Channel.latency, pn.TimeInterval),
        (PublisherPort.channel, TopicChannel),
        (SubscriberPort.channel, TopicChannel),
        (SubscriberPort.missed, pn.Place),
        (SystemModel.tokenType, TokenType),
        (SystemModel.otherTokenTypes, TokenType),
        (SystemModel.channels, Channel),
        (SystemModel.properties, Property),
        (SystemModel.assumptions, Assumption),
        (SystemModel.times, DefaultTimes),
        (TopicChannel.qos, QualityOfService),
        (TopicChannel.publishers, PublisherPort),
        (TopicChannel.subscribers, SubscriberPort),
        (TopicChannel.dispatchers, Dispatcher),
        (ServiceChannel.server, ServerPort),
        (ServiceChannel.clients, ClientPort),
        (ActionChannel.server, ActionServerPort),
        (ActionChannel.clients, ActionClientPort),
        (ExclusiveSignals.signals, InputSignal),
        (NodeNet.signals, InputSignal),
        (NodeNet.callbackGroups, CallbackGroup),
        (NodeNet.lifecycle, Lifecycle),
        (NodeNet.reaction, pn.TimeInterval),
        (CallbackPage.group, CallbackGroup),
        (CallbackPage.duration, pn.TimeInterval),
        (CallbackPage.offset, pn.TimeInterval),
        (Place.balloons, BalloonToken),
        (Place.tokenType, TokenType),
        (Transition.clause, InputClause),
        (Transition.duration, pn.TimeInterval),
    ],
    opposites=[
        (InputClause.transition, Transition.clause),
        (Disjunction.clause, InputClause.disjunctions),
        (Disjunction.literals, Literal.disjunction),
        (Dispatcher.channel, TopicChannel.dispatchers),
        (ServerPort.channel, ServiceChannel.server),
        (ClientPort.channel, ServiceChannel.clients),
        (InputSignal.node, NodeNet.signals),
        (InputSignal.values, SignalValue.signal),
        (InputSignal.literals, Literal.signal),
        (Channel.model, SystemModel.channels),
        (PublisherPort.channel, TopicChannel.publishers),
        (SubscriberPort.channel, TopicChannel.subscribers),
        (ActionChannel.server, ActionServerPort.channel),
        (ActionChannel.clients, ActionClientPort.channel),
    ],
)

for _enumeration in (
    Executor,
    CallbackGroupKind,
    CallbackKind,
    PlaceKind,
    TransitionKind,
    FieldKind,
    Reliability,
    Durability,
    Middleware,
    Liveliness,
    Execution,
    CallbackOrder,
    MessagePart,
    PropertyLanguage,
    SignalVariant,
):
    eClassifiers[_enumeration.name] = _enumeration
    eClass.eClassifiers.append(_enumeration)
global_registry[nsURI] = sys.modules[__name__]
