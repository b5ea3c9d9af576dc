"""Start orders in which nothing is lost, against all orders there are."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

from dineros.analysis.answers.budget import Budget
from dineros.analysis.checks.check import check
from dineros.analysis.checks.overflow import Presence
from dineros.analysis.suggestions.start_orders import suggest_start_order
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.elements import find
from dineros.metamodel.lifecycles.start_order import managed_nodes
from dineros.metamodel.settings import apply
from tests.support.ros2_systems.deliveries import deliveries
from tests.support.ros2_systems.managed_systems import camera, talk

RULES = {fault.rule for fault in Presence.faults}


def losses(model: sym.SystemModel) -> bool:
    return any(finding.rule in RULES for finding in check(model).findings)


def total_orders(model: sym.SystemModel) -> Iterator[list[str]]:
    """Yield the settings of every order that does one thing after the other."""
    nodes = [node.id for node in managed_nodes(model)]
    things = [(what, node) for node in nodes for what in ("configure", "activate")]
    for order in itertools.permutations(things):
        if all(order.index(("configure", node)) < order.index(("activate", node)) for node in nodes):
            yield [f"{node}.lifecycle.{what}Step={step}" for step, (what, node) in enumerate(order, 1)]


def pipeline(*, restless: bool = False) -> sym.SystemModel:
    """Return two nodes that tell each other something; also while they are inactive (`restless`)."""
    model = sym.SystemModel(id="both", middleware="ros2")
    ends = {}
    for name in ("left", "right"):
        net = sym.NodeNet(id=name, net=model, lifecycle=sym.Lifecycle(pauses=not restless))
        say = sym.Place(id=f"{name}.say", tokens=1, page=net)
        said, heard = sym.Place(id=f"{name}.said", page=net), sym.Place(id=f"{name}.heard", page=net)
        flow(say, sym.Transition(id=f"{name}.speak", page=net), said)
        flow(heard, sym.Transition(id=f"{name}.listen", page=net))
        ends[name] = (said, heard)
    for sender, getter in (("left", "right"), ("right", "left")):
        topic = sym.TopicChannel(id=f"of_{sender}", topic=f"/{sender}", model=model)
        topic.publishers.append(sym.PublisherPort(place=ends[sender][0], limit=1))
        topic.subscribers.append(sym.SubscriberPort(place=ends[getter][1], limit=1))
    return model


def test_the_camera() -> None:
    model = camera()
    found = suggest_start_order(model)
    assert found.faults and found.is_found
    assert found.order == [
        *(("configure", node) for node in ("display", "detector", "camera")),
        *(("activate", node) for node in ("display", "detector", "camera")),
    ]
    for setting in found.settings:
        apply(model, setting)
    for node in managed_nodes(model):
        assert node.lifecycle is not None
        node.lifecycle.cleansUp = node.lifecycle.deactivates = False
    assert not losses(model)
    again = suggest_start_order(model)
    assert (again.is_found, again.order, again.tried) == (True, [], 0)


def test_against_all_orders() -> None:
    """Two nodes that tell each other something are both configured before one is active."""
    expected = []
    for settings in total_orders(pipeline()):
        model = pipeline()
        for setting in settings:
            apply(model, setting)
        expected.append((settings, losses(model)))
    assert len(expected) == 6 and 0 < sum(bad for _, bad in expected) < 6
    found = suggest_start_order(pipeline())
    assert (list(found.settings), False) in expected


def test_where_no_order_helps() -> None:
    """Who publishes while inactive loses messages in every order; so does one that is not managed."""
    for model in (pipeline(restless=True), talk(None, sym.Lifecycle())):
        found = suggest_start_order(model)
        assert (found.is_found, found.is_proved) == (False, True)
        assert found.reason == "in every start order a message can be lost"
    for settings in total_orders(pipeline(restless=True)):
        model = pipeline(restless=True)
        for setting in settings:
            apply(model, setting)
        assert losses(model)


def test_later_losses_are_no_question_of_the_order() -> None:
    model = talk(sym.Lifecycle(pauses=True, deactivates=True), sym.Lifecycle(cleansUp=True))
    found = suggest_start_order(model)
    assert found.is_found and found.order[0] == ("configure", "listener")
    talker = find(model, "talker", sym.NodeNet)
    assert talker.lifecycle is not None and talker.lifecycle.deactivates, "the model is as it was"


def test_a_budget_that_is_too_small() -> None:
    found = suggest_start_order(camera(), Budget(seconds=0.0))
    assert not found.is_found and not found.is_proved and found.reason


def test_a_managed_server_of_an_action() -> None:
    model = deliveries(cancels=0, rejects=False)
    find(model, "robot", sym.NodeNet).lifecycle = sym.Lifecycle()
    assert suggest_start_order(model, Budget(seconds=60.0)).is_found
