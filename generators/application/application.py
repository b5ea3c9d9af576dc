"""The data that templates get: the application and its nodes, as plain values in model order."""

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
    """A transition of a node net."""

    id: str
    """Its id in the model."""
    function: Name
    type_name: Name
    """`function`, `type_name`: name of its handler function; prefix of the names of its types `Firing`,
    `Inputs` and `Outputs`.
    """
    inputs: tuple[ArcEnd, ...]
    outputs: tuple[ArcEnd, ...]
    """`inputs`, `outputs`: the places of its arcs, with references resolved."""
    clause: str | None
    """Its input clause."""
    guard: str | None
    assigns: str | None
    """`guard`, `assigns`: its guard on the data of the tokens it takes, and the fields that it assigns in
    those it puts.
    """
    service: str | None
    """The service on whose server page it is: it exists once per instance."""
    instances: int
    """Number of instances."""
    case: Case
    """A marking and signals under which it fires."""
    types: dict[str, TokenClass]
    """Token types of its places."""
    result: TokenClass
    """Token type of the data passed on, which a handler gets and may change."""
    demanded: tuple[str, ...]
    """Places for which a handler must give data, as no data is passed on to them."""
    is_typed: bool
    """Whether it needs its own types: not all its places have the first token type."""

    @property
    def names(self) -> list[str]:
        """Names for which handlers may be registered: the transition, or that of one server instance."""
        if self.service is None:
            return [self.id]
        return [self.id, *(f"{self.service}[{number}].{self.id}" for number in range(1, self.instances + 1))]

    @property
    def input_places(self) -> list[str]:
        """Places whose tokens a handler gets, in the order of the arcs."""
        return list(dict.fromkeys(end.place for end in self.inputs if end.kind != "inhibitor"))

    @property
    def output_places(self) -> list[str]:
        """Places for which a handler may give data, in the order of the arcs."""
        read = [end.place for end in self.inputs if end.kind == "read"]
        return list(dict.fromkeys([*(end.place for end in self.outputs), *read]))

    @property
    def given(self) -> dict[str, dict[str, object]]:
        """The minimum result of a handler: for each demanded place, only the defaults."""
        return {place: {} for place in self.demanded}

    @property
    def conditions(self) -> list[str]:
        """Its conditions besides its arcs: clause and guard."""
        return [each for each in (self.clause, self.guard) if each]

    @property
    def flow(self) -> str:
        """Its arcs in one line, such as ``PickEntry + Safe -> PickRun + Safe``."""
        sides = [" + ".join(map(str, side)) or "nothing" for side in (self.inputs, self.outputs)]
        return " -> ".join(sides)


@dataclass(frozen=True)
class Port:
    """A topic, a service or an action of a node."""

    kind: str
    """``publisher``, ``subscriber``, ``client``, ``server``, ``action client`` or ``action server``."""
    channel: str
    name: str
    """`channel`, `name`: id of the channel; name of the topic, service or action."""
    place: str
    """Id of the place from which it sends or onto which it receives; the second place of a client or server
    is `other`.
    """
    type: str
    """The ROS interface."""
    other: str | None = None
    limit: int | None = None
    """QoS depth."""
    quality: str = ""
    """The depth and the other properties of its queue, or the settings of a client, as text."""
    overrides: tuple[tuple[Name, str | int], ...] = ()
    """The same as parameters that override them: ROS's name of each policy -> its value."""
    client: str | None = None
    """Id of the client."""
    instances: int | None = None
    """Number of server instances, or of slots for goals."""
    service: str | None = None
    """The service or action on whose server page a client or publisher is: its places exist once per
    instance.
    """

    @property
    def override(self) -> Name:
        """Prefix of the parameters for its quality of service, such as ``publisher_Selected``."""
        role = "publisher" if self.kind == "publisher" else "subscription"
        return Name(f"{role}_{resource_name(self.place)}")


@dataclass(frozen=True)
class Place:
    """A place of the model."""

    id: str
    """Its id in the model."""
    tokens: int
    """Its initial tokens."""
    instances: int
    """Number of its copies: one per instance on a server page, else 1."""
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
    """The timer of a callback."""

    callback: str
    """Id of the callback page."""
    period: float
    """Seconds."""
    begins: tuple[str, ...]
    """Ids of the transitions by which the callback begins."""
    parameter: Name
    """Name of the parameter that sets the period, after ``periods.``."""


@dataclass(frozen=True)
class NodePackage:
    """A node net and its ROS package."""

    id: str
    package: Name
    name: Name
    """`id`, `package`, `name`: id of the node net; names of the package and of the ROS node."""
    namespace: str
    """Absolute ROS namespace; empty for none."""
    executor: str
    threads: int
    """`executor`, `threads`: how the node runs its callbacks."""
    transitions: tuple[Transition, ...]
    ports: tuple[Port, ...]
    signals: tuple[Signal, ...]
    timers: tuple[Timer, ...]
    """`transitions`, `ports`, `signals`, `timers`: its transitions, ports, signals and timers, in model
    order.
    """
    places: tuple[Place, ...]
    published: tuple[tuple[Name, int], ...]
    """For each channel on which it publishes, the name of its parameter, and the number of its subscribers.
    """
    message_packages: tuple[Name, ...]
    """Packages of the interfaces that it uses, sorted."""
    token_types: tuple[TokenClass, ...]
    """Its token types: the first one of the model, and those of its places."""
    token_classes: tuple[TokenClass, ...]
    """The same, preceded by the ROS types nested in them."""
    runtime_model: bytes
    """The runtime model as XMI."""

    @property
    def has_guards(self) -> bool:
        """Whether guards depend on data, or a transition assigns data."""
        return any(transition.guard or transition.assigns for transition in self.transitions)

    @property
    def has_valued_signals(self) -> bool:
        """Whether a signal has values other than true and false."""
        return any(signal.values for signal in self.signals)

    @property
    def typing_names(self) -> list[Name]:
        """Names that the module of its tokens imports from `typing`."""
        names = {"TypedDict", "Unpack"} | ({"Any"} if len(self.token_types) > 1 else set())
        if any(each.constants for each in self.token_classes if each.ros is None):
            names.add("Final")
        types = [field.python_type for each in self.token_classes for field in each.fields]
        if any(type_.startswith("Literal[") for type_ in types):
            names.add("Literal")
        return [Name(name) for name in sorted(names)]

    @property
    def has_actions(self) -> bool:
        """Whether it has action clients or action servers."""
        return any(port.kind in ("action client", "action server") for port in self.ports)

    @property
    def full_name(self) -> str:
        """The name of the ROS node with its namespace, such as ``/left/arm``."""
        return f"{self.namespace.rstrip('/')}/{self.name}"

    @property
    def limited(self) -> list[Port]:
        """Ports of topics whose full names are known; names with substitutions are not."""
        return [port for port in self.ports if port.limit and not set(port.name) & set("~{}")]

    def resolved(self, topic: str) -> str:
        """Return the full name of a topic, if it is not remapped."""
        return topic if topic.startswith("/") else f"{self.namespace.rstrip('/')}/{topic}"


@dataclass(frozen=True)
class Application:
    """A whole system model."""

    id: str
    name: str
    """`id`, `name`: id and name of the system model."""
    interfaces: Interfaces
    """Its interface package."""
    bringup: Name
    """Name of the package that starts its nodes."""
    nodes: tuple[NodePackage, ...]
    """Its node nets."""
    manager: tuple[str, ...] = ()
    """Arguments for the manager of its managed nodes, in the start order."""

    @property
    def launch(self) -> Name:
        """Name of the launch file."""
        return Name(f"{snake_case(self.id)}.launch.py")
