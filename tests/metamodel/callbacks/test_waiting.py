"""Which clients wait: one request under way where the net orders them, any number elsewhere."""

from __future__ import annotations

import pytest

from dineros.analysis.checks.boundedness import Boundedness
from dineros.analysis.checks.check import check
from dineros.analysis.checks.overflow import Overflow
from dineros.metamodel import sym
from dineros.metamodel.build import callback, flow, here, node_net, place, step
from dineros.metamodel.callbacks.groups import callback_page_of
from dineros.metamodel.callbacks.under_way import outstanding, outstanding_counts
from dineros.metamodel.callbacks.waiting import Waiting
from dineros.metamodel.calls import UNLIMITED
from dineros.metamodel.elements import channels, node_net_of
from tests.support.references.waiting import outstanding_of
from tests.support.timed_systems.goals.calls import GoalCalls


def _system(execution: str = "callbacks", middleware: str = "ros2") -> tuple[sym.SystemModel, sym.NodeNet]:
    """Return a system with a service, and the node net of its client."""
    model = sym.SystemModel(id="system", middleware=middleware)
    server = node_net(model, "server")
    serve = callback(server, "Serve", "server")
    entry, exit_ = place(serve, "Entry"), place(serve, "Exit")
    step(serve, "Work", [entry], [exit_])
    sym.ServiceChannel(
        id="Ask", service="/ask", server=sym.ServerPort(page=serve, entry=entry, exit=exit_), model=model
    )
    user = node_net(model, "user")
    user.execution = execution
    return model, user


def _client(model: sym.SystemModel, request: sym.Place, response: sym.Place) -> sym.ClientPort:
    port = sym.ClientPort(client="user", request=request, response=response)
    model.channels[0].clients.append(port)  # type: ignore[attr-defined]
    return port


def _sends(execution: str = "callbacks", middleware: str = "ros2") -> sym.ClientPort:
    """A timer sends, and another callback has the response."""
    model, user = _system(execution, middleware)
    tick, answer = callback(user, "Tick", "timer", timer=0.1), callback(user, "Answer", "client")
    request, response = place(tick, "Request"), place(answer, "Response")
    step(tick, "Send", [], [request])
    step(answer, "Note", [response])
    return _client(model, request, response)


def _ends_first() -> sym.ClientPort:
    """The response comes to the page that asks, which may end without it."""
    model, user = _system()
    tick = callback(user, "Tick", "timer", timer=0.1)
    request, response, asked = place(tick, "Request"), place(tick, "Response"), place(tick, "Asked")
    step(tick, "Send", [], [request, asked])
    end = step(tick, "End", [asked])
    end.kind = sym.TransitionKind.end
    step(tick, "Note", [response])
    return _client(model, request, response)


def _calls() -> sym.ClientPort:
    """A timer's callback calls, and waits for the response."""
    model, user = _system()
    tick = callback(user, "Tick", "timer", timer=0.1)
    request, response, waits = place(tick, "Request"), place(tick, "Response"), place(tick, "Waits")
    step(tick, "Call", [], [request, waits])
    step(tick, "Has", [response, waits])
    return _client(model, request, response)


def _calls_again_and_again() -> sym.ClientPort:
    """A callback may call any number of times, and continues with each response."""
    model, user = _system()
    tick = callback(user, "Tick", "timer", timer=0.1)
    request, response, runs = place(tick, "Request"), place(tick, "Response"), place(tick, "Runs")
    step(tick, "Begin", [], [runs]).kind = sym.TransitionKind.start
    step(tick, "Call", [runs], [request])
    step(tick, "Has", [response], [runs])
    step(tick, "End", [runs]).kind = sym.TransitionKind.end
    return _client(model, request, response)


def _asks_twice() -> sym.ClientPort:
    """A callback sends two requests, and waits for both responses."""
    model, user = _system()
    tick = callback(user, "Tick", "timer", timer=0.1)
    request, response, waits = place(tick, "Request"), place(tick, "Response"), place(tick, "Waits")
    begin = step(tick, "Send", [], [waits])
    flow(begin, request, weight=2)
    end = step(tick, "Has", [waits])
    flow(response, end, weight=2)
    return _client(model, request, response)


def _one_in_flight() -> sym.ClientPort:
    """A program that sends only while it has no request under way."""
    client = _sends()
    tick, answer = client.request.page, client.response.page
    assert tick is not None and answer is not None
    user = tick.page
    assert isinstance(user, sym.NodeNet)
    free = place(user, "Free", tokens=1)
    (send,) = (each for each in tick.objects if isinstance(each, sym.Transition))
    (note,) = (each for each in answer.objects if isinstance(each, sym.Transition))
    flow(here(free, tick), send)
    flow(note, here(free, answer))
    return client


def _two_in_flight() -> sym.ClientPort:
    client = _one_in_flight()
    node = client.request.page.page  # type: ignore[union-attr]
    (free,) = (each for each in node.objects if isinstance(each, sym.Place))  # type: ignore[union-attr]
    free.tokens = 2
    return client


def _once() -> sym.ClientPort:
    """A program that sends a single request."""
    client = _sends()
    tick = client.request.page
    assert tick is not None
    (send,) = (each for each in tick.objects if isinstance(each, sym.Transition))
    flow(place(tick, "Once", tokens=1), send)
    return client


CASES = {
    "sends": (_sends, UNLIMITED),
    "ends without the response on its page": (_ends_first, UNLIMITED),
    "calls": (_calls, 1),
    "calls any number of times": (_calls_again_and_again, 1),
    "asks twice": (_asks_twice, UNLIMITED),
    "one in flight": (_one_in_flight, 1),
    "two in flight": (_two_in_flight, UNLIMITED),
    "once": (_once, 1),
    "run by our engine": (lambda: _sends("net"), 1),
    "with calls that block": (lambda: _sends(middleware="ros1"), 1),
}


@pytest.mark.parametrize("name", CASES)
def test_who_waits(name: str) -> None:
    make, expected = CASES[name]
    client = make()
    assert outstanding(client) == expected
    if name != "with calls that block":
        assert client.channel is not None and client.channel.model is not None
        assert outstanding_counts(client.channel.model) == outstanding_of(client.channel.model)


@pytest.mark.parametrize(
    ("kind", "threads", "awaits", "number"),
    [
        ("exclusive", 2, False, 1),
        ("exclusive", 2, True, 1),
        ("reentrant", 1, False, 1),
        ("reentrant", 1, True, UNLIMITED),
        ("reentrant", 2, False, UNLIMITED),
    ],
)
def test_runs_that_overlap_send_more(kind: str, threads: int, awaits: bool, number: int) -> None:
    """Each run waits for its own answer; of services, only runs that hold no thread are counted.

    Seen with rclpy (timer 0.1 s, answer after 0.6 s): reentrant, `async def`, one thread: 7 under way
    at once; exclusive: 1.
    """
    port = _calls()
    page, node = callback_page_of(port.request), node_net_of(port.request)
    model = port.channel.model if port.channel is not None else None
    assert page is not None and node is not None and model is not None
    group = sym.CallbackGroup(id="group", kind=kind)
    node.callbackGroups.append(group)
    page.group, page.awaits = group, awaits
    node.executor, node.threads = "multi", threads
    assert Waiting(model, runs_overlap=True).waits(port) is (number == 1)
    assert outstanding(port) == outstanding_of(model)[port] == (number if awaits else 1)


@pytest.mark.parametrize("said", [1, 3, UNLIMITED])
def test_what_is_said_holds(said: int) -> None:
    for make in (_sends, _calls):
        client = make()
        client.outstanding = said
        assert outstanding(client) == said


@pytest.mark.parametrize(("is_shared", "number"), [(True, 2), (False, 1)])
def test_slots_that_share_the_places_of_a_call_ask_side_by_side(is_shared: bool, number: int) -> None:
    """Also without times: the second request may arrive before the first one is read."""
    model = GoalCalls(2, 0, (0, 1), (0, 1), (1, 2), 2).model(is_shared)
    (service,) = channels(model, sym.ServiceChannel)
    service.depth = 1
    assert list(outstanding_counts(model).values()) == [number]
    found = [each.message for each in check(model, questions=(Boundedness(), Overflow())).findings]
    assert any("request history of service /look can overflow" in each for each in found)
