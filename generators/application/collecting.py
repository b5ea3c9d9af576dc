"""Collects the data of an application for templates from a system model."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable
from typing import Any, TypeAlias, TypedDict

from dineros.generators.application.application import (
    Application,
    NodePackage,
    Place,
    Port,
    Signal,
    Timer,
    Transition,
)
from dineros.generators.application.arcs import ArcEnd
from dineros.generators.application.cases import case_of
from dineros.generators.application.interfaces import Interfaces, interfaces_of
from dineros.generators.application.naming import (
    NOTHING_RESERVED,
    NamingError,
    Reserved,
    bringup_package,
    classes,
    functions,
    node_name,
    node_packages,
)
from dineros.generators.application.tokens import TokenClass
from dineros.generators.templates.filters import Name
from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.callbacks.bodies import Body, calls_of, timers_of
from dineros.metamodel.calls import CLIENT_PLACES, SERVER_PLACES, UNLIMITED
from dineros.metamodel.clauses import start_value, value_names
from dineros.metamodel.elements import (
    arcs,
    label,
    node_net_of,
    places,
    ports_in,
    resolve,
    token_types,
    transitions,
)
from dineros.metamodel.files.xmi import xmi_bytes
from dineros.metamodel.guards.deciding import as_value, read_step
from dineros.metamodel.guards.reading import satisfying
from dineros.metamodel.lifecycles.start_order import manager_arguments
from dineros.metamodel.matching import plain as quality_as_values
from dineros.metamodel.ros_names import camel_case, resource_names, snake_case
from dineros.metamodel.token_data import FieldType, Value
from dineros.metamodel.token_types.declared import token_type_of, type_of_place
from dineros.metamodel.token_types.passing import passing
from dineros.transformations.flattening.split import split


def application_of(model: sym.SystemModel, reserved: Reserved = NOTHING_RESERVED) -> Application:
    """Return the data of a model for templates; no name of the model hides one of `reserved`.

    Raises
    ------
    DinerosError
        The model cannot be split, a guard is invalid, or its names collide in ROS.
    """
    parts = split(model)
    packages = node_packages(model, [part.node for part in parts])
    interfaces = interfaces_of(model, reserved)
    return Application(
        id=model.id,
        name=label(model),
        interfaces=interfaces,
        bringup=bringup_package(model.id),
        manager=tuple(manager_arguments(model)),
        nodes=tuple(
            _node(part, packages[part.node.id], interfaces, _subscribing(model), reserved) for part in parts
        ),
    )


def _subscribing(model: sym.SystemModel) -> dict[str, int]:
    """Return the number of nodes that subscribe to each topic."""
    return {
        channel.id: len({node_net_of(port.place) for port in channel.subscribers})
        for channel in model.channels
        if isinstance(channel, sym.TopicChannel)
    }


def _node(
    part: rtm.RuntimeModel,
    package: Name,
    interfaces: Interfaces,
    subscribing: dict[str, int],
    reserved: Reserved,
) -> NodePackage:
    node = part.node
    ports = tuple(_ports(part, interfaces))
    named = {each.id for each in token_types(part)}
    types = tuple(each for each in interfaces.types if each.id in named or each is interfaces.types[0])
    nested = {ros for each in types for ros in each.nested}
    _require_distinct_overrides(node, ports)
    parameters = resource_names(signal.id for signal in node.signals)
    published = resource_names(port.channel for port in ports if port.kind == "publisher")
    return NodePackage(
        id=node.id,
        package=package,
        name=node_name(node),
        namespace=node.namespace or "",
        executor=str(node.executor),
        threads=node.threads,
        transitions=tuple(_transitions(part, interfaces, reserved)),
        ports=ports,
        signals=tuple(
            Signal(signal.id, start_value(signal), Name(parameters[signal.id]), value_names(signal))
            for signal in node.signals
        ),
        timers=tuple(_timers(part)),
        places=tuple(_places(part, interfaces)),
        published=tuple((Name(name), subscribing[channel]) for channel, name in published.items()),
        message_packages=tuple(
            sorted(
                {Name(port.type.partition("/")[0]) for port in ports}
                | {each.package for each in types if each.package is not None}
                | {Name("diagnostic_msgs"), Name("std_msgs"), Name("std_srvs")}
            )
        ),
        token_types=types,
        token_classes=(*(each for each in interfaces.nested if each.ros in nested), *types),
        runtime_model=xmi_bytes(part),
    )


def _require_distinct_overrides(node: sym.NodeNet, ports: Iterable[Port]) -> None:
    places: dict[tuple[str, Name], str] = {}
    for port in ports:
        if port.limit is None:
            continue
        same = places.setdefault((port.name, port.override), port.place)
        if same != port.place:
            raise NamingError(
                f"places {same!r} and {port.place!r} of node net {node.id!r} both become the parameter "
                f"qos_overrides.{port.name}.{port.override}",
                element=port.place,
                hint="rename one of them",
            )


def _timers(part: rtm.RuntimeModel) -> Iterable[Timer]:
    found, calls = timers_of(part), calls_of(part)
    parameters = resource_names(page.id for page in found)
    for page in found:
        begins = tuple(each.id for each in Body(page, calls).beginnings())
        yield Timer(page.id, float(page.timer or 0.0), begins, Name(parameters[page.id]))


def _places(part: rtm.RuntimeModel, interfaces: Interfaces) -> Iterable[Place]:
    servers = _server_pages(part)
    for place in places(part):
        server = _server_of(place, servers)
        carried = interfaces.type_named(type_of_place(place, part))
        yield Place(place.id, place.tokens, server.instances if server else 1, carried)


def _transitions(part: rtm.RuntimeModel, interfaces: Interfaces, reserved: Reserved) -> Iterable[Transition]:
    found = transitions(part)
    inputs: dict[pn.Node, list[ArcEnd]] = defaultdict(list)
    outputs: dict[pn.Node, list[ArcEnd]] = defaultdict(list)
    for arc in arcs(part):
        source, target = resolve(arc.source), resolve(arc.target)
        if isinstance(source, pn.Place):
            inputs[target].append(ArcEnd(source.id, arc.weight, str(arc.kind)))
        else:
            outputs[source].append(ArcEnd(target.id, arc.weight))
    names = functions((transition.id for transition in found), reserved)
    type_names = classes((transition.id for transition in found), reserved)
    servers = _server_pages(part)
    running = {place.id: _running(place, servers) for place in places(part)}
    initial = {signal.id: start_value(signal) for signal in part.node.signals}
    types = {place.id: interfaces.type_named(type_of_place(place, part)) for place in places(part)}
    for transition in found:
        server = _server_of(transition, servers)
        clause = transition.clause if isinstance(transition, sym.Transition) else None
        arcs_here = inputs[transition], outputs[transition]
        yield Transition(
            id=transition.id,
            function=names[transition.id],
            type_name=type_names[transition.id],
            inputs=tuple(inputs[transition]),
            outputs=tuple(outputs[transition]),
            clause=clause.text if clause is not None else None,
            guard=transition.guard if isinstance(transition, sym.Transition) else None,
            assigns=transition.assigns if isinstance(transition, sym.Transition) else None,
            service=server.channel if server else None,
            instances=server.instances if server else 1,
            case=case_of(
                _running(transition, servers),
                *arcs_here,
                clause,
                initial,
                lambda id: running[id],
                _fulfilling(transition, part, *arcs_here),
            ),
            **_typing(*arcs_here, types, interfaces.types[0]),
        )


def _fulfilling(
    transition: pn.Transition, part: rtm.RuntimeModel, inputs: list[ArcEnd], outputs: list[ArcEnd]
) -> dict[str, dict[str, Value]]:
    """Return, for each place, values of fields that fulfil a guard."""
    if not isinstance(transition, sym.Transition) or (transition.guard, transition.assigns) == (None, None):
        return {}
    by_id = {place.id: place for place in places(part)}
    seen: Counter[pn.Place] = Counter()
    for end in inputs:
        if end.kind != "inhibitor":
            seen[by_id[end.place]] += end.weight

    def fields(place: pn.Place) -> dict[str, FieldType]:
        return {field.name: field for field in token_type_of(type_of_place(place, part)).fields}

    step = read_step(transition, seen, [by_id[end.place] for end in outputs], fields)
    return {
        place.id: {
            name: as_value(value, fields(place)[name])
            for name, value in (satisfying(condition, fields(place)) or {}).items()
        }
        for place, condition in step.guard.items()
    }


class _Typing(TypedDict):
    types: dict[str, TokenClass]
    result: TokenClass
    demanded: tuple[str, ...]
    is_typed: bool


def _typing(
    inputs: list[ArcEnd], outputs: list[ArcEnd], types: dict[str, TokenClass], first: TokenClass
) -> _Typing:
    """Return the types of the data at a transition."""
    reads = [end.place for end in inputs if end.kind == "read"]
    takes, puts = _weights(end for end in inputs if end.kind == "normal"), _weights(outputs)
    goes_on = passing(takes, puts, reads, types.__getitem__)
    here = {end.place: types[end.place] for end in (*inputs, *outputs)}
    return {
        "types": here,
        "result": first if goes_on.result is None else types[goes_on.result],
        "demanded": goes_on.demanded,
        "is_typed": any(each is not first for each in here.values()),
    }


def _weights(ends: Iterable[ArcEnd]) -> list[tuple[str, int]]:
    weights: dict[str, int] = {}
    for end in ends:
        weights[end.place] = weights.get(end.place, 0) + end.weight
    return list(weights.items())


_PagePort: TypeAlias = rtm.ServerPort | rtm.ActionServerPort


def _server_pages(part: rtm.RuntimeModel) -> dict[pn.Page, _PagePort]:
    return {
        port.page: port
        for _, port in ports_in(part)
        if isinstance(port, (rtm.ServerPort, rtm.ActionServerPort))
    }


def _server_of(node: pn.Node, servers: dict[pn.Page, _PagePort]) -> _PagePort | None:
    page = node.page
    while page is not None:
        if page in servers:
            return servers[page]
        page = page.page
    return None


def _running(node: pn.Node, servers: dict[pn.Page, _PagePort]) -> str:
    """Return the id of a node in the running net, in the first instance if there are several."""
    server = _server_of(node, servers)
    return f"{server.channel}[1].{node.id}" if server else node.id


def _ports(part: rtm.RuntimeModel, interfaces: Interfaces) -> Iterable[Port]:
    servers = _server_pages(part)
    for place, port in ports_in(part):
        server = _server_of(place, servers)
        carried = interfaces.type_named(type_of_place(place, part))
        kind, name, suffix, more = _about(port, part.middleware)
        own = f"{interfaces.package}/{suffix}/{carried.name if suffix == 'msg' else camel_case(port.channel)}"
        type_ = port.type or (carried.ros if suffix == "msg" and carried.ros else own)
        service = server.channel if server is not None and kind in _PER_INSTANCE else None
        yield Port(kind, port.channel, name, place.id, type_, service=service, **more)


_PER_INSTANCE = ("publisher", "client", "action client")


def _about(port: rtm.PlacePort, middleware: sym.Middleware) -> tuple[str, str, str, dict[str, Any]]:
    """Return a port's kind, the name of its channel, the kind of its interface, and its other values."""
    match port:
        case rtm.PublisherPort() | rtm.SubscriberPort():
            kind = "publisher" if isinstance(port, rtm.PublisherPort) else "subscriber"
            words, overrides = quality_words(port, middleware), quality_overrides(port)
            return kind, port.topic, "msg", {"limit": port.limit, "quality": words, "overrides": overrides}
        case rtm.ClientPort():
            words, other = client_words(port), port.response.id
            return "client", port.service, "srv", {"other": other, "client": port.client, "quality": words}
        case rtm.ServerPort():
            words = f"limit {port.depth}" if middleware == sym.Middleware.ros2 else ""
            ends = {"other": port.exit.id, "quality": words}
            return "server", port.service, "srv", {**ends, "instances": port.instances}
        case rtm.ActionClientPort():
            words = action_words(port, CLIENT_PLACES)
            return "action client", port.action, "action", {"quality": words, "client": port.client}
        case rtm.ActionServerPort():
            words = action_words(port, SERVER_PLACES)
            return "action server", port.action, "action", {"quality": words, "instances": port.instances}
    raise TypeError(f"{type(port).__name__} is not a kind of port")


def action_words(port: rtm.ActionClientPort | rtm.ActionServerPort, roles: Iterable[str]) -> str:
    """Describe the other places of an action's port: ``succeeded Done, cancel Stop, 2 slots``."""
    words = [f"{role} {place.id}" for role in roles if (place := getattr(port, role)) is not None]
    if isinstance(port, rtm.ActionServerPort):
        words.append(f"{port.instances} slot{'s' if port.instances > 1 else ''}")
        words += ["may refuse"] if port.mayReject else []
    elif port.outstanding > 1:
        words.append(f"{port.outstanding} goals at a time")
    return ", ".join(words)


def client_words(port: rtm.ClientPort) -> str:
    """Describe the settings of a client: ``3 requests under way, gives up after 5 s: Late``."""
    asked = "any number of" if port.outstanding == UNLIMITED else port.outstanding
    words = [f"{asked} requests under way"] if asked != 1 else []
    if port.timeout is not None:
        told = f": {port.timedOut.id}" if port.timedOut is not None else ""
        words.append(f"gives up after {port.timeout:g} s{told}")
    return ", ".join(words)


def quality_words(port: rtm.PublisherPort | rtm.SubscriberPort, middleware: sym.Middleware) -> str:
    """Describe the queue and the quality of service of a port: ``limit 5, best effort``."""
    words = [f"limit {port.limit}"]
    if isinstance(port, rtm.SubscriberPort):
        if middleware == sym.Middleware.ros1:
            words.append(f"dispatcher {port.dispatcherLimit}")
        elif port.inHand is not None:
            words.append("any number of messages in hand" if port.inHand < 0 else f"{port.inHand} in hand")
    quality = port.qos
    if quality is not None:
        words.append("best effort" if quality.reliability == sym.Reliability.bestEffort else "reliable")
        if quality.durability == sym.Durability.transientLocal:
            words.append("transient local")
        if quality.liveliness == sym.Liveliness.manualByTopic:
            words.append("liveliness by topic")
        times = {"deadline": quality.deadline, "lifespan": quality.lifespan, "lease": quality.leaseDuration}
        words += [f"{name} {seconds:g} s" for name, seconds in times.items() if seconds is not None]
    return ", ".join(words)


def quality_overrides(
    port: rtm.PublisherPort | rtm.SubscriberPort,
) -> tuple[tuple[Name, str | int], ...]:
    """Return the queue's properties as values of ROS's parameters: times in nanoseconds."""
    said: dict[str, str | int] = {"depth": port.limit}
    quality = port.qos
    if quality is not None:
        plain = quality_as_values(quality)
        said |= {"reliability": snake_case(plain.reliability), "durability": snake_case(plain.durability)}
        if plain.liveliness != "automatic":
            said["liveliness"] = snake_case(plain.liveliness)
        times = {"deadline": plain.deadline, "liveliness_lease_duration": plain.lease_duration}
        if isinstance(port, rtm.PublisherPort):
            times["lifespan"] = plain.lifespan
        said |= {name: round(seconds * 1e9) for name, seconds in times.items() if seconds is not None}
    return tuple((Name(policy), value) for policy, value in said.items())
