"""Requests that are lost, clients that give up: counts, findings, and what server pages make of them."""

from __future__ import annotations

import pytest

from dineros.analysis.checks.check import check
from dineros.analysis.model.subject import base_subject
from dineros.analysis.model.wording import words
from dineros.analysis.questions.state_space import state_space
from dineros.analysis.suggestions.capacities import suggest_capacities
from dineros.cli.presentation.traces import witness_builder
from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, flow, node_net, place, step
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.rules.phases import OverflowVariant
from tests.support.equal_behaviour import compare
from tests.support.references.executors import ExecutorInterpreter
from tests.support.references.flattening import PlainNet, plain_net_of
from tests.support.references.histories import Interpreter
from tests.support.ros2_systems.executor_cases import Case, case_model
from tests.support.systems.ovens import oven

FIGURES = {
    "one request each": (oven(3, 1), 611),
    "two requests each": (oven(2, 2, outstanding=2), 1534),
    "time-outs": (oven(2, 1, timeout=0.5), 143),
    "time-outs that are told": (oven(2, 1, timeout=0.5, tells=True), 338),
}


@pytest.mark.parametrize("overflow", ["weighted", "inhibitor"])
@pytest.mark.parametrize("name", FIGURES)
def test_figures(name: str, overflow: OverflowVariant) -> None:
    """Also with time-outs the net is finite."""
    model, states = FIGURES[name]
    subject = base_subject(model, overflow=overflow)
    counts = [state_space(subject.net, engine) for engine in ("explicit", "symbolic")]
    expected = Interpreter(model).count()
    assert expected[0] == states
    assert [each.states for each in counts] == [states, states]
    assert counts[0].arcs == expected[1]


def test_a_difference_is_noticed() -> None:
    """Every arc of a net with all that the rules make counts."""
    model = oven(2, 1, timeout=0.5, tells=True)
    net, interpreter = plain_net_of(flatten(model, "none").net), Interpreter(model)
    assert compare(net, interpreter, 1000).complete
    for number in range(len(net.arcs)):
        altered = PlainNet(net.places, net.transitions, [*net.arcs[:number], *net.arcs[number + 1 :]])
        found = compare(altered, interpreter, 400)
        assert found.difference or not found.complete, net.arcs[number]


def test_nothing_is_added_where_nothing_can_be_lost() -> None:
    kept, limited = (flatten(oven(3, depth), "none").net for depth in (3, 10))
    assert plain_net_of(kept) == plain_net_of(limited)
    model = oven(3, 3)
    model.middleware = "ros1"
    assert plain_net_of(kept) == plain_net_of(flatten(model, "none").net)


def test_the_rules_of_ros1_know_nothing_of_it() -> None:
    plain = oven(3, 10)
    plain.middleware = "ros1"
    model = oven(3, 1, timeout=0.5)
    model.middleware = "ros1"
    for client in model.channels[0].clients:  # type: ignore[attr-defined]
        client.outstanding = 4
    assert plain_net_of(flatten(model, "none").net) == plain_net_of(flatten(plain, "none").net)


def test_more_than_ten_clients() -> None:
    for bakers, loses in ((10, False), (11, True)):
        trace = flatten(oven(bakers, 10), "none").trace
        assert len(trace.role("R5", "capacity")) == loses
        assert len(trace.role("R5Client", "queue.drop")) == bakers * loses


def test_a_depth_that_is_enough() -> None:
    (overflow,) = [found for found in check(oven(3, 2)).findings if found.rule == "queue-overflow"]
    assert overflow.message == "request history of service /bake can overflow: a request is lost"
    assert overflow.elements == ("Oven", "Dough")
    (needed,) = suggest_capacities(oven(3, 2))
    assert (str(needed.queue), needed.limit, needed.needed) == ("request history of service /bake", 2, 3)
    assert not suggest_capacities(oven(3, 3))
    (endless,) = suggest_capacities(oven(2, 1, timeout=0.5, tells=True))
    assert endless.grows, "a client that gives up asks again and again"


def test_what_is_said() -> None:
    model = oven(2, 1, timeout=0.5)
    (overflow,) = [found for found in check(model).findings if found.rule == "queue-overflow"]
    assert overflow.witness is not None
    assert overflow.witness.steps[-1].text == (
        "a request is lost: client baker0 of service /bake waits until its time-out"
    )
    said = {link.target.id: words(link) for link in flatten(model, "none").trace}
    assert said["Oven.client.baker0.giveUp.inUse[1]"] == "client baker0 gives up waiting for service /bake"
    assert said["Oven.client.baker1.lost"] == "lost request of client baker1 of service /bake"


def test_certificates() -> None:
    net = flatten(oven(2, 1, outstanding=3, timeout=0.5), "none").net
    found = {each.name: (each.value, {term.place.id for term in each.terms}) for each in net.certificate}
    client = "Oven.client.baker0."
    assert found[f"{client}ready or 3 requests under way"] == (
        3,
        {client + part for part in ("ready", "sent", "lost", "requests", "responses", "inUse[1]")},
    )
    assert found["Oven.requests.Load + Oven.requests.Capacity"][0] == 1
    assert found["Oven.requests.Load counts requests"][1] == {
        "Oven.requests.Load",
        "Oven.late.requests",
        "Oven.client.baker0.requests",
        "Oven.client.baker1.requests",
    }


def test_clients_on_a_server_page() -> None:
    """Each instance gives up for itself, and is told for itself."""
    model = oven(1, 1)
    net = sym.NodeNet(id="shop", net=model)
    page = sym.CallbackPage(id="Sell", kind="server", page=net)
    entry, ask, got, late, exit_ = (
        sym.Place(id=f"Shop.{id}", page=page) for id in ("entry", "ask", "got", "late", "exit")
    )
    flow(entry, sym.Transition(id="Shop.order", page=page), ask)
    flow(got, sym.Transition(id="Shop.sell", page=page), exit_)
    flow(late, sym.Transition(id="Shop.sorry", page=page), exit_)
    server = sym.ServerPort(entry=entry, exit=exit_, page=page)
    shop = sym.ServiceChannel(id="Shop", service="/shop", instances=2, server=server, model=model)
    user = sym.NodeNet(id="user", net=model)
    want, have = sym.Place(id="Want", tokens=2, page=user), sym.Place(id="Have", page=user)
    shop.clients.append(sym.ClientPort(client="user", request=want, response=have, outstanding=2))
    oven_ = model.channels[0]
    assert isinstance(oven_, sym.ServiceChannel)
    oven_.clients.append(
        sym.ClientPort(client="shop", request=ask, response=got, outstanding=2, timeout=1.0, timedOut=late)
    )
    flattened = flatten(model, "none")
    (sheet,) = flattened.net.pages
    arcs = {(arc.source.id, arc.target.id) for arc in sheet.arcs}
    for number in (1, 2):
        client = f"Oven.client.Shop[{number}].shop"
        assert (f"{client}.giveUp.requests", f"Shop[{number}].Shop.late") in arcs
        ready = next(node for node in sheet.objects if node.id == f"{client}.ready")
        assert isinstance(ready, pn.Place) and ready.tokens == 2
    found = compare(plain_net_of(flattened.net), Interpreter(model), 3000)
    assert found.difference == ""


CALLBACKS = [
    Case(),
    Case(client="own", threads=2),
    Case(kind="reentrant", threads=2),
    Case(client="own", awaits=True),
    Case(client="own", threads=2, answers=True),
]


@pytest.mark.parametrize("case", CALLBACKS)
def test_callbacks_that_give_up(case: Case) -> None:
    """A callback that waits no longer continues, and no group and thread is blocked forever."""
    model = case_model(case)
    for channel in model.channels:
        assert isinstance(channel, sym.ServiceChannel)
        channel.depth = 1
        for client in channel.clients:
            client.timeout, client.timedOut = 0.5, client.response
    interpreter = ExecutorInterpreter(model)
    assert interpreter.count()[2] == 0
    for overflow in ("weighted", "inhibitor"):
        found = compare(plain_net_of(flatten(model, "none", overflow).net), interpreter, 5000)
        assert (found.difference, found.complete) == ("", True)


def test_a_lost_request_is_drawn() -> None:
    """The history is a lane of the service with its depth; the loss is marked in the client's lane."""
    (overflow,) = [found for found in check(oven(2, 1)).findings if found.rule == "queue-overflow"]
    assert overflow.witness is not None
    builder = witness_builder(overflow.witness, "oven", verdict="queue-overflow")
    history = next(lane for lane in builder.lanes.all if lane.queue == "request")
    assert (history.group, history.capacity, history.node) == ("services", 1, "oven")
    last = builder.steps[-1]
    assert last.node == "oven"
    assert [builder.lanes.all[mark[0]].id for mark in last.marks if mark[1] == "o"] == ["baker0"]


def _pile(depth: int, **more: object) -> sym.SystemModel:
    """Return a timer that sends to a service and does not wait, as `call_async` of rclpy."""
    model = sym.SystemModel(id="pile", middleware="ros2")
    mover, user = (node_net(model, id) for id in ("mover", "user"))
    mover.execution = user.execution = "callbacks"
    serve, tick, answer = (
        callback(mover, "OnMove", "server"),
        callback(user, "OnTick", "timer", timer=0.02),
        callback(user, "OnAnswer", "client"),
    )
    entry, exit_, request, response = (
        *(place(serve, "In"), place(serve, "Out")),
        *(place(tick, "Request"), place(answer, "Response")),
    )
    step(serve, "Move", [entry], [exit_])
    step(tick, "Send", [], [request])
    step(answer, "Note", [response])
    client = sym.ClientPort(client="user", request=request, response=response, **more)  # type: ignore[arg-type]
    sym.ServiceChannel(
        id="Move_",
        service="/move",
        depth=depth,
        server=sym.ServerPort(page=serve, entry=entry, exit=exit_),
        clients=[client],
        model=model,
    )
    return model


@pytest.mark.parametrize("capacity", [None, 1, 3])
def test_a_client_that_does_not_wait_piles_up_what_it_asks(capacity: int | None) -> None:
    """No capacity of its place keeps it from sending: what the service and the client do not keep is lost."""
    model = _pile(3)
    model.channels[0].clients[0].request.capacity = capacity  # type: ignore[attr-defined]
    report = check(model)
    assert [each.message for each in report.findings] == [
        "request history of service /move can overflow: a request is lost",
        "response history of client user of service /move can overflow: a response is lost",
    ]
    assert report.unknown == []


def test_one_that_says_how_many_it_has_under_way_loses_none() -> None:
    model = _pile(3, outstanding=3)
    model.channels[0].clients[0].request.capacity = 1  # type: ignore[attr-defined]
    assert check(model).findings == []


@pytest.mark.parametrize("overflow", ["weighted", "inhibitor"])
@pytest.mark.parametrize("timeout", [None, 0.5])
def test_a_net_of_a_client_that_does_not_wait(overflow: OverflowVariant, timeout: float | None) -> None:
    """With a time-out, what is lost is counted until it is given up, so that the net has no end."""
    model = _pile(1, timeout=timeout)
    found = compare(plain_net_of(flatten(model, "none", overflow).net), ExecutorInterpreter(model), 2000)
    assert (found.difference, found.complete) == ("", timeout is None)
