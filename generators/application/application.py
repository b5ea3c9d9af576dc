"""What templates see of a model: the application and its nodes, in plain values and in model order."""

from __future__ import annotations

from dataclasses import dataclass

from dineros.generators.application.arcs import ArcEnd
from dineros.generators.application.cases import Case
from dineros.generators.application.interfaces import Interfaces
from dineros.generators.application.tokens import TokenClass
from dineros.generators.templates.filters import Name
from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.ros_names import resource_name, snake_case


@dataclass(frozen=True)
class Transition:
    """A transition of a node net.

    Attributes
    ----------
    id : str
        Its id in the model.
    function, type_name : str
        Name of the function that handles it; start of the names of its types: `Firing`, `Inputs`, `Outputs`.
    inputs, outputs : tuple of ArcEnd
        Where its arcs come from and go to, references followed.
    clause : str or None
        Its input clause.
    guard, assigns : str or None
        What it asks of the data of the tokens it takes, and what it gives to fields of those it puts.
    service : str or None
        The service whose server page it stands on: it exists once per instance.
    instances : int
        How many instances there are.
    case : Case
        How it can be made to fire by itself.
    types : dict of str to TokenClass
        What the tokens of its places carry.
    result : TokenClass
        What the data that continues carries, which a handler sees and changes.
    demanded : tuple of str
        Places that a handler has to name when it gives data, as nothing continues to them.
    is_typed : bool
        Whether it needs types of its own: not all its places have the first token type.
    """

    id: str
    function: Name
    type_name: Name
    inputs: tuple[ArcEnd, ...]
    outputs: tuple[ArcEnd, ...]
    clause: str | None
    guard: str | None
    assigns: str | None
    service: str | None
    instances: int
    case: Case
    types: dict[str, TokenClass]
    result: TokenClass
    demanded: tuple[str, ...]
    is_typed: bool

    @property
    def names(self) -> list[str]:
        """What handlers may be registered for: all of it, or one server instance."""
        if self.service is None:
            return [self.id]
        return [self.id, *(f"{self.service}[{number}].{self.id}" for number in range(1, self.instances + 1))]

    @property
    def input_places(self) -> list[str]:
        """Places whose tokens a handler sees, in the order of the arcs."""
        return list(dict.fromkeys(end.place for end in self.inputs if end.kind != "inhibitor"))

    @property
    def output_places(self) -> list[str]:
        """Places that a handler may give data, in the order of the arcs."""
        read = [end.place for end in self.inputs if end.kind == "read"]
        return list(dict.fromkeys([*(end.place for end in self.outputs), *read]))

    @property
    def given(self) -> dict[str, dict[str, object]]:
        """What a handler has to give at least: for each demanded place, no field but the defaults."""
        return {place: {} for place in self.demanded}

    @property
    def conditions(self) -> list[str]:
        """What has to hold besides its arcs: clause and guard."""
        return [each for each in (self.clause, self.guard) if each]

    @property
    def flow(self) -> str:
        """Its arcs in one line, such as ``PickEntry + Safe -> PickRun + Safe``."""
        sides = [" + ".join(map(str, side)) or "nothing" for side in (self.inputs, self.outputs)]
        return " -> ".join(sides)


@dataclass(frozen=True)
class Port:
    """A topic, a service or an action of a node.

    Attributes
    ----------
    kind : str
        ``publisher``, ``subscriber``, ``client``, ``server``, ``action client`` or ``action server``.
    channel, name : str
        Id of the channel; name of the topic, service or action.
    place : str
        Id of the place that is sent from or received on; a client's and server's `other` is the second one.
    limit : int or None
        QoS depth.
    quality : str
        The depth and all else that is said of its queue, or of how a client asks, in words.
    overrides : tuple of (str, str or int)
        The same as values of the parameters that override them: what ROS calls each policy -> its value.
    type : str
        The ROS interface.
    client : str or None
        Id of the client.
    instances : int or None
        Number of server instances, or of slots for goals.
    service : str or None
        The service or action whose server page a client or publisher stands on: its places exist once per
        instance.
    """

    kind: str
    channel: str
    name: str
    place: str
    type: str
    other: str | None = None
    limit: int | None = None
    quality: str = ""
    overrides: tuple[tuple[Name, str | int], ...] = ()
    client: str | None = None
    instances: int | None = None
    service: str | None = None

    @property
    def override(self) -> Name:
        """What the parameters of its quality of service are under, such as ``publisher_Selected``."""
        role = "publisher" if self.kind == "publisher" else "subscription"
        return Name(f"{role}_{resource_name(self.place)}")


@dataclass(frozen=True)
class Place:
    """A place of the model.

    Attributes
    ----------
    id : str
        Its id in the model.
    tokens : int
        Its initial tokens.
    instances : int
        How often it exists: once per instance on a server page.
    type : TokenClass
        What its tokens carry.
    """

    id: str
    tokens: int
    instances: int
    type: TokenClass


@dataclass(frozen=True)
class Signal:
    """An input signal, its start value, the name of the parameter that sets it, its values if it has some."""

    id: str
    initial: SignalSetting
    parameter: Name
    values: tuple[str, ...] = ()


@dataclass(frozen=True)
class Timer:
    """The timer of a callback.

    Attributes
    ----------
    callback : str
        Id of the callback page.
    period : float
        Seconds.
    begins : tuple of str
        Ids of the transitions by which the callback begins.
    parameter : str
        Name of the parameter that sets the period, after ``periods.``.
    """

    callback: str
    period: float
    begins: tuple[str, ...]
    parameter: Name


@dataclass(frozen=True)
class NodePackage:
    """A node net and the ROS package it becomes.

    Attributes
    ----------
    id, package, name : str
        Id of the node net; names of the package and of the ROS node.
    namespace : str
        Absolute ROS namespace; empty for none.
    executor, threads : str, int
        How the node runs its callbacks.
    transitions, ports, signals, timers : tuple
        What it has, in model order.
    places : tuple of Place
        Its places.
    published : tuple of (str, int)
        For each channel it publishes on, what its parameter is called, and the number of its subscribers.
    message_packages : tuple of str
        Packages of the interfaces it uses, sorted.
    token_types : tuple of TokenClass
        What its tokens carry: the model's first token type, and the others that its places name.
    token_classes : tuple of TokenClass
        The same, after the ROS types nested in them.
    runtime_model : bytes
        The RTM as XMI.
    """

    id: str
    package: Name
    name: Name
    namespace: str
    executor: str
    threads: int
    transitions: tuple[Transition, ...]
    ports: tuple[Port, ...]
    signals: tuple[Signal, ...]
    timers: tuple[Timer, ...]
    places: tuple[Place, ...]
    published: tuple[tuple[Name, int], ...]
    message_packages: tuple[Name, ...]
    token_types: tuple[TokenClass, ...]
    token_classes: tuple[TokenClass, ...]
    runtime_model: bytes

    @property
    def has_guards(self) -> bool:
        """Whether data decides which of its transitions fire, or a transition assigns data."""
        return any(transition.guard or transition.assigns for transition in self.transitions)

    @property
    def has_valued_signals(self) -> bool:
        """Whether a signal has values other than true and false."""
        return any(signal.values for signal in self.signals)

    @property
    def typing_names(self) -> list[Name]:
        """What the module of its tokens needs of `typing`."""
        names = {"TypedDict", "Unpack"} | ({"Any"} if len(self.token_types) > 1 else set())
        if any(each.constants for each in self.token_classes if each.ros is None):
            names.add("Final")
        types = [field.python_type for each in self.token_classes for field in each.fields]
        if any(type_.startswith("Literal[") for type_ in types):
            names.add("Literal")
        return [Name(name) for name in sorted(names)]

    @property
    def has_actions(self) -> bool:
        """Whether it sends goals, or works on them."""
        return any(port.kind in ("action client", "action server") for port in self.ports)

    @property
    def full_name(self) -> str:
        """The name of the ROS node with its namespace, such as ``/left/arm``."""
        return f"{self.namespace.rstrip('/')}/{self.name}"

    @property
    def limited(self) -> list[Port]:
        """Ports of topics whose full names are known here; those with substitutions are not."""
        return [port for port in self.ports if port.limit and not set(port.name) & set("~{}")]

    def resolved(self, topic: str) -> str:
        """Return the full name of a topic, as long as nobody remaps it."""
        return topic if topic.startswith("/") else f"{self.namespace.rstrip('/')}/{topic}"


@dataclass(frozen=True)
class Application:
    """A whole system model.

    Attributes
    ----------
    id, name : str
        Id of the system model, and what people call it.
    interfaces : Interfaces
        Its interface package.
    bringup : str
        Name of the package that starts its nodes.
    nodes : tuple of NodePackage
        Its node nets.
    manager : tuple of str
        What the manager of its managed nodes is told, in the start order.
    """

    id: str
    name: str
    interfaces: Interfaces
    bringup: Name
    nodes: tuple[NodePackage, ...]
    manager: tuple[str, ...] = ()

    @property
    def launch(self) -> Name:
        """Name of the launch file."""
        return Name(f"{snake_case(self.id)}.launch.py")
