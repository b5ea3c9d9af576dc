"""What is found about server pages that call and publish, in the words of the model."""

from __future__ import annotations

import pytest

from dineros.analysis.checks.check import check
from dineros.analysis.suggestions.capacities import suggest_capacities
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.calls import CallCircleError, instance_counts
from dineros.metamodel.elements import find
from dineros.metamodel.settings import apply
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.flattening.split import split
from tests.support.systems.bakery import bakery


def service(model: sym.SystemModel, id: str) -> sym.ServiceChannel:
    found = next(channel for channel in model.channels if channel.id == id)
    assert isinstance(found, sym.ServiceChannel)
    return found


def circle() -> sym.SystemModel:
    """Return the bakery whose oven orders bread from the shop."""
    model = bakery()
    page = service(model, "Bake").server.page
    ask, answer = (sym.Place(id=id, page=page) for id in ("Hungry", "Fed"))
    service(model, "Order").clients.append(sym.ClientPort(client="oven", request=ask, response=answer))
    return model


def test_instances_of_a_caller_are_counted_as_clients() -> None:
    for declared, count in ((None, 2), (1, 1), (3, 3)):
        counts = {channel.id: number for channel, number in instance_counts(bakery(declared)).items()}
        assert counts == {"Order": count, "Bake": count, "Print": 1}


def test_a_circle_needs_a_number_and_is_named() -> None:
    model = circle()
    for ask in (flatten, split):
        with pytest.raises(CallCircleError, match=r"services call each other in a circle: (Order|Bake) -> "):
            ask(model)
    apply(model, "Bake.instances=2")
    counts = {channel.id: number for channel, number in instance_counts(model).items()}
    assert counts == {"Order": 4, "Bake": 2, "Print": 1}
    assert len(split(model)) == 6


def test_the_one_queue_of_all_instances_overflows() -> None:
    model = bakery()
    apply(model, "Sales.publisher.Told.limit=1")
    found = [finding for finding in check(model).findings if finding.rule == "queue-overflow"]
    assert [(finding.message, finding.elements) for finding in found] == [
        ("publisher queue of Told (topic /sales) can overflow: a message is lost", ("Sales", "Told"))
    ]
    witness = found[0].witness
    assert witness is not None
    texts = [step.text for step in witness.steps]
    assert "instance 1 of service /order calls service /bake" in texts
    assert "instance 1 of service /bake takes the request of instance 2 of service /order" in texts
    assert texts[-1].startswith("publisher queue of Told (topic /sales) loses a message of instance ")


def test_the_capacity_that_all_instances_need() -> None:
    model = bakery()
    needed = {str(each.queue): each.needed for each in suggest_capacities(model)}
    assert needed["publisher queue of Told (topic /sales)"] == 4
    assert not any(finding.rule == "queue-overflow" for finding in check(model).findings)
    apply(model, "Sales.publisher.Told.limit=3")
    assert any(finding.rule == "queue-overflow" for finding in check(model).findings)


def test_services_that_wait_for_each_other_are_a_deadlock() -> None:
    """The shop's only instance waits for the oven, whose only instance waits for the shop."""
    model = circle()
    apply(model, "Order.instances=1")
    apply(model, "Bake.instances=1")
    page = service(model, "Bake").server.page
    heat = next(node for node in page.objects if isinstance(node, sym.Transition))
    (out,) = heat.outgoing
    out.target = find(model, "Hungry", sym.Place)
    flow(
        find(model, "Fed", sym.Place),
        sym.Transition(id="TakeOut", page=page),
        service(model, "Bake").server.exit,
    )
    kinds = {finding.rule for finding in check(model).findings}
    assert "deadlock" in kinds
    assert "service-never-returns" in kinds
