"""Splitting: the runtime models together are the system model, ports included, and each is valid alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from case_study.build import build
from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.base import EObject, features_of
from dineros.metamodel.build import flow
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import elements, find, node_net_of, node_nets, places
from dineros.metamodel.files.xmi import xmi_bytes
from dineros.transformations.flattening.split import CoverageError, file_names, split
from tests.support.equality import differences
from tests.support.references.runs import ReferenceRun
from tests.support.ros2_systems.deliveries import deliveries
from tests.support.systems.calling_systems import calling_systems
from tests.support.systems.models import system_models
from tests.support.systems.small import small_system
from tests.support.systems.small_systems import small_system_models


def own_elements(model: pn.Net) -> dict[str, pn.Element]:
    """Return what stands in node nets, and pages around them, by id."""
    return {
        element.id: element
        for element in elements(model)
        if element is not model
        and not isinstance(element, (sym.Channel, sym.TokenType))
        and not (isinstance(element, pn.Page) and holds_no_node_net(element))
    }


def holds_no_node_net(page: pn.Page) -> bool:
    """Tell whether a page is only there to draw channels on."""
    inside = [page, *page.eAllContents()]
    return node_net_of(page) is None and not any(isinstance(each, sym.NodeNet) for each in inside)


def said(element: EObject, features: dict[str, Any]) -> dict[str, object]:
    """Return the attributes of an element, and of what it refers to the ids."""
    found: dict[str, object] = {}
    for name, feature in features.items():
        if feature.transient or (feature.is_reference and feature.containment):
            continue
        value = getattr(element, name)
        values = list(value) if feature.many else [value]
        found[name] = [getattr(each, "id", None) if isinstance(each, EObject) else each for each in values]
    return found


def check_union(model: sym.SystemModel, parts: list[rtm.RuntimeModel]) -> None:
    whole = own_elements(model)
    copies: Counter[str] = Counter()
    for part in parts:
        for id, copied in own_elements(part).items():
            copies[id] += 1
            original = whole[id]
            features = {
                name: feature
                for name, feature in features_of(type(original)).items()
                if name not in ("net", "toolInfos", "graphics", "labels")
            }
            expected, found = said(original, features), said(copied, features)
            if node_net_of(original) is None:  # a page around node nets: only one of them is on it
                continue
            if isinstance(original, sym.NodeNet) and original.page is None:
                expected.pop("page"), found.pop("page")
            assert found == expected, id
            for name in ("clause", "interval", "balloons", "graphics"):
                if name in features_of(type(original)):
                    check_inner(getattr(original, name), getattr(copied, name))
    assert set(copies) == set(whole)
    assert all(count == 1 for id, count in copies.items() if node_net_of(whole[id]) is not None)


def check_inner(one: Any, other: Any) -> None:
    if one is None or isinstance(one, EObject):
        assert (one is None) == (other is None)
        if one is not None:
            assert differences(one, other) == []
    else:
        assert len(one) == len(other)
        for pair in zip(one, other, strict=True):
            assert differences(*pair) == []


def ports_of_system(model: sym.SystemModel) -> Iterator[tuple[object, ...]]:
    run = ReferenceRun(model, 0)
    for channel in model.channels:
        if isinstance(channel, sym.TopicChannel):
            facts = (channel.id, channel.topic, channel.type, mappings(channel))
            for publisher in channel.publishers:
                yield ("publisher", node(publisher.place), *facts, publisher.limit, quality(channel))
            for subscriber in channel.subscribers:
                net = node_net_of(subscriber.place)
                limits = [each.limit for each in channel.dispatchers if each.node is net]
                yield (
                    "subscriber",
                    node(subscriber.place),
                    *facts,
                    subscriber.limit,
                    *(limits or [16]),
                    quality(channel),
                )
        elif isinstance(channel, sym.ServiceChannel):
            service = (channel.id, channel.service, channel.type, mappings(channel))
            for client in channel.clients:
                yield ("client", node(client.request), *service, client.client, client.response.id)
            server = channel.server
            count = max(1, len(run.prefixes(channel)))
            yield ("server", node(server.entry), *service, server.exit.id, server.page.id, count)


def ports_of_parts(parts: list[rtm.RuntimeModel]) -> Iterator[tuple[object, ...]]:
    for part in parts:
        for place in places(part):
            assert isinstance(place, rtm.Place)
            for port in place.ports:
                if isinstance(port, rtm.PublisherPort):
                    facts = (port.channel, port.topic, port.type, mappings(port))
                    yield ("publisher", node(place), *facts, port.limit, quality(port))
                elif isinstance(port, rtm.SubscriberPort):
                    facts = (port.channel, port.topic, port.type, mappings(port))
                    yield (
                        "subscriber",
                        node(place),
                        *facts,
                        port.limit,
                        port.dispatcherLimit,
                        quality(port),
                    )
                elif isinstance(port, rtm.ClientPort):
                    facts = (port.channel, port.service, port.type, mappings(port))
                    yield ("client", node(place), *facts, port.client, port.response.id)
                elif isinstance(port, rtm.ServerPort):
                    facts = (port.channel, port.service, port.type, mappings(port))
                    yield ("server", node(place), *facts, port.exit.id, port.page.id, port.instances)


def node(place: pn.Place) -> tuple[str, str]:
    """Return the node net of a place and its id."""
    net = node_net_of(place)
    assert net is not None
    return net.id, place.id


def mappings(owner: Any) -> tuple[object, ...]:
    return tuple((str(each.part), each.messageField, each.tokenField) for each in owner.mappings)


def quality(owner: Any) -> object:
    return owner.qos and (str(owner.qos.reliability), str(owner.qos.durability))


def check(model: sym.SystemModel) -> None:
    before = xmi_bytes(model)
    parts = split(model)

    assert xmi_bytes(model) == before
    assert [part.node.id for part in parts] == [net.id for net in node_nets(model)]
    check_union(model, parts)
    assert Counter(ports_of_parts(parts)) == Counter(ports_of_system(model))
    for part in parts:
        assert part.systemModel == model.id
        assert [found for found in validate(part) if found.severity == "error"] == []
        assert (part.tokenType is None) == (model.tokenType is None)
        if model.tokenType is not None and part.tokenType is not None:
            assert differences(model.tokenType, part.tokenType) == []
        inside = {part, *part.eAllContents()}
        for element in own_elements(part).values():
            for name, feature in features_of(type(element)).items():
                if feature.is_reference and not feature.transient:
                    value = getattr(element, name)
                    targets = list(value) if feature.many else [value]
                    assert inside.issuperset(each for each in targets if each is not None), (element, name)


@given(system_models())
@settings(max_examples=15)
def test_the_runtime_models_together_are_the_system_model(model: sym.SystemModel) -> None:
    check(model)


@given(st.one_of(small_system_models(clients=0), calling_systems(circles=True)))
@settings(max_examples=20)
def test_small_models(model: sym.SystemModel) -> None:
    check(model)


def test_the_case_study() -> None:
    model = build()
    check(model)

    assert [part.id for part in split(model)][:2] == ["sorting.selector", "sorting.controller"]


@given(system_models())
@settings(max_examples=8)
def test_the_same_model_gives_the_same_bytes(model: sym.SystemModel) -> None:
    assert [xmi_bytes(part) for part in split(model)] == [xmi_bytes(part) for part in split(model)]


def test_a_page_that_spans_several_node_nets_is_copied_into_each() -> None:
    model = small_system()
    outer, inner = pn.Page(id="outer", name="cell"), pn.Page(id="inner")
    outer.objects.append(inner)
    inner.objects.extend(list(model.pages))
    model.pages.clear()
    model.pages.append(outer)
    parts = split(model)

    for part, name in zip(parts, ("talker", "listener"), strict=True):
        (page,) = part.pages
        assert (page.id, page.name) == ("outer", "cell")
        (within,) = page.objects
        assert isinstance(within, pn.Page) and within.id == "inner"
        assert [each.id for each in within.objects] == [name]
        assert part.node is within.objects[0]
    assert parts[0].pages[0] is not parts[1].pages[0]
    check_union(model, parts)


def lonely(model: sym.SystemModel) -> str:
    page = pn.Page(id="outer", net=model)
    sym.Place(id="lonely", page=page)
    return "lonely"


def between(model: sym.SystemModel) -> str:
    outer = pn.Page(id="outer")
    outer.objects.extend(list(model.pages))
    model.pages.append(outer)
    flow(sym.Place(id="shared", page=outer), sym.Transition(id="both", page=outer))
    return "shared"


def crossing_reference(model: sym.SystemModel) -> str:
    listener = find(model, "listener", sym.NodeNet)
    pn.ReferencePlace(id="spy", target=find(model, "said", pn.Place), page=listener)
    return "listener"


def crossing_arc(model: sym.SystemModel) -> str:
    listener = find(model, "listener", sym.NodeNet)
    said, take = find(model, "said", pn.Place), find(model, "take", pn.Transition)
    pn.Arc(id="jump", source=said, target=take, page=listener)
    return "listener"


def foreign_signal(model: sym.SystemModel) -> str:
    talker = find(model, "talker", sym.NodeNet)
    say = sym.Transition(id="say", page=talker)
    clause = sym.InputClause(text="ready", transition=say)
    literal = sym.Literal(signal=find(model, "ready", sym.InputSignal))
    clause.disjunctions.append(sym.Disjunction(literals=[literal]))
    return "talker"


def port_outside(model: sym.SystemModel) -> str:
    page = pn.Page(id="outer", net=model)
    place = sym.Place(id="lonely", page=page)
    (topic,) = model.channels
    assert isinstance(topic, sym.TopicChannel)
    topic.subscribers.append(sym.SubscriberPort(place=place))
    return "lonely"


@pytest.mark.parametrize(
    "spoil", [lonely, between, crossing_reference, crossing_arc, foreign_signal, port_outside]
)
def test_a_model_that_cannot_be_split_is_refused(spoil: Any) -> None:
    model = small_system()
    element = spoil(model)

    with pytest.raises(CoverageError) as caught:
        split(model)

    assert caught.value.element == element
    assert "\n" not in str(caught.value)


def test_places_of_every_class_become_runtime_places() -> None:
    model = small_system()
    talker = find(model, "talker", sym.NodeNet)
    pn.Place(id="plain", tokens=3, page=talker)
    part = split(model)[0]

    copied = find(part, "plain", rtm.Place)
    assert type(copied) is rtm.Place and copied.tokens == 3


def test_ports_of_actions() -> None:
    """Both ends of an action say what the nodes need; every place of it is that of its own part."""
    parts = split(deliveries(2, 1, feedback=True))
    assert [violation for part in parts for violation in validate(part)] == []
    robot, office, _ = parts
    (server,) = (port for place in places(robot) for port in getattr(place, "ports", ()))
    assert isinstance(server, rtm.ActionServerPort)
    assert server.eContainer() is find(robot, "Parcel") and server.page is find(robot, "Deliver")
    assert (server.action, server.instances, server.mayReject, server.depth) == ("/deliver", 1, True, 10)
    assert server.cancel is find(robot, "Stop") and server.feedback is find(robot, "Progress")
    ends = [server.succeeded, server.aborted, server.canceled]
    assert ends == [find(robot, id) for id in ("At", "Lost", "Back")]
    (client,) = (port for place in places(office) for port in getattr(place, "ports", ()))
    assert isinstance(client, rtm.ActionClientPort)
    assert (client.client, client.outstanding, client.eContainer()) == ("office0", 1, find(office, "Send0"))
    assert client.rejected is find(office, "Refused0") and client.cancel is find(office, "Recall0")


@pytest.mark.parametrize(
    ("ids", "names"),
    [
        (["a", "b.c"], ["a.rtm.xmi", "b.c.rtm.xmi"]),
        (["x/y", "x\\y"], ["x_y.rtm.xmi", "x_y~2.rtm.xmi"]),
        (["../up", "..", "é"], ["_up.rtm.xmi", "_.rtm.xmi", "é.rtm.xmi"]),
    ],
)
def test_file_names_stay_in_the_folder(ids: list[str], names: list[str]) -> None:
    parts = [rtm.RuntimeModel(id=id, node=sym.NodeNet(id=id)) for id in ids]
    assert file_names(parts) == names
