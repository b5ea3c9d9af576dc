"""Bounds of systems with services: no bound is below what a program finds that explores every behaviour."""

from __future__ import annotations

import os
from fractions import Fraction
from random import Random
from typing import Any

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.latencies.answers import Latencies
from dineros.metamodel import sym
from dineros.metamodel.build import callback, node_net, place, seconds, step
from dineros.metamodel.elements import channels, find
from tests.analysis.bounds.test_no_bound_is_too_low import require_above, require_kept
from tests.support.reachability import TooManyStatesError
from tests.support.timed_systems.callers import THEN, Callers
from tests.support.timed_systems.counted import COUNTED, RESPONSES
from tests.support.timed_systems.models import System, model_of

SEEDS = 60 * int(os.environ.get("DINEROS_EXAMPLES", "1"))
MOST_STATES = 8_000


def work(random: Random, most: int = 2) -> list[Any]:
    least = random.randint(0, most)
    return ["work", least, least + random.randint(0, 2)]


def drawn(seed: int) -> System:
    """Return one or two timers that call a service, and one to three callbacks in its node or another one."""
    random = Random(seed)
    callbacks: list[dict[str, Any]] = []
    callers = random.randint(1, 2)
    for number in range(callers):
        each = {
            "name": f"ask{number}",
            "node": f"n{number}",
            "group": "default",
            "offset": random.choice([0, 1, 2]),
        }
        script = [work(random, 1), ["call", "service", "answers"], work(random, 1), ["publish", f"t{number}"]]
        callbacks.append({**each, "period": random.randint(5, 14), "script": script})
    callbacks.append(
        {
            "name": "serve",
            "node": "s",
            "group": "default",
            "service": "service",
            "depth": 10,
            "script": [work(random)],
        }
    )
    for number in range(random.randint(1, 3)):
        group = random.choice(["default", "default", "g"])
        each = {"name": f"c{number}", "node": random.choice(["s", "s", "n0"]), "group": group}
        each["script"] = [work(random), ["publish", f"u{number}"]]
        if random.random() < 0.5:
            each |= {"period": random.randint(5, 14), "offset": random.choice([0, 1])}
        else:
            each |= {"topic": f"t{random.randrange(callers)}", "depth": random.randint(1, 3)}
        callbacks.append(each)
    nodes = {f"n{number}": {"threads": 2} for number in range(callers)}
    nodes["s"] = {"threads": random.choice([1, 1, 2])}
    spans = [(0, 0), (0, 1), (1, 1), (0, 3)]
    names = [f"t{number}" for number in range(callers)] + [f"u{number}" for number in range(3)]
    latency = {name: random.choice(spans) for name in [*names, "service"]}
    return {"nodes": nodes, "latency": latency, "chains": [], "callbacks": callbacks}


def test_in_any_order() -> None:
    bounded = servers = systems = 0
    for seed in range(SEEDS):
        system = drawn(seed)
        try:
            facts = Callers(system).explore(MOST_STATES)
        except TooManyStatesError:
            continue
        systems += 1
        found = Bounds(model_of(system, 0.01)).everything()
        require_kept(found, facts.longest, facts.lost, facts.missed)
        for name, span in facts.response.items():
            if name.startswith("ask"):
                assert name.endswith(THEN) or found.callbacks[name].greatest is None
                continue
            is_bounded = require_above(found.callbacks[name], *span)
            bounded += is_bounded
            servers += is_bounded and name == "serve"
    assert systems > SEEDS / 3 and bounded > systems and servers > systems / 2, (systems, bounded, servers)


@pytest.mark.parametrize("number", [15, 16])
def test_counted_systems(number: int) -> None:
    facts = Callers(COUNTED[number].system).explore(MOST_STATES)
    found = Bounds(model_of(COUNTED[number].system, 0.01)).everything()
    for name, span in RESPONSES[number].items():
        assert facts.response[name] == span
        assert require_above(found.callbacks[name], *span)


def asked(change: str) -> str | Fraction:
    """Return a bound of the server of system 15 after a change, in units, or why there is none."""
    model = model_of(COUNTED[15].system, 0.01)
    (service,) = channels(model, sym.ServiceChannel)
    client = service.clients[0]
    page = find(model, "look")
    assert isinstance(page, sym.CallbackPage)
    match change:
        case "time-out":
            client.timeout = 1.0
        case "latency":
            service.latency = None
        case "reentrant":
            node = page.page
            assert isinstance(node, sym.NodeNet)
            node.executor, node.threads = sym.Executor.multi, 2
            page.group = sym.CallbackGroup(id="free", name="free", kind="reentrant")
            node.callbackGroups.append(page.group)
        case "period":
            caller = find(model, "ask")
            assert isinstance(caller, sym.CallbackPage)
            caller.timer = None
        case "tokens":
            service.server.exit.incoming[0].weight = 2
    found = Bounds(model).everything().callbacks["look"]
    return found.reason if found.greatest is None else found.greatest.value * 100


def test_what_is_not_bounded_is_named() -> None:
    assert asked("time-out") == "client ask.1 of service look can time out and repeat its request"
    assert asked("tokens") == "callback look does not give one response to each request"
    assert "instance of its server" in str(asked("reentrant"))


def test_a_client_that_waits_has_one_request_under_way() -> None:
    assert asked("") == asked("latency") == asked("period") == 4


@pytest.mark.parametrize(("timeout", "is_kept"), [(None, True), (1.0, False)])
def test_what_a_server_without_a_bound_gets_is_what_its_clients_have_under_way(
    timeout: float | None, is_kept: bool
) -> None:
    """Requests wait as long as the server's node is overloaded; there are never more than that."""
    model = model_of(COUNTED[15].system, 0.01)
    (service,) = channels(model, sym.ServiceChannel)
    service.clients[0].timeout = timeout
    page = find(model, "look")
    assert isinstance(page, sym.CallbackPage) and isinstance(page.page, sym.NodeNet)
    busy = callback(page.page, "busy", "timer")
    busy.timer, busy.duration = 0.01, seconds(0.02, 0.02)
    step(busy, "works", [], [])
    found = Bounds(model).everything()
    assert found.callbacks["look"].greatest is None
    longest, overflows = found.readers[str(service.server.entry.id)]
    assert (longest, overflows) == ((1, False) if is_kept else (service.depth, None))


def with_goals(threads: int, slots: int) -> sym.SystemModel:
    """Return a node that works on goals without end and has a timer, and a node that sends goals."""
    model = sym.SystemModel(id="robot", middleware="ros2")
    server = node_net(model, "server", execution="callbacks", threads=threads)
    page = callback(server, "work", "goal")
    page.group = sym.CallbackGroup(id="free", name="free", kind="reentrant")
    server.callbackGroups.append(page.group)
    page.duration = seconds(0.03, 0.03)
    entry, done = place(page, "entry"), place(page, "done")
    step(page, "do", [entry], [done])
    tick = callback(server, "tick", "timer")
    tick.timer, tick.offset, tick.duration = 0.05, seconds(0, 0), seconds(0.01, 0.02)
    step(tick, "ticks", [], [])
    action = sym.ActionChannel(id="go", action="/go", instances=slots, latency=seconds(0, 0), model=model)
    action.server = sym.ActionServerPort(page=page, entry=entry, succeeded=done)
    for number in range(2):
        client = node_net(model, f"client{number}", execution="callbacks")
        asks = callback(client, f"asks{number}", "timer")
        asks.timer, asks.offset, asks.duration = 0.1, seconds(0.04, 0.04), seconds(0, 0)
        goal, result = place(asks, f"goal{number}"), place(asks, f"result{number}")
        step(asks, f"sends{number}", [], [goal])
        step(asks, f"takes{number}", [result], [])
        action.clients.append(sym.ActionClientPort(client=f"c{number}", goal=goal, succeeded=result))
    return model


@pytest.mark.parametrize(("threads", "slots", "most"), [(2, 1, 2), (2, 2, None), (3, 2, 2), (1, 1, None)])
def test_what_works_on_goals_has_a_thread_for_each_of_its_slots(
    threads: int, slots: int, most: int | None
) -> None:
    model = with_goals(threads, slots)
    found = Bounds(model).everything().callbacks["tick"].greatest
    assert (found and found.value * 100) == most
    searched = Latencies(model, Budget(seconds=60)).everything().callbacks["tick"].greatest
    if most is None:
        assert searched is None or searched.value * 100 > 2
    else:
        assert searched is not None and searched.value * 100 == most
