"""The view of a model: what it holds, and what it says about it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.metamodel import elements, pn, pnm, sym
from dineros.metamodel.build import seconds
from dineros.metamodel.files import load
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.flattening.split import split
from dineros.views.nets import ViewModel, view_of
from dineros.views.nets.contents.times import interval_words
from tests.support.ros2_systems.managed_systems import camera
from tests.support.systems.bakery import bakery
from tests.support.systems.ovens import oven
from tests.support.systems.talker import talker
from tests.views.nets.samples import case_study, every_sign, models


@pytest.mark.parametrize("name", list(models()))
def test_every_element_is_there_once(name: str) -> None:
    model = models()[name]
    view = view_of(model)
    ids = [item.id for item in view.elements()]
    assert len(ids) == len(set(ids))
    channels = {node.id for node in view.nodes if node.kind in ("topic", "service")}
    assert {node.id for node in view.nodes} - channels == {node.id for node in elements.nodes(model)}
    arcs = {edge.id for edge in view.edges} | {edge.also for edge in view.edges}
    assert {arc.id for arc in elements.arcs(model)} <= arcs
    pages = list(elements.pages(model))
    kept = [page for page in pages if len(pages) > 1 or isinstance(page, sym.NodeNet)]
    assert [box.id for box in view.boxes] == [page.id for page in kept]
    if isinstance(model, sym.SystemModel):
        assert channels == {channel.id for channel in model.channels}


def test_channels_join_the_places_of_their_ports() -> None:
    lines = {(edge.kind, edge.source, edge.target): edge.label for edge in view_of(case_study()).edges}
    assert lines["publish", "SortRed", "LeftCellObjects"] == "queue 10"
    assert lines["subscribe", "LeftCellObjects", "ReqControlL"] == "dispatcher 16, queue 10"
    assert lines["request", "PickReqL", "Pick"] == "L"
    assert lines["response", "Pick", "PickResR"] == "R"
    assert ("call", "Pick", "PickEntry") in lines
    assert ("return", "PickExit", "Pick") in lines


def test_channels_from_a_server_page_join_its_places_and_count_its_instances() -> None:
    view = view_of(bakery(3))
    lines = {(edge.kind, edge.source, edge.target): edge.label for edge in view.edges}
    assert lines["request", "Dough", "Bake"] == lines["response", "Bake", "Baked"] == "baker"
    assert lines["publish", "Told", "Sales"] == "queue 4"
    assert view.node("Bake").captions[0].text == "service, 3 instances"  # one for each instance of Order
    circle = bakery()
    order, bake = (each for each in circle.channels if each.id in ("Order", "Bake"))
    assert isinstance(order, sym.ServiceChannel) and isinstance(bake, sym.ServiceChannel)
    ask, answer = (sym.Place(id=id, page=bake.server.page) for id in ("Ask", "Answer"))
    order.clients.append(sym.ClientPort(client="oven", request=ask, response=answer))
    assert view_of(circle).node("Bake").captions[0].text == "service"  # not valid, and shown


def test_what_a_client_does_about_answers_that_take_long() -> None:
    def lines(model: sym.SystemModel) -> dict[tuple[str, str, str], str]:
        return {(edge.kind, edge.source, edge.target): edge.label for edge in view_of(model).edges}

    told = lines(oven(1, outstanding=2, timeout=0.5, tells=True))
    assert told["request", "Ask0", "Oven"] == "baker0, 2 at a time"
    assert told["response", "Oven", "Late0"] == "baker0 gives up after 0.5 s"
    assert lines(oven(1, timeout=2.0))["request", "Ask0", "Oven"] == "baker0, gives up after 2 s"
    shared = oven(2, timeout=1.0, tells=True)
    (channel,) = shared.channels
    assert isinstance(channel, sym.ServiceChannel)
    first, second = channel.clients
    second.timedOut, first.timedOut = first.timedOut, first.response
    found = lines(shared)
    assert found["response", "Oven", "Got0"] == "baker0, or gives up after 1 s"
    assert found["response", "Oven", "Late0"] == "baker1 gives up after 1 s"
    first.timedOut = second.timedOut
    assert (
        lines(shared)["response", "Oven", "Late0"] == "baker0 gives up after 1 s, baker1 gives up after 1 s"
    )


def test_a_managed_node_says_so() -> None:
    assert [box.subtitle for box in view_of(camera()).boxes if box.kind == "node"] == ["managed ROS node"] * 3


def test_limits_that_differ_are_shown() -> None:
    model = talker()
    channel = model.channels[0]
    assert isinstance(channel, sym.TopicChannel)
    channel.publishers[0].limit, channel.subscribers[0].limit = 3, 4
    channel.dispatchers.append(sym.Dispatcher(node=elements.node_nets(model)[1], limit=5))
    labels = [edge.label for edge in view_of(model).edges if edge.kind in ("publish", "subscribe")]
    assert labels == ["queue 3", "dispatcher 5, queue 4"]
    model.middleware = sym.Middleware.ros2
    channel.subscribers[0].qos = sym.QualityOfService(reliability="bestEffort")
    labels = [edge.label for edge in view_of(model).edges if edge.kind in ("publish", "subscribe")]
    assert labels == ["history 3", "history 4, best effort"]


def test_nodes_say_what_they_hold() -> None:
    view = view_of(case_study())
    assert (view.kind, view.title) == ("system model", "sorting")
    assert view.node("Unsafe").tokens == 1
    assert view.node("RedObjects").detail == {"Token data": '{"color": "red"}'}
    clause = "(RobotIsIdle | RobotHasFinished) & ObjectIsPicked"
    assert view.node("TPickSuccess").captions[1].text == clause
    assert view.node("TPickSuccess").detail == {"Input clause": f"ICPickSuccess: {clause}"}
    assert [caption.text for caption in view.node("Pick").captions] == ["service, 2 instances"]
    executor = view.box("executor")
    assert (executor.kind, executor.subtitle, executor.summary) == (
        "node",
        "ROS node",
        "10 places, 12 transitions, 3 pages",
    )
    assert [signal.id for signal in executor.signals][-1] == "Danger"
    assert (view.box("PickServer").kind, view.box("PickServer").parent) == ("server", "executor")
    with pytest.raises(KeyError):
        view.node("nobody")


def test_transitions_show_their_guards_and_assignments() -> None:
    guarded = load(Path(__file__).resolve().parents[4] / "case_study/guarded.sym.xmi")
    assert isinstance(guarded, sym.SystemModel)
    view = view_of(guarded)
    assert [(caption.text, caption.style) for caption in view.node("TGiveUpL").captions] == [
        ("TGiveUpL", "name"),
        ("[pickSuccess = false]", "clause"),
        ("EndReqL.placeSuccess := false", "clause"),
    ]


def test_references_lead_to_what_they_stand_for() -> None:
    view = view_of(case_study())
    assert view.node("Safe@PickServer").target == "Safe"
    assert [
        edge.kind for edge in view.edges if {edge.source, edge.target} == {"Safe", "Safe@PickServer"}
    ] == ["reference"]


def test_two_opposite_arcs_are_one_read_arc() -> None:
    view = view_of(case_study())
    edge = next(edge for edge in view.edges if edge.source == "Safe@PickServer")
    assert (edge.target, edge.kind, edge.also) == ("TPick", "read", "TPick-Safe@PickServer")


def test_opposite_arcs_of_different_weight_stay_two() -> None:
    place, step = pn.Place(id="p"), pn.Transition(id="t")
    page = pn.Page(id="page", objects=[place, step])
    for source, target, weight in ((place, step, 2), (step, place, 1)):
        pn.Arc(id=f"{source.id}{target.id}", source=source, target=target, weight=weight, page=page)
    assert [(edge.kind, edge.label) for edge in view_of(pn.Net(id="n", pages=[page])).edges] == [
        ("normal", "2"),
        ("normal", ""),
    ]


def test_kinds_of_arcs_weights_and_intervals() -> None:
    view = view_of(every_sign())
    edges = {edge.id: (edge.kind, edge.label) for edge in view.edges}
    assert edges["few-go"] == ("normal", "12")
    assert edges["many-go-read"] == ("read", "")
    assert edges["none-go-inhibitor"] == ("inhibitor", "2")
    assert [caption.text for caption in view.node("go").captions] == ["go", "[1, 2]"]
    assert view.node("stop").detail == {"Goes before": "go"}
    assert [box.id for box in view.boxes] == ["outer", "inner", "empty"]


def test_a_runtime_model_shows_its_channels_outside() -> None:
    controller = next(model for model in split(case_study()) if "controller" in model.id)
    view = view_of(controller)
    channels = {node.id: node.kind for node in view.nodes if node.box is None}
    assert channels["LeftCellObjects"] == "topic"
    assert channels["Pick"] == "service"
    lines = {(edge.kind, edge.source, edge.target) for edge in view.edges}
    assert ("request", "PickReqL", "Pick") in lines
    assert ("response", "Pick", "PickResL") in lines
    assert view.kind == "runtime model"


def test_a_flattened_net_is_grouped() -> None:
    view: ViewModel = view_of(flatten(case_study()).net)
    assert view.kind == "Petri-net model"
    queue = view.box("group LeftCellObjects.publisher.SortRed")
    assert (queue.title, queue.parent) == ("publisher.SortRed", "group LeftCellObjects")
    assert view.box("group LeftCellObjects").parent is None
    assert view.node("LeftCellObjects.publisher.SortRed.Load").box == queue.id
    assert view.node("RedObjects").box is None


def test_views_are_json() -> None:
    for model in models().values():
        view = view_of(model).to_json()
        assert set(json.loads(json.dumps(view))) >= {"id", "title", "kind", "boxes", "nodes", "edges"}


def test_a_model_with_faults_has_a_picture() -> None:
    model = sym.SystemModel(id="faulty", pages=[sym.NodeNet(id="alone")])
    alone = elements.node_nets(model)[0]
    one, other = pn.ReferencePlace(id="one", page=alone), pn.ReferencePlace(id="other", page=alone)
    one.target, other.target = other, one
    pn.Arc(id="half", source=one, page=alone)
    model.channels.append(sym.TopicChannel(id="nobody", topic="nobody", publishers=[sym.PublisherPort()]))
    model.channels.append(sym.ServiceChannel(id="service", service="s", clients=[sym.ClientPort(client="c")]))
    view = view_of(model)
    assert [node.id for node in view.nodes] == ["one", "other", "nobody", "service"]
    assert [edge.kind for edge in view.edges] == ["reference", "reference"]


@pytest.mark.parametrize(
    ("interval", "shown"),
    [
        (pn.TimeInterval(earliest=1, latest=2), "[1, 2]"),
        (pn.TimeInterval(earliest=5), "[5, ∞["),
        (pn.TimeInterval(earliest=1, latest=2, earliestExcluded=True, latestExcluded=True), "]1, 2["),
    ],
)
def test_an_interval_is_open_where_its_bound_is_left_out(interval: pn.TimeInterval, shown: str) -> None:
    net = pnm.PetriNetModel(id="net")
    page = pn.Page(id="page", net=net)
    pn.Transition(id="t", page=page, interval=interval)
    (node,) = view_of(net).nodes
    assert [caption.text for caption in node.captions][-1] == shown


def test_times_are_shown_with_their_units() -> None:
    model = sym.SystemModel(id="robot", middleware="ros2")
    node = sym.NodeNet(id="camera", net=model, reaction=seconds(0, 0.02))
    page = sym.CallbackPage(id="OnFrame", kind="timer", timer=0.1, page=node, duration=seconds(0.005, 0.02))
    page.offset, page.jitter = seconds(0, 0), 0.001
    step = sym.Transition(
        id="Shoot", page=page, duration=seconds(1, 1.5), interval=pn.TimeInterval(earliest=2)
    )
    image, seen = (sym.Place(id=id, page=page) for id in ("Image", "Seen"))
    topic = sym.TopicChannel(id="Images", topic="images", model=model, latency=seconds(0, 0.01))
    topic.publishers.append(sym.PublisherPort(place=image, limit=1, latency=seconds(0.002, 0.002)))
    topic.subscribers.append(sym.SubscriberPort(place=seen, limit=1))
    view = view_of(model)
    boxes = {box.id: box for box in view.boxes}
    assert boxes["camera"].subtitle == "ROS node, reacts in at most 20 ms"
    assert boxes["OnFrame"].subtitle == "timer callback every 0.1 s, takes 5 to 20 ms"
    assert boxes["OnFrame"].detail == {"First strike": "after 0 ms", "Jitter": "at most 1 ms"}
    captions = {node.id: [caption.text for caption in node.captions] for node in view.nodes}
    assert captions[step.id] == ["Shoot", "[2, ∞[ s", "takes 1 to 1.5 s"]
    assert captions["Images"] == ["topic, at most 10 ms on the way"]
    labels = {edge.kind: edge.label for edge in view.edges}
    assert labels["publish"] == "history 1, 2 ms on the way"
    assert labels["subscribe"] == "history 1"


@pytest.mark.parametrize(
    ("interval", "words"),
    [
        (pn.TimeInterval(), "any time"),
        (pn.TimeInterval(earliest=0.1, latest=0.1), "100 ms"),
        (pn.TimeInterval(earliest=0.1, latest=0.3, earliestExcluded=True), "more than 100 to 300 ms"),
        (pn.TimeInterval(latest=2, latestExcluded=True), "less than 2 s"),
        (pn.TimeInterval(earliest=0, earliestExcluded=True), "more than 0 ms"),
        (pn.TimeInterval(earliest=1, latest=float("inf")), "1 to inf s"),
    ],
)
def test_intervals_in_words(interval: pn.TimeInterval, words: str) -> None:
    assert interval_words(interval) == words
