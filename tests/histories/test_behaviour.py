"""Flattened nets behave as the interpreter of ROS 2 says, step by step, on generated models."""

from __future__ import annotations

from typing import get_args

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dineros.analysis.model.subject import base_subject, subject_of
from dineros.analysis.questions.state_space import state_space
from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.constraints import validate
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.rules.phases import OverflowVariant, SignalVariant
from tests.histories.comparing import variants
from tests.histories.test_figures import periodic
from tests.support.equal_behaviour import compare
from tests.support.references.flattening import PlainNet, plain_net_of
from tests.support.references.histories import Interpreter
from tests.support.ros2_systems.history_models import history_models


@given(history_models())
@settings(max_examples=25, suppress_health_check=[HealthCheck.too_slow])
def test_generated_models_are_valid(model: sym.SystemModel) -> None:
    assert [found for found in validate(model) if found.severity == "error"] == []


@pytest.mark.long
@given(history_models(), st.sampled_from(get_args(SignalVariant)), st.sampled_from(get_args(OverflowVariant)))
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_generated_models(model: sym.SystemModel, signals: SignalVariant, overflow: OverflowVariant) -> None:
    for _, _, found in variants(model, 300, [signals], [overflow]):
        assert found.difference == ""


def test_a_difference_is_noticed() -> None:
    model = periodic(1)
    net = plain_net_of(flatten(model, "none").net)
    interpreter = Interpreter(model)
    assert compare(net, interpreter, 1000).complete
    for number, (source, target, weight, kind) in enumerate(net.arcs):
        others = [*net.arcs[:number], *net.arcs[number + 1 :]]
        for changed in (others, [*others, (source, target, weight + 1, kind)]):
            altered = PlainNet(net.places, net.transitions, changed)
            assert (
                compare(altered, interpreter, 200).difference
                or not compare(altered, interpreter, 200).complete
            )


@pytest.mark.parametrize("middleware", ["ros1", "ros2"])
def test_a_declared_capacity_holds_under_every_middleware(middleware: str) -> None:
    model = sym.SystemModel(id="bounded", middleware=middleware)
    net = sym.NodeNet(id="node", net=model)
    box = sym.Place(id="Box", capacity=3, tokens=1, page=net)
    make, take = sym.Transition(id="Make", page=net), sym.Transition(id="Take", page=net)
    flow(make, box, weight=2)
    flow(box, take)
    flattened = flatten(model, "none")
    found = compare(plain_net_of(flattened.net), Interpreter(model), 100)
    assert (found.states, found.complete, found.difference) == (4, True, "")
    assert [each.name for each in flattened.net.certificate] == ["Box + Box.free"]


def test_a_loop_that_leaves_a_place_as_it_is_needs_no_room() -> None:
    model = sym.SystemModel(id="loop")
    net = sym.NodeNet(id="node", net=model)
    box, look = sym.Place(id="Box", capacity=1, tokens=1, page=net), sym.Transition(id="Look", page=net)
    flow(box, look, box)
    (page,) = flatten(model, "none").net.pages
    assert sorted(arc.id for arc in page.arcs) == ["Box-Look", "Look-Box"]


def test_the_copies_of_a_server_page_have_capacities_of_their_own() -> None:
    model = sym.SystemModel(id="copies")
    net = sym.NodeNet(id="node", net=model)
    page = sym.CallbackPage(id="page", kind="server", page=net)
    entry, exit_ = sym.Place(id="In", page=page, capacity=1), sym.Place(id="Out", page=page)
    flow(entry, sym.Transition(id="Serve", page=page), exit_)
    model.channels.append(
        sym.ServiceChannel(
            id="S",
            service="/s",
            instances=2,
            server=sym.ServerPort(entry=entry, exit=exit_, page=page),
        )
    )
    flattened = flatten(model, "none")
    names = {node.id for node in flattened.net.pages[0].objects if isinstance(node, pn.Place)}
    assert {"S[1].In.free", "S[2].In.free"} <= names
    assert "In.free" not in names


def test_a_transition_that_can_never_fire_counts_for_the_room_of_a_publisher() -> None:
    """`check` leaves it out of the net without signals, and the room stays what it is in the others."""
    model = periodic(1)
    (timer, _) = model.pages
    said = next(node for node in timer.objects if isinstance(node, sym.Place))
    assert isinstance(timer, sym.NodeNet)
    timer.signals.append(sym.InputSignal(id="Go"))
    burst = sym.Transition(id="Burst", page=timer)
    flow(burst, said, weight=3)
    set_clause(burst, "Go & !Go")
    base, whole = base_subject(model), subject_of(model, "fully-enabled")
    assert base.blocked == ("Burst",)
    assert "Burst" not in base.net.transitions
    room = [int(each.net.initial[each.place_index["Said.free"]]) for each in (base, whole)]
    assert room == [3, 3]
    counts = [state_space(each.net, "symbolic").states for each in (base, whole)]
    assert counts[1] == 2 * (counts[0] or 0)
