"""Flattening with times has the invariants that it checks, whatever random models say of time."""

from __future__ import annotations

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from dineros.metamodel import sym
from dineros.metamodel.build import seconds
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import node_nets, pages, transitions
from dineros.metamodel.times.rates import TooManyOnTheWayError
from dineros.transformations.flattening.certificate import check_certificate
from dineros.transformations.flattening.flatten import flatten
from tests.support.ros2_systems.action_models import action_models
from tests.support.ros2_systems.executor_models import executor_models
from tests.support.ros2_systems.history_models import history_models
from tests.support.ros2_systems.lifecycle_models import lifecycle_models

ORDERS = (sym.CallbackOrder.any, sym.CallbackOrder.rclcpp, sym.CallbackOrder.rclpy)
TIMES = st.sampled_from([None, (0.0, 0.01), (0.1, 0.1), (0.5, 2.0), (0.1, None)])


def with_times(draw: st.DrawFn, model: sym.SystemModel) -> None:
    """Give a model times, orders and time-outs."""

    def some(owner: object, feature: str) -> None:
        if (given := draw(TIMES)) is not None:
            setattr(owner, feature, seconds(*given))

    for page in pages(model):
        if isinstance(page, sym.CallbackPage):
            some(page, "duration")
            if page.kind == sym.CallbackKind.timer and page.timer:
                some(page, "offset")
                page.jitter = draw(st.sampled_from([None, page.timer / 2]))
    for node in node_nets(model):
        some(node, "reaction")
        node.order = draw(st.sampled_from(list(ORDERS)))
    for channel in model.channels:
        some(channel, "latency")
        if isinstance(channel, sym.ServiceChannel):
            for client in channel.clients:
                if client.timeout is None:
                    client.timeout = draw(st.sampled_from([None, 1.0]))
    for transition in transitions(model):
        if draw(st.integers(0, 5)) == 0:
            some(transition, "interval")


@pytest.mark.long
@pytest.mark.parametrize(
    "models",
    [action_models(), executor_models(), history_models(), lifecycle_models()],
    ids=["actions", "executors", "histories", "lifecycles"],
)
@settings(max_examples=40, deadline=None)
@given(data=st.data())
def test_certificates_hold(models: st.SearchStrategy[sym.SystemModel], data: st.DataObject) -> None:
    model = data.draw(models)
    data.draw(st.composite(lambda draw: with_times(draw, model))())
    assume(not [each for each in validate(model) if each.severity == "error"])
    try:
        net = flatten(model, "none", times=True).net
    except TooManyOnTheWayError:
        return
    check_certificate(net)
