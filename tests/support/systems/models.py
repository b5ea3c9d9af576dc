"""Hypothesis strategies for models: plain nets and valid system models, small and quick to make."""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator
from typing import Any

from hypothesis import strategies as st

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow, inhibit, read
from dineros.metamodel.elements import node_nets, places

ODD_SUFFIXES = ["", "", "", "-1", ".x", "ä", "_2", ":b", "🤖", "#4", "(5)", "tr"]
QUOTED_SUFFIXES = ["'", "{c}", "é\\", '&<>"']  # of plain nets only
NAMES = [
    None,
    None,
    "Ready",
    "two words",
    "Ängström <&>",
    'quoted "name"',
    "brace } {",
    "back\\slash",
    "日本語",
    "a#b",
]
CLAUSES = ["{0}", "!{0}", "({0} | {1}) & !{1}", "{0} and not ({1} or {0})", "{0} & {1}", "¬{0} ∨ {1}"]


class _Ids:
    """Makes ids that are unique in a model."""

    def __init__(self, draw: st.DrawFn, suffixes: list[str]) -> None:
        self._draw = draw
        self._suffixes = suffixes
        self._numbers: Iterator[int] = itertools.count()

    def __call__(self, stem: str, plain: bool = False) -> str:
        suffix = "" if plain else self._draw(st.sampled_from(self._suffixes))
        return f"{stem}{next(self._numbers)}{suffix}"


# Quarters: exact in binary and short in decimal, so that every format can carry them.
_coordinates = st.integers(-4000, 4000).map(lambda quarters: quarters / 4)


def _points(minimum: int, maximum: int) -> st.SearchStrategy[list[pn.Point]]:
    pairs = st.lists(st.tuples(_coordinates, _coordinates), min_size=minimum, max_size=maximum)
    return pairs.map(lambda positions: [pn.Point(x=x, y=y) for x, y in positions])


@st.composite
def node_graphics(draw: st.DrawFn) -> pn.Graphics | None:
    """Return the layout of a node: its position and sometimes its size."""
    if draw(st.booleans()):
        return None
    graphics = pn.Graphics(positions=draw(_points(1, 1)))
    if draw(st.booleans()):
        graphics.dimension = pn.Point(x=draw(st.integers(1, 90)) / 2, y=draw(st.integers(1, 90)) / 2)
    return graphics


@st.composite
def arc_graphics(draw: st.DrawFn) -> pn.Graphics | None:
    """Return the layout of an arc: its bend points."""
    return pn.Graphics(positions=draw(_points(1, 3))) if draw(st.booleans()) else None


@st.composite
def intervals(draw: st.DrawFn) -> pn.TimeInterval:
    """Return a firing interval with whole bounds, open or closed, sometimes without end."""
    earliest = draw(st.integers(0, 5))
    interval = pn.TimeInterval(earliest=float(earliest), earliestExcluded=draw(st.booleans()))
    if draw(st.booleans()):
        interval.latest = float(earliest + draw(st.integers(1, 5)))
        interval.latestExcluded = draw(st.booleans())
    return interval


_some_interval = st.one_of(st.none(), st.none(), intervals())


@st.composite
def plain_nets(
    draw: st.DrawFn, pages: bool = True, graphics: bool = True, time: bool = True, priorities: bool = True
) -> pn.Net:
    """Return a valid place/transition net (class `pn.Net`) of up to about 30 elements.

    It has weights, inhibitor and read arcs; `pages` adds several and nested pages joined by
    reference nodes and chains of them, `graphics` layout, `time` firing intervals and `priorities`
    overrides (never in a circle).
    """
    make_id = _Ids(draw, ODD_SUFFIXES + QUOTED_SUFFIXES)
    net = pn.Net(id=make_id("net"), name=draw(st.sampled_from(NAMES)))
    places: list[pn.Place] = []
    transitions: list[pn.Transition] = []
    sheets: list[pn.Page] = []
    for _ in range(draw(st.integers(1, 3)) if pages else 1):
        page = pn.Page(id=make_id("page"), name=draw(st.sampled_from(NAMES)))
        parent = draw(st.sampled_from([None, *sheets])) if sheets else None
        if parent is None:
            net.pages.append(page)
        else:
            parent.objects.append(page)
        sheets.append(page)
        own_places: list[pn.PlaceNode] = []
        own_transitions: list[pn.TransitionNode] = []
        for _ in range(draw(st.integers(1, 3))):
            place = pn.Place(
                id=make_id("p"),
                name=draw(st.sampled_from(NAMES)),
                tokens=draw(st.sampled_from([0, 0, 1, 2, 7, 1000])),
                graphics=draw(node_graphics()) if graphics else None,
                page=page,
            )
            own_places.append(place)
            places.append(place)
        for _ in range(draw(st.integers(1, 3))):
            transition = pn.Transition(
                id=make_id("t"),
                name=draw(st.sampled_from(NAMES)),
                interval=draw(intervals()) if time and draw(st.booleans()) else None,
                graphics=draw(node_graphics()) if graphics else None,
                page=page,
            )
            if priorities and transitions and draw(st.booleans()):
                transition.overrides.append(draw(st.sampled_from(transitions)))
            own_transitions.append(transition)
            transitions.append(transition)
        if len(sheets) > 1:
            _add_references(draw, make_id, page, (places, transitions), (own_places, own_transitions))
        _join(draw, own_places, own_transitions, graphics)
    return net


def _add_references(
    draw: st.DrawFn,
    make_id: _Ids,
    page: pn.Page,
    known: tuple[list[pn.Place], list[pn.Transition]],
    own: tuple[list[pn.PlaceNode], list[pn.TransitionNode]],
) -> None:
    """Refer to nodes made before, sometimes through a chain of references."""
    for _ in range(draw(st.integers(0, 2))):
        target: pn.PlaceNode = draw(st.sampled_from(known[0]))
        for _ in range(draw(st.integers(1, 2))):
            target = pn.ReferencePlace(id=make_id("rp"), target=target, page=page)
        own[0].append(target)
    if draw(st.booleans()):
        reference = pn.ReferenceTransition(
            id=make_id("rt"), target=draw(st.sampled_from(known[1])), page=page
        )
        own[1].append(reference)


def _join(
    draw: st.DrawFn, places: list[pn.PlaceNode], transitions: list[pn.TransitionNode], graphics: bool
) -> None:
    """Join places and transitions of one page, every pair at most once in each direction."""
    pairs = st.tuples(st.sampled_from(places), st.sampled_from(transitions), st.booleans())
    chosen = draw(st.lists(pairs, max_size=6, unique_by=lambda pair: (pair[0].id, pair[1].id, pair[2])))
    for place, transition, out in chosen:
        weight = draw(st.sampled_from([1, 1, 1, 2, 5]))
        if out:
            (arc,) = flow(transition, place, weight=weight)
        else:
            kind = draw(st.sampled_from(["normal", "normal", "read", "inhibitor"]))
            if kind == "normal":
                (arc,) = flow(place, transition, weight=weight)
            else:
                arc = (read if kind == "read" else inhibit)(place, transition, weight)
        if graphics:
            arc.graphics = draw(arc_graphics())


@st.composite
def system_models(draw: st.DrawFn, with_properties: bool = False) -> sym.SystemModel:
    """Return a valid system model of one to three node nets, with topics, services, signals and clauses."""
    make_id = _Ids(draw, ODD_SUFFIXES)
    model = sym.SystemModel(id=make_id("model"), name=draw(st.sampled_from(NAMES)))
    if draw(st.booleans()):
        model.times = sym.DefaultTimes(latency=draw(intervals()), reaction=draw(_some_interval))
    fields = _token_type(draw, make_id, model)
    canvas = None
    if draw(st.booleans()):
        canvas = pn.Page(id=make_id("canvas"), net=model)
    nets = [_node_net(draw, make_id, model, fields) for _ in range(draw(st.integers(1, 3)))]
    for number in range(draw(st.integers(0, 2))):
        _topic(draw, make_id, model, nets, number, fields, canvas)
    if len(nets) > 1:
        for number in range(draw(st.integers(0, 2))):
            _service(draw, make_id, model, nets, number)
    if model.tokenType is not None and draw(st.booleans()):
        _other_token_types(draw, make_id, model, model.tokenType)
    if with_properties:
        _with_properties(model, make_id)
    return model


_FIELDS: list[tuple[str, str, str | None, dict[str, Any]]] = [
    ("label", "text", '"none"', {}),
    ("count", "integer", "3", {}),
    ("speed", "number", "0.5", {}),
    ("done", "boolean", "true", {}),
    ("pose", "list", "[0, 0, 0]", {"elementKind": "number", "length": 3}),
    ("tags", "map", None, {"elementKind": "text"}),
]
_DATA = {
    "label": 'r"ed <&> ä',
    "count": -2,
    "speed": 1.25,
    "done": False,
    "pose": [1, 2.5, 3],
    "tags": {"a": "b"},
}


def _token_type(draw: st.DrawFn, make_id: _Ids, model: sym.SystemModel) -> list[str]:
    """Give the model a token type, or none, and return the names of its fields."""
    chosen = draw(st.lists(st.sampled_from(_FIELDS), unique_by=lambda field: field[0], max_size=3))
    if not chosen:
        return []
    token_type = sym.TokenType(id=make_id("Token", plain=True), name="Token")
    for name, kind, default, more in chosen:
        token_type.fields.append(sym.TokenField(name=name, kind=kind, default=default, **more))
    model.tokenType = token_type
    return [name for name, *_ in chosen]


def _other_token_types(draw: st.DrawFn, make_id: _Ids, model: sym.SystemModel, first: sym.TokenType) -> None:
    """Give all places a second token type, with bounds, and the model a third that is a ROS message."""
    other = sym.TokenType(id=make_id("Other", plain=True), name="Other")
    for field in first.fields:
        same = sym.TokenField(
            name=field.name, kind=field.kind, elementKind=field.elementKind, length=field.length
        )
        same.default, same.ros = (
            field.default,
            {"integer": "int16", "text": "string<=40"}.get(str(field.kind)),
        )
        other.fields.append(same)
    other.fields.append(sym.TokenField(name="few", kind="list", bound=2))
    message = sym.TokenType(id=make_id("Message", plain=True), ros="std_msgs/msg/Header")
    model.otherTokenTypes.extend([other, message])
    for place in places(model):
        if isinstance(place, sym.Place):
            place.tokenType = other


def _with_properties(model: sym.SystemModel, make_id: _Ids) -> None:
    """Store a property of each kind, and assumptions."""
    for text, features in {
        "never deadlock": {},
        "G F !deadlock": {"language": "ltl", "expected": False},
        "AG !deadlock": {"language": "ctl", "signals": "ioEnabled", "name": "continues"},
    }.items():
        model.properties.append(sym.Property(id=make_id("property"), text=text, **features))  # type: ignore[arg-type]
    model.assumptions.append(sym.Fairness(id=make_id("fair"), of="all", strong=True))
    signals = [signal for node in node_nets(model) for signal in node.signals]
    if len(signals) > 1:
        model.assumptions.append(sym.ExclusiveSignals(id=make_id("apart"), signals=signals))


def _node_net(draw: st.DrawFn, make_id: _Ids, model: sym.SystemModel, fields: list[str]) -> sym.NodeNet:
    """Add a node net: a state page, a line of places and transitions, signals and clauses."""
    threads = draw(st.integers(1, 4))
    net = sym.NodeNet(
        id=make_id("node", plain=True),
        name=draw(st.sampled_from([None, "controller"])),
        package=draw(st.sampled_from([None, "sorting_cell"])),
        namespace=draw(st.sampled_from([None, "/left"])),
        reaction=draw(_some_interval),
        executor="multi" if threads > 1 else "single",
        threads=threads,
        graphics=draw(node_graphics()),
        net=model,
    )
    # Names may repeat in a model; two node nets of one name may not.
    if net.name is not None:
        net.name = f"{net.name}{len(model.pages)}"
    for _ in range(draw(st.integers(0, 1))):
        net.callbackGroups.append(
            sym.CallbackGroup(
                id=make_id("group"),
                kind=draw(st.sampled_from(["exclusive", "reentrant"])),
                priority=draw(st.integers(0, 3)),
            )
        )
    for _ in range(draw(st.integers(0, 2))):
        net.signals.append(sym.InputSignal(id=make_id("Signal", plain=True), initial=draw(st.booleans())))
    state_page = pn.Page(id=make_id("states"), page=net)
    state = sym.Place(id=make_id("state"), tokens=draw(st.integers(1, 2)), kind="start", page=state_page)
    reference: pn.PlaceNode = pn.ReferencePlace(id=make_id("ref"), target=state, page=net)
    for _ in range(draw(st.integers(1, 2))):
        tokens = draw(st.integers(0, 3))
        place = sym.Place(
            id=make_id("p"),
            name=draw(st.sampled_from(NAMES)),
            tokens=tokens,
            kind=draw(st.sampled_from(["ordinary", "ordinary", "end"])),
            graphics=draw(node_graphics()),
            page=net,
        )
        for _ in range(draw(st.integers(0, tokens))):
            data = {name: _DATA[name] for name in fields if draw(st.booleans())}
            place.balloons.append(sym.BalloonToken(data=json.dumps(data, ensure_ascii=False)))
        transition = sym.Transition(
            id=make_id("t"), name=draw(st.sampled_from(NAMES)), graphics=draw(node_graphics()), page=net
        )
        if draw(st.booleans()):
            transition.interval = draw(intervals())
            transition.kind = sym.TransitionKind.timed
        flow(place, transition, reference, weight=draw(st.sampled_from([1, 1, 2])))
        if draw(st.booleans()):
            draw(st.sampled_from([read, inhibit]))(reference, transition, draw(st.integers(1, 3)))
        _clause(draw, net, transition)
    return net


def _clause(draw: st.DrawFn, net: sym.NodeNet, transition: sym.Transition) -> None:
    if not len(net.signals) or draw(st.booleans()):
        return
    from dineros.metamodel.clauses import set_clause

    names = [signal.id for signal in net.signals]
    text = draw(st.sampled_from(CLAUSES)).format(names[0], names[-1])
    set_clause(transition, text, name=draw(st.sampled_from([None, "may go"])))


def _topic(
    draw: st.DrawFn,
    make_id: _Ids,
    model: sym.SystemModel,
    nets: list[sym.NodeNet],
    number: int,
    fields: list[str],
    canvas: pn.Page | None,
) -> None:
    """Add a topic with publishers and, on callback pages, subscribers."""
    channel = sym.TopicChannel(
        id=make_id("topic"),
        name=draw(st.sampled_from(NAMES)),
        topic=f"/cell/topic{number}",
        latency=draw(_some_interval),
        graphics=draw(node_graphics()),
        canvas=canvas,
        model=model,
    )
    if draw(st.booleans()):
        channel.type = "std_msgs/msg/String"
        if "label" in fields:
            channel.mappings.append(sym.FieldMapping(messageField="data", tokenField="label"))
    if draw(st.booleans()):
        channel.qos = sym.QualityOfService(
            reliability=draw(st.sampled_from(["reliable", "bestEffort"])),
            durability=draw(st.sampled_from(["volatile", "transientLocal"])),
        )
    for net in draw(st.lists(st.sampled_from(nets), min_size=1, max_size=2)):
        sent = sym.Place(id=make_id("sent"), page=net)
        flow(_some_transition(net), sent)
        channel.publishers.append(sym.PublisherPort(place=sent, limit=draw(st.sampled_from([10, 10, 1, 5]))))
    for net in draw(st.lists(st.sampled_from(nets), min_size=1, max_size=2)):
        page = sym.CallbackPage(
            id=make_id("callback"),
            group=net.callbackGroups[0] if len(net.callbackGroups) else None,
            priority=draw(st.integers(0, 2)),
            page=net,
        )
        received = sym.Place(id=make_id("received"), page=page)
        handle = sym.Transition(id=make_id("handle"), page=page)
        onward = pn.ReferencePlace(id=make_id("ref"), target=_some_place(net), page=page)
        flow(received, handle, onward)
        channel.subscribers.append(
            sym.SubscriberPort(
                place=received, limit=draw(st.sampled_from([10, 10, 1, 3])), latency=draw(_some_interval)
            )
        )
    if draw(st.booleans()):
        first = channel.subscribers[0].place.page
        assert first is not None and isinstance(first.page, sym.NodeNet)
        channel.dispatchers.append(sym.Dispatcher(node=first.page, limit=draw(st.integers(1, 15))))


def _service(
    draw: st.DrawFn, make_id: _Ids, model: sym.SystemModel, nets: list[sym.NodeNet], number: int
) -> None:
    """Add a service whose server page shares the state of its node net, and clients in other node nets."""
    server = nets[number % len(nets)]
    page = sym.CallbackPage(id=make_id("server"), kind="server", page=server)
    entry = sym.Place(id=make_id("entry"), page=page)
    serve = sym.Transition(id=make_id("serve"), page=page)
    exit_ = sym.Place(id=make_id("exit"), page=page)
    shared = pn.ReferencePlace(id=make_id("ref"), target=_state(server), page=page)
    flow(entry, serve, exit_)
    flow(shared, serve, shared)
    _clause(draw, server, serve)
    channel = sym.ServiceChannel(
        id=make_id("service"),
        service=f"/serve{number}",
        type=draw(st.sampled_from([None, "std_srvs/srv/Trigger"])),
        server=sym.ServerPort(entry=entry, exit=exit_, page=page),
        instances=draw(st.sampled_from([None, 1, 3])),
        model=model,
    )
    others = [net for net in nets if net is not server]
    for net in draw(st.lists(st.sampled_from(others), min_size=1, max_size=2)):
        request = sym.Place(id=make_id("request"), page=net)
        response = sym.Place(id=make_id("response"), page=net)
        done = sym.Transition(id=make_id("done"), page=net)
        flow(_some_transition(net), request)
        flow(response, done, _some_place(net))
        channel.clients.append(
            sym.ClientPort(
                client=make_id("client"), request=request, response=response, latency=draw(_some_interval)
            )
        )


def _some_transition(net: sym.NodeNet) -> sym.Transition:
    return next(node for node in net.objects if isinstance(node, sym.Transition))


def _some_place(net: sym.NodeNet) -> sym.Place:
    return next(node for node in net.objects if isinstance(node, sym.Place))


def _state(net: sym.NodeNet) -> sym.Place:
    reference = next(node for node in net.objects if isinstance(node, pn.ReferencePlace))
    assert isinstance(reference.target, sym.Place)
    return reference.target
