"""Messages that are lost because a managed node is not there, or not active: found, excluded, left open."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.checks.check import check
from dineros.analysis.checks.overflow import Presence
from dineros.analysis.witnesses.records import witness_records
from dineros.metamodel import sym
from dineros.metamodel.build import callback, flow, place, step
from dineros.metamodel.elements import find, node_net_of
from dineros.metamodel.records import Drop, Lifecycle
from tests.support.references.lifecycles import LifecycleInterpreter
from tests.support.ros2_systems.deliveries import deliveries
from tests.support.ros2_systems.deserted_services import Asking, ask
from tests.support.ros2_systems.managed_systems import talk

RULES = {fault.rule for fault in Presence.faults}
PROVED = {proved for _, proved in Presence._KINDS.values()}


def found(model: sym.SystemModel) -> list[str]:
    return sorted({finding.rule for finding in check(model).findings if finding.rule in RULES})


def hears_itself(life: sym.Lifecycle) -> sym.SystemModel:
    """Return a node that listens to its own topic: while it publishes, its subscription is there."""
    model = talk(life, None, tokens=1, depth=1)
    talker = find(model, "talker", sym.NodeNet)
    heard = place(talker, "Echo")
    step(talker, "Hear itself", [heard], [])
    (channel,) = model.channels
    channel.subscribers[0].place = heard  # type: ignore[attr-defined]
    return model


LIFE = sym.Lifecycle
LifeOrNone: TypeAlias = sym.Lifecycle | None
BOTH = ["lost-with-node", "subscriber-not-there"]
CASES: list[tuple[Callable[[], sym.SystemModel], list[str]]] = [
    (talk, []),
    (lambda: talk(None, LIFE()), ["subscriber-not-there"]),
    (lambda: talk(LIFE(), None), ["published-while-inactive"]),
    (lambda: talk(LIFE(pauses=True), None), []),
    (lambda: talk(LIFE(pauses=True, deactivates=True), None), ["published-while-inactive"]),
    (lambda: talk(None, LIFE(), late=True), []),
    (lambda: talk(None, LIFE(), late=True, reliability="bestEffort"), ["subscriber-not-there"]),
    (lambda: talk(None, LIFE(cleansUp=True), late=True), ["lost-with-node"]),
    (lambda: talk(LIFE(pauses=True, activateStep=2), LIFE(configureStep=1)), []),
    (lambda: talk(LIFE(pauses=True, activateStep=1), LIFE(configureStep=2)), ["subscriber-not-there"]),
    (
        lambda: talk(LIFE(pauses=True, activateStep=2), LIFE(configureStep=1, cleansUp=True)),
        ["lost-with-node", "subscriber-not-there"],
    ),
    # The reader comes first and leaves: what it missed was written after that, and not while it was there.
    (lambda: talk(LIFE(pauses=True, activateStep=2), LIFE(configureStep=1, shutsDown=True), tokens=1), BOTH),
    (lambda: talk(None, LIFE(shutsDown=True)), BOTH),
    (
        lambda: hears_itself(LIFE(deactivates=True, cleansUp=True)),
        ["lost-with-node", "published-while-inactive"],
    ),
    (lambda: hears_itself(LIFE(shutsDown=True)), ["lost-with-node", "published-while-inactive"]),
    (lambda: hears_itself(LIFE(cleansUp=True, pauses=True)), []),
]


@pytest.mark.parametrize("number", range(len(CASES)))
def test_what_is_found(number: int) -> None:
    make, rules = CASES[number]
    assert found(make()) == rules
    # The same, counted by an interpreter that makes no net: what can happen of all its events.
    assert _happens(make()) == rules


def _happens(model: sym.SystemModel) -> list[str]:
    """Return which losses an exhaustive walk through the model sees."""
    named = {
        "discard": "published-while-inactive",
        "miss": "subscriber-not-there",
        "left": "lost-with-node",
        "gone": "lost-with-node",
        "clear": "lost-with-node",
    }
    play = LifecycleInterpreter(model)
    seen, queue, lost = {play.start}, [play.start], set()
    while queue:
        for event, after in play.successors(queue.pop()):
            lost.add(named.get(event.rpartition(".")[2], ""))
            if after not in seen:
                seen.add(after)
                queue.append(after)
    return sorted(lost - {""})


def test_what_waits_in_the_reader_is_lost_with_a_node_that_is_shut_down() -> None:
    report = check(talk(None, LIFE(shutsDown=True)))
    lost = [each for each in report.findings if each.rule == "lost-with-node"]
    assert any("a message for Heard" in each.message for each in lost)
    stuck = [each.message for each in report.findings if each.rule == "deadlock"]
    assert not any("reader history" in each for each in stuck)


OF_REQUESTS = {"server-not-there", "request-lost-with-server", "request-given-up"}
ASKED: list[tuple[LifeOrNone, list[Asking], list[str]]] = [
    (None, ["once"], []),
    (LIFE(), ["once"], ["server-not-there"]),
    (LIFE(), ["waits"], []),
    (LIFE(), ["engine"], []),
    (LIFE(cleansUp=True), ["engine"], []),
    (LIFE(cleansUp=True), ["waits"], ["request-lost-with-server"]),
    (LIFE(cleansUp=True), ["once", "engine"], ["request-lost-with-server", "server-not-there"]),
    (LIFE(shutsDown=True), ["waits"], ["request-lost-with-server"]),
    (LIFE(cleansUp=True), ["gives up"], ["request-given-up"]),
]


@pytest.mark.parametrize("number", range(len(ASKED)))
def test_requests_to_a_server_that_is_not_there(number: int) -> None:
    life, clients, rules = ASKED[number]
    report = check(ask(life, clients))
    assert sorted({each.rule for each in report.findings} & OF_REQUESTS) == rules
    never_ends = any("not there" in each.message for each in report.findings if each.rule in OF_REQUESTS)
    assert never_ends is bool(rules)


@pytest.mark.parametrize("by_hand", [True, False])
def test_what_is_assumed_of_goals_is_said(by_hand: bool) -> None:
    """Goals outlive a managed server: our engine sends them again, and clients of rclpy do not."""
    model = deliveries(cancels=0, rejects=False)
    find(model, "robot", sym.NodeNet).lifecycle = LIFE(cleansUp=True)
    office = node_net_of(model.channels[0].clients[0].goal)  # type: ignore[attr-defined]
    assert office is not None
    office.execution = sym.Execution.callbacks if by_hand else sym.Execution.net
    notes = [each for each in check(model).findings if each.rule == "goals-outlive-server"]
    assert [each.severity for each in notes] == ["note"] * by_hand
    find(model, "robot", sym.NodeNet).lifecycle = None
    assert "goals-outlive-server" not in {each.rule for each in check(model).findings}


def test_a_callback_that_waits_for_a_lost_request_never_ends() -> None:
    """A timer asks a planner that is restarted, and waits for the answer."""
    model = sym.SystemModel(id="routes", middleware="ros2")
    planner = sym.NodeNet(id="planner", net=model, execution="callbacks", lifecycle=LIFE(cleansUp=True))
    page = callback(planner, "OnRoute", "server")
    asked, answer = place(page, "Asked"), place(page, "Answer")
    step(page, "Plan", [asked], [answer])
    user = sym.NodeNet(id="user", net=model, execution="callbacks", executor="multi", threads=2)
    user.callbackGroups.append(sym.CallbackGroup(id="calls"))
    timer = callback(user, "OnTimer", "timer", timer=1.0)
    request, response, waiting = (place(timer, each) for each in ("Request", "Response", "Waiting"))
    step(timer, "Ask", [], [request, waiting])
    step(timer, "Go", [response, waiting], [])
    port = sym.ClientPort(client="user", request=request, response=response, group=user.callbackGroups[0])
    server = sym.ServerPort(page=page, entry=asked, exit=answer)
    model.channels.append(sym.ServiceChannel(id="Plan", service="/plan", server=server, clients=[port]))
    stuck = {"server-not-there", "request-lost-with-server", "callback-never-ends", "deadlock"}
    assert {each.rule for each in check(model).findings} >= stuck
    port.timeout, port.timedOut = 5.0, place(timer, "NoAnswer")
    step(timer, "Fail", [port.timedOut, waiting], [])
    assert not {each.rule for each in check(model).findings} & stuck


def test_a_witness_says_when_the_nodes_came_up() -> None:
    report = check(talk(LIFE(), LIFE()))
    finding = next(each for each in report.findings if each.rule == "subscriber-not-there")
    assert finding.elements == ("Talk", "Said", "Heard")
    assert finding.witness is not None
    assert [step.text for step in finding.witness.steps] == [
        "node net talker is configured",
        "Say",
        "node net talker is activated",
        "Said publishes a message on topic /talk",
        "a message of Said on topic /talk is lost: Heard of node net listener is not there",
    ]
    records = list(witness_records(finding.witness, source="talk.sym.xmi"))
    changes = [(each.node, each.label, each.state) for each in records if isinstance(each, Lifecycle)]
    assert changes == [("talker", "configure", "inactive"), ("talker", "activate", "active")]
    assert isinstance(records[-1], Drop)


def test_what_is_proved() -> None:
    report = check(talk(LIFE(pauses=True, activateStep=2), LIFE(configureStep=1)))
    assert PROVED.intersection(report.proved) == {
        "no managed node publishes while it is inactive",
        "every subscriber exists when messages are published",
    }
    assert not PROVED.intersection(check(talk()).proved), "nobody asks where no node is managed"


def test_without_a_state_space() -> None:
    """A net without bounds: what can be answered on the way is."""
    model = talk(LIFE(), LIFE())
    talker = find(model, "talker", sym.NodeNet)
    grows = sym.Place(id="Grows", page=talker)
    flow(sym.Transition(id="Grow", page=talker), grows)
    report = check(model)
    assert {each.rule for each in report.findings} >= {"unbounded", "subscriber-not-there"}
    assert all(each.witness for each in report.findings if each.rule in RULES)


def test_a_budget_that_is_too_small() -> None:
    report = check(talk(LIFE(), LIFE()), Budget(seconds=0.0))
    assert not report.findings
    assert report.unknown
