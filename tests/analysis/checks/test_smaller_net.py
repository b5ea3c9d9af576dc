"""Where a state space costs much a smaller net answers `check`, and says what the state space says."""

from __future__ import annotations

import re

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.checks import boundedness as module
from dineros.analysis.checks.boundedness import Places
from dineros.analysis.checks.check import check
from dineros.analysis.model.subject import base_subject
from dineros.analysis.nets.bounds import place_bounds
from dineros.analysis.nets.models import to_model
from dineros.analysis.witnesses.findings import Report
from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, flow, place, step
from dineros.metamodel.elements import places as all_places
from dineros.metamodel.errors import DinerosError
from tests.analysis.properties.test_recurrence import turning_net
from tests.support.ros2_systems.managed_systems import talk
from tests.support.systems.calling_systems import calling_systems
from tests.support.systems.chatty_systems import chatty_systems
from tests.support.systems.looping_clients import COUNTS, looping_clients
from tests.support.systems.small_systems import small_system_models

PLACES = {fault.rule for fault in Places.faults}


def checked_without_space(model: pn.Net) -> Report:
    """Check with no work for the state space where a smaller net answers."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "FIRST_SHARE", 0)
        return check(model, Budget(1 << 28))


def what_it_says(report: Report) -> tuple[object, ...]:
    """Findings, what is proved without numbers of markings, and what is unknown.

    At which places a net is not one-safe, or its marking stable, all markings tell alone.
    """
    findings = [
        (f.rule,) if f.rule in PLACES else (f.rule, f.elements, f.message, f.witness is None)
        for f in report.findings
    ]
    numbers = r"bounded: .*|^(all markings|[\d,]+ home markings?)"
    proved = [re.sub(numbers, "", text) for text in report.proved]
    return findings, proved, [str(unknown) for unknown in report.unknown]


def agrees(model: pn.Net) -> bool:
    """Whether a smaller net answered; what it said is compared."""
    forced, usual = checked_without_space(model), check(model, Budget(1 << 28))
    assert what_it_says(forced) == what_it_says(usual)
    return forced.space is None and usual.space is not None


@pytest.mark.long
@given(st.one_of(small_system_models(), chatty_systems(), calling_systems()))
@settings(max_examples=3, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_generated_systems(model: pn.Net) -> None:
    try:
        net = base_subject(model).net
    except DinerosError:  # priorities, which are not analysed
        return
    assume(None not in place_bounds(net))  # else no smaller net is asked
    agrees(model)


def ping_pong(players: int) -> sym.SystemModel:
    """Return a system of nodes that send a ball around, forever; each topic has room for one message."""
    model = sym.SystemModel(id="ball")
    nets = [sym.NodeNet(id=f"player{number}", net=model) for number in range(players)]
    for number, net in enumerate(nets):
        receiver = nets[(number + 1) % players]
        sent = sym.Place(id=f"Sent{number}", page=net)
        heard = sym.Place(id=f"Heard{number}", tokens=int(number == 0), page=receiver)
        topic = sym.TopicChannel(id=f"Ball{number}", topic=f"/ball{number}", model=model)
        topic.publishers.append(sym.PublisherPort(place=sent, limit=1))
        topic.subscribers.append(sym.SubscriberPort(place=heard, limit=1))
        topic.dispatchers.append(sym.Dispatcher(node=receiver, limit=1))
    places = {str(place.id): place for place in all_places(model)}
    for number, net in enumerate(nets):
        came, goes = places[f"Heard{(number - 1) % players}"], places[f"Sent{number}"]
        flow(came, sym.Transition(id=f"Play{number}", page=net), goes)
    return model


def test_queues_that_never_overflow() -> None:
    model = ping_pong(3)
    assert agrees(model)
    proved = checked_without_space(model).proved
    assert len([text for text in proved if text.endswith("never overflows")]) >= 3


def test_a_queue_that_overflows_although_the_net_comes_back() -> None:
    """Under the rules of ROS 2 nothing counts lost messages: that a net comes back does not rule them out."""
    model = listening()
    report = checked_without_space(model)
    assert report.space is None, "a smaller net has answered"
    found = [each for each in report.findings if each.rule == "queue-overflow"]
    assert len(found) == 2, "the history of the writer, and that of the reader"
    for each in found:
        assert each.witness is not None and "loses a message" in each.witness.steps[-1].text
    assert report.unknown == []
    assert agrees(model)


def listening() -> sym.SystemModel:
    """Return a timer that publishes to a subscriber, which takes one message after the other."""
    model = sym.SystemModel(id="listening", middleware="ros2")
    talker, listener = (sym.NodeNet(id=id, net=model, execution="callbacks") for id in ("talker", "listener"))
    tick, hear = callback(talker, "OnTick", "timer", 1.0), callback(listener, "OnHeard")
    sent, heard = place(tick, "Sent"), place(hear, "Heard")
    step(tick, "Say", [], [sent])
    step(hear, "Note", [heard], [])
    topic = sym.TopicChannel(id="Talk", topic="/talk", model=model)
    topic.publishers.append(sym.PublisherPort(place=sent, limit=2))
    topic.subscribers.append(sym.SubscriberPort(place=heard, limit=2))
    return model


@pytest.mark.long
def test_nets_of_circles() -> None:
    answered = [agrees(to_model(turning_net(seed), "turning")) for seed in range(80)]
    assert answered.count(True) >= 15 and answered.count(False) >= 15


@pytest.mark.long
@pytest.mark.parametrize(("clients", "services"), COUNTS)
def test_looping_clients(clients: int, services: int) -> None:
    assert agrees(looping_clients(clients, services))


@pytest.mark.long
def test_many_looping_clients() -> None:
    report = check(looping_clients(8, 4))
    assert report.findings == [] and report.unknown == []
    assert report.space is None
    assert "no deadlock" in report.proved
    assert "every transition can fire, every channel is used" in report.proved
    assert "the net is live: every transition can always fire again" in report.proved
    assert "the net is reversible: the initial marking can always be reached again" in report.proved


def test_bounds_of_places_prove_boundedness_without_a_state_space(monkeypatch: pytest.MonkeyPatch) -> None:
    def out_of_time(*_: object, **__: object) -> None:
        raise BudgetExceededError("time ran out")

    monkeypatch.setattr(module, "symbolic_state_space", out_of_time)
    model = talk(None, None)
    report = check(model)
    most = max(bound.value for bound in place_bounds(base_subject(model).net) if bound is not None)
    told = f"the net is bounded: no place ever holds more than {most} tokens"
    assert any(each.startswith(told) for each in report.proved)
    assert not any("bounded" in each.question for each in report.unknown)
